"""Time-stepping methods nobody presses with: what the charts compare the product with."""

"""Time-stepping methods that do not ship: what the charts compare the method of the product with."""

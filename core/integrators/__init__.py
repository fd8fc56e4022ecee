"""Ways to step the one right-hand side. Each is `step(model, state, touches, dt) -> impulses`."""

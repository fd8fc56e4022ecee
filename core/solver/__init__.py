"""Ways to step the one right-hand side. Each is `run(model, state, path, *, tick, substeps) -> impulses`."""

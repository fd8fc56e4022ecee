"""What owns the state of a body and steps it.

motion (what goes into a call and comes out), backend (native core or numpy), twin (the numpy implementation),
semi_implicit (its method), ticks, path.

A method is `run(model, state, path, *, tick, substeps) -> impulses`; those that do not ship are in studies/methods.
"""

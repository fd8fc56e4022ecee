"""What owns the state of a body and steps it, and where a body comes to rest.

stepping: motion (what goes into a call and comes out), backend (native core or numpy), twin (the numpy implementation),
semi_implicit (its method), ticks, path.
equilibrium: newton, tangent (the linear system), cached, equilibrium.

A method is `run(model, state, path, *, tick, substeps) -> impulses`; those that do not ship are in studies/methods.
"""

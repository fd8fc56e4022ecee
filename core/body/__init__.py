"""The laws of a body, one file each, and the model that puts them together.

A law is its parameters as a frozen record, then energy and force: springs, shape_matching, pressure. maps are what is
painted, estimate finds constants without a press, on_mesh spreads them, stability_bound limits the step, and model puts
all together. lattice and modes are the body as a solid that sways.

Positions and velocities inside the laws are component-major, (3, n): each component is one contiguous run.
`force` is minus the gradient of `energy`; studies/methods/tangent.py has its derivatives.
"""

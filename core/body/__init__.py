"""The laws of a body, one file each, and the model that puts them together.

A law is its parameters as a frozen record, then energy and force: springs, shape_matching, pressure.
estimate finds the constants of a model without a press; model builds it.

Positions and velocities inside the laws are component-major, (3, n): each component is one contiguous run.
`force` is minus the gradient of `energy`; studies/methods/tangent.py has its derivatives.
"""

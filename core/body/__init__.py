"""The forces on a body, one file a law: parameters as a frozen record, then energy, force, stiffness_product.

Positions and velocities inside the laws are component-major, (3, n): each component is one contiguous run.
`force` is minus the gradient of `energy`; `stiffness_product` is minus its derivative along a displacement.
"""

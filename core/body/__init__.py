"""The forces on a body, one file a law: parameters as a frozen record, then energy and force.

Positions and velocities inside the laws are component-major, (3, n): each component is one contiguous run.
`force` is minus the gradient of `energy`; solver/tangent.py has its derivatives.
"""

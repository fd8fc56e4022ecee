"""The laws of a body, one file each, and the model that combines them.

A law (springs, shape_matching, pressure) is a frozen record of its parameters, with its energy and its static force.
estimate turns the constants of a material into those of the laws, on_mesh distributes them over a mesh, with the
painted maps, and frequency_bounds and time_step limit the step. model combines everything. lattice and modes describe
how the whole body sways.

Positions and velocities are stored by component, (3, n). `force` is minus the gradient of `energy`. The C core computes
the forces of a running body, as studies/reference/laws.py does in numpy.
"""

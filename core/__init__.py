"""The physics of Dimple, without Blender, in SI units.

mesh: the surface at rest. body: the laws, and the model made of them. solver and native: what goes into a step and
comes out of it, and the C that does it. reduction: proxies, and the planner that chooses one. session and poke: what
the operators use. calibration: from an instrument's file to a material. device: haptic devices that render the force.
"""

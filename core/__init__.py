"""The physics of Dimple, without Blender, in SI units.

mesh: the surface at rest. body: the laws, and the model made of them. native: what goes into a step and comes out of
it, and the C that does it. reduction: proxies, and the rule that chooses. session, poke, world, recording: what the
operators use. calibration: from an instrument's file to a material. device: haptic devices that render the force.
"""

"""The physics of Dimple, without Blender, in SI units.

material, fills, other_tip: the measured law. everyday_presets: objects that are known. mesh: the surface at rest.
body: the laws of the shape, and its modes. native: what goes into a step and comes out of it, and the C that does it.
reduction: proxies, and the rule that chooses. session, poke, world, recording: what the operators use. fields: what is
colored. calibration: from an instrument's file to a material. device: haptic devices that render the force. experiment:
the sensory comparison. messages: sentences for the artist, as templates and values.
"""

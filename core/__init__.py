"""The physics of Dimple, without Blender, in SI units.

material, fills, other_tip: the measured law. everyday_presets: known objects. mesh: the surface at rest. body: the laws
of the shape, and its modes. native: the C core, its input and its output. reduction: proxies, and the rule that chooses
one. session, poke, world, recording: the front of the core for the operators. fields: quantities shown as colors.
calibration: from an instrument's file to a material. device: haptic devices. experiment: the sensory comparison.
messages: texts for the artist, as templates and values.
"""

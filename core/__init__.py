"""The physics of Dimple: bpy-free, in SI units."""

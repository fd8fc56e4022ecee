"""Blender's objects and the core: meshes, materials, modifiers and files, read and written here alone."""

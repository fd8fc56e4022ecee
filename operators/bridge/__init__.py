"""Blender's objects and the core: read and written here.

scene_objects reads a body, body_model its materials and pins, final_mesh its surface after all modifiers; write_back
keeps a press; offset is the modifier that shows one. modifiers says what a stack does, advice what an artist should
know, timeline how late it is, cache_files where bakes lie, keyframes what they leave as curves.
"""

"""The bridge that reads Blender's objects for the core and writes them.

scene_objects reads a body, body_model its materials and pins, final_mesh its surface after all modifiers; offset is the
modifier that shows a press, and write_back keeps one. modifiers classifies a modifier stack, advice informs the artist,
timeline is the clock, cache_files finds and plays bakes, and keyframes draws their curves.
"""

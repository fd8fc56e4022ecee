"""Pressing live.

A press is started by make_soft, poke, play, scripted_press or progress (large meshes), and steered by poke_input.
sessions holds the running sessions, live_step steps them, showing displays them on their objects, modal_runs drives
them, handlers end them. object_plan chooses between mesh and proxy; follow_settings applies changes of panels and
keyframes; colliders and props handle contact; fingertip_objects and haptic_fingertips are the fingertips; last_press
remembers the last press by hand.
"""

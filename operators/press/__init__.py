"""Pressing live.

Started by make_soft, poke, play, scripted_press or progress (large meshes), steered by poke_input. sessions holds what
runs, live_step steps it, showing puts it on its objects, modal_runs drives it, handlers end it. object_plan takes mesh
or proxy; follow_settings follows the panels and keyframes; colliders and props are what bodies meet; fingertip_objects
and haptic_fingertips press; record and recorder keep what was pressed.
"""

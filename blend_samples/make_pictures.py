"""Make the pictures of the materials (`python3 dev.py samples`): one ball of each, pressed with the same 5 N."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

PICTURES = Path(__file__).parents[1] / "addon" / "pictures"
SIDE = 256  # [px] of a picture, as Blender shows previews
SAMPLES = 32
SUBDIVISIONS = 6  # of the icosphere: edges of 0.7 mm
BALL, FINGERTIP, FORCE = 0.04, 0.010, 5.0  # [m] radii, [N]
SETTLED_S = 1.5
SCALE = 20.0  # of the rendered scene: Cycles is inaccurate for tiny objects
FLOOR = (0.55, 0.57, 0.60)
ELEVATION = 22.0  # [degrees] of the camera
# place and size of each lamp [radii of the ball], and its brightness
LAMPS = (((-3.0, -2.4, 3.9), 3.6, 210.0), ((4.2, 1.5, 2.7), 1.5, 150.0), ((1.8, -4.8, 0.6), 6.0, 50.0))

# colour, roughness and transmission of each material
LOOKS = {
    "pillow": ((0.86, 0.86, 0.90), 0.95, 0.0),
    "sofa_foam": ((0.55, 0.22, 0.20), 0.95, 0.0),
    "dough": ((0.83, 0.68, 0.45), 0.70, 0.0),
    "chair_foam": ((0.10, 0.13, 0.18), 0.90, 0.0),
    "kitchen_sponge": ((0.90, 0.68, 0.05), 0.95, 0.0),
    "party_balloon": ((0.80, 0.03, 0.05), 0.12, 0.0),
    "hot_water_bottle": ((0.60, 0.05, 0.09), 0.40, 0.0),
    "marshmallow": ((0.92, 0.66, 0.70), 0.85, 0.0),
    "skin": ((0.85, 0.52, 0.40), 0.45, 0.0),
    "jelly": ((0.85, 0.10, 0.02), 0.05, 0.9),
    "object_1_nylon_air": ((0.80, 0.25, 0.13), 0.35, 0.0),
    "object_2_vinyl_air": ((0.10, 0.36, 0.70), 0.25, 0.0),
    "object_3_vinyl_water": ((0.08, 0.50, 0.45), 0.15, 0.4),
    "ecoflex_00_10": ((0.80, 0.78, 0.70), 0.30, 0.5),
    "flesh": ((0.52, 0.12, 0.10), 0.35, 0.0),
    "stress_ball": ((0.35, 0.62, 0.10), 0.60, 0.0),
    "ecoflex_00_30": ((0.62, 0.72, 0.75), 0.30, 0.5),
    "squash_ball": ((0.03, 0.03, 0.035), 0.50, 0.0),
    "beach_volleyball": ((0.93, 0.72, 0.08), 0.40, 0.0),
    "dragon_skin_10": ((0.70, 0.60, 0.72), 0.30, 0.4),
    "volleyball": ((0.85, 0.85, 0.80), 0.40, 0.0),
    "tennis_ball": ((0.62, 0.80, 0.05), 0.95, 0.0),
    "football": ((0.90, 0.90, 0.90), 0.25, 0.0),
}


def pictures() -> None:
    """Press and render a ball of every preset."""
    from bl_ext.user_default.dimple.core.everyday_presets import OBJECTS

    PICTURES.mkdir(exist_ok=True)
    for old in PICTURES.glob("*.webp"):
        old.unlink()
    ball, tip = stage()
    rest = np.empty(3 * len(ball.data.vertices), np.float32)
    ball.data.vertices.foreach_get("co", rest)
    for preset in OBJECTS:
        shape(ball, rest)
        body = pressed(ball, preset.name)
        shape(ball, body.positions())
        tip.location.z = SCALE * (BALL + FINGERTIP - body.depth)
        paint(ball.active_material, *LOOKS[preset.name])
        bpy.context.scene.render.filepath = str(PICTURES / f"{preset.name}.webp")
        bpy.ops.render.render(write_still=True)


def shape(ball: bpy.types.Object, points: Any) -> None:
    """Move the vertices of a ball to points (n, 3)."""
    ball.data.vertices.foreach_set("co", np.ravel(points))
    ball.data.update()


def pressed(ball: bpy.types.Object, preset: str) -> Any:
    """Return the body of a ball of a preset in which the fingertip has come to rest."""
    from bl_ext.user_default.dimple import Body
    from bl_ext.user_default.dimple.core.session import Finger

    bpy.context.view_layer.objects.active = ball
    bpy.context.object.dimple.material = preset
    ball.dimple.size_mm, ball.dimple.simulated = 2e3 * BALL, "MESH"
    body = Body.from_object(ball)
    body.session.set_fingers([Finger((0.0, 0.0, BALL + FINGERTIP), FINGERTIP, FORCE)])
    body.step(SETTLED_S)
    return body


def stage() -> tuple[bpy.types.Object, bpy.types.Object]:
    """Empty the file and set up ball, fingertip, floor, lights and camera; return the first two."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=SUBDIVISIONS, radius=BALL * SCALE)
    ball = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(radius=FINGERTIP * SCALE, segments=64, ring_count=32)
    tip = bpy.context.object
    bpy.ops.mesh.primitive_plane_add(size=40 * BALL * SCALE, location=(0, 0, -BALL * SCALE))
    floor = bpy.context.object
    for thing, name in ((ball, "Ball"), (tip, "Tip"), (floor, "Floor")):
        thing.data.shade_smooth()
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        thing.data.materials.append(material)
    paint(tip.active_material, (0.95, 0.30, 0.02), 0.30, 0.0)  # as the overlay draws it
    paint(floor.active_material, FLOOR, 0.80, 0.0)
    aim, distance, rise = Vector((0, 0, 0.22)) * BALL * SCALE, 6.3 * BALL * SCALE, math.radians(ELEVATION)
    way = Vector((0.0, -math.cos(rise), math.sin(rise)))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.data.lens = aim + distance * way, 85
    camera.rotation_euler = (-way).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    for place, size, energy in LAMPS:
        lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
        lamp.location = Vector(place) * BALL * SCALE
        lamp.rotation_euler = (lamp.location - aim).to_track_quat("Z", "Y").to_euler()
        lamp.data.size, lamp.data.energy = size * BALL * SCALE, energy * (BALL * SCALE) ** 2
        scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.12, 0.12, 0.13)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", SAMPLES, True
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "WEBP", 85
    scene.view_settings.view_transform = "Standard"
    return ball, tip


def paint(material: bpy.types.Material, colour: tuple[float, float, float], roughness: float, through: float) -> None:
    """Give a material its look."""
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Transmission Weight"].default_value = through

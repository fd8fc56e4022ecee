"""Make the README's looping picture (`python3 dev.py samples`): a finger presses Suzanne, and lets go."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from make_pictures import paint
from mathutils import Vector

PRESS = Path(__file__).with_name("press.webp")
SIZE, SCALE = 0.165, 12.0  # [m] of the head; of the rendered scene: Cycles is inaccurate for tiny objects
FINGER, DEPTH = 0.012, 0.026  # [m] its radius, depth of the press
LONG = 7.0  # radii of the finger that are seen
PLACE, WAY = (-0.026, -0.040, 0.045), (0.40, 0.62, -0.68)  # [m] on the forehead; inwards
LEANS = (0.72, 0.10, 0.69)  # the way of the finger behind its tip
# share of the depth at each frame: in, held, out, and the skin that comes back
DOWN = np.sin(np.linspace(0.0, np.pi / 2, 11)).tolist()
COURSE = (*DOWN, 1.0, 1.0, 1.0, 0.9, 0.65, 0.35, 0.0, -0.25, -0.45, *[-0.6] * 5)
FRAME_S = 1 / 24
SHOWN_MS = 55  # of each picture: a little slower than it was
# place and size of each lamp [sizes of the head], and its brightness
LAMPS = (((-2.6, -0.6, 2.4), 1.2, 300.0), ((2.0, -1.6, 0.6), 2.5, 60.0), ((0.8, 2.4, 1.8), 1.0, 160.0))
PIXELS, SAMPLES = (560, 420), 32


def press_picture() -> None:
    """Simulate, render and join the pictures."""
    from PIL import Image

    head, finger = stage()
    frames = simulated(head)
    with tempfile.TemporaryDirectory() as folder:
        images = []
        for number, (skin, place) in enumerate(frames):
            head.data.vertices.foreach_set("co", (SCALE * skin).ravel())
            head.data.update()
            finger.location = SCALE * Vector(place)
            bpy.context.scene.render.filepath = f"{folder}/{number:03}.png"
            bpy.ops.render.render(write_still=True)
            images.append(Image.open(f"{folder}/{number:03}.png").convert("RGB"))
        images[0].save(PRESS, save_all=True, append_images=images[1:], duration=SHOWN_MS, loop=0, quality=80, method=6)


def simulated(head: bpy.types.Object) -> list[tuple[Any, Any]]:
    """Return where the vertices (n, 3) of the head and the fingertip's centre (3,) are in each frame [m]."""
    from bl_ext.user_default.dimple import Body
    from bl_ext.user_default.dimple.core.mesh.ray import ray_hit
    from bl_ext.user_default.dimple.core.session import Finger

    bpy.context.view_layer.objects.active = head
    bpy.context.object.dimple.material = "marshmallow"
    head.dimple.size_mm, head.dimple.simulated = 1e3 * SIZE, "MESH"
    session = Body.from_object(head).session
    mesh = session.model.mesh
    way = np.array(WAY) / np.linalg.norm(WAY)
    start = np.array(PLACE) - SIZE * way
    hit = ray_hit(tuple(start.tolist()), tuple(way.tolist()), mesh.rest_positions, mesh.triangles)
    touching, found = np.array(hit[1]) - FINGER * way, []
    for share in COURSE:
        place = touching + share * DEPTH * way
        session.set_fingers([Finger(tuple(place.tolist()), FINGER)])
        session.step(FRAME_S)
        found.append((session.positions(), place.tolist()))
    return found


def stage() -> tuple[bpy.types.Object, bpy.types.Object]:
    """Empty the file and set up head, finger, lights and camera; return the first two."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_monkey_add()
    head = bpy.context.object
    head.modifiers.new("Subdivision", "SUBSURF").levels = 3
    bpy.ops.object.convert(target="MESH")
    head.data.transform(head.matrix_world.inverted())
    size = max(head.dimensions)
    for vertex in head.data.vertices:
        vertex.co *= SCALE * SIZE / size
    head.data.shade_smooth()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=SCALE * FINGER)
    finger = bpy.context.object
    for vertex in finger.data.vertices:  # a capsule along its z
        vertex.co.z += SCALE * LONG * FINGER if vertex.co.z > 0 else 0.0
    finger.data.shade_smooth()
    finger.rotation_euler = Vector(LEANS).to_track_quat("Z", "Y").to_euler()
    for thing, name in ((head, "Head"), (finger, "Finger")):
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        thing.data.materials.append(material)
    paint(head.active_material, (0.86, 0.42, 0.44), 0.55, 0.0)
    paint(finger.active_material, (0.93, 0.80, 0.70), 0.45, 0.0)
    aim, way = SCALE * SIZE * Vector((0.0, 0.0, 0.08)), Vector((-0.62, -1.0, 0.42)).normalized()
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.data.lens = aim + SCALE * SIZE * 2.7 * way, 85
    camera.rotation_euler = (-way).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    for place, size, energy in LAMPS:
        lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
        lamp.location = SCALE * SIZE * Vector(place)
        lamp.rotation_euler = (lamp.location - aim).to_track_quat("Z", "Y").to_euler()
        lamp.data.size, lamp.data.energy = size * SCALE * SIZE, energy * (SCALE * SIZE / 2) ** 2
        scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.30, 0.33, 0.38)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", SAMPLES, True
    scene.render.resolution_x, scene.render.resolution_y = PIXELS
    scene.view_settings.view_transform = "Standard"
    return head, finger

"""Make the samples and the pictures of the materials (`python3 dev.py samples`), in the oldest Blender."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
from make_pictures import pictures
from make_press import press_picture
from mathutils import Vector
from scene_parts import frame, install, key_press, look, painted, press_ball, save

HERE = Path(__file__).parent
FINGERTIP_MM = 10.0
CUT_MM = 0.49 * FINGERTIP_MM  # edges, fine enough for the dent to be round
FEWEST = 14  # cells a side of a small cube: with more it would not be simulated itself beside the others, live


def three_objects() -> None:
    """Table 1's cubes with Table 2's constants, side by side at their real size, each under its own fingertip."""
    scene = look(distance=0.80, aim=(0.0, -0.03, 0.06), elevation=33, floor=True)
    objects = (
        ("Object 1 nylon air", "object_1_nylon_air", 0.050, (-0.03, -0.175), (0.80, 0.25, 0.13), 22.0),
        ("Object 2 vinyl air", "object_2_vinyl_air", 0.165, (-0.115, 0.0), (0.13, 0.42, 0.75), 24.4),
        ("Object 3 vinyl water", "object_3_vinyl_water", 0.165, (0.105, 0.0), (0.16, 0.58, 0.45), 20.0),
    )
    for number, (name, preset, edge, (x, y), colour, depth) in enumerate(objects, 1):
        body = soft_cube(name, edge, max(FEWEST, round(edge / CUT_MM * 1e3)), Vector((x, y, edge / 2)))
        body.data.materials.append(painted(name, colour))
        bpy.context.object.dimple.material = preset
        body.dimple.enabled = True
        tip = press_ball(number, FINGERTIP_MM / 1e3)
        top = Vector((x + 0.1 * edge, y - 0.12 * edge, edge + FINGERTIP_MM / 1e3))
        key_press(tip, top, Vector((0.0, 0.0, -depth / 1e3)))
        setattr(scene.dimple, f"finger_{number}", tip)
    scene.dimple.finger_radius_mm = FINGERTIP_MM
    choose(body)
    frame(centre=(0.0, -0.03, 0.08), distance=0.75)
    save(HERE / "three_objects.blend")


def suzanne() -> None:
    """Make a soft monkey head as large as a child's ball, pinned at the neck; a fingertip presses its forehead."""
    scene = look(distance=0.56, aim=(0.0, 0.0, 0.11), elevation=24, floor=False)
    bpy.ops.mesh.primitive_monkey_add(size=0.19, location=(0.0, 0.0, 0.1))
    head = bpy.context.object
    head.name = head.data.name = "Suzanne"
    head.data.materials.append(painted("Soft rubber", (0.78, 0.46, 0.22)))
    # finer than the fingertip, so that the dent is its own and not the mesh's
    head.modifiers.new("Finer", "SUBSURF").levels = 1
    bpy.ops.object.modifier_apply(modifier="Finer")
    head.data.shade_smooth()
    bpy.context.object.dimple.material = "object_2_vinyl_air"
    constants = head.data.materials[0].dimple
    constants.mass_from, constants.mass_kg = "MASS", 0.3
    head.dimple.size_mode = "REAL"
    # the neck is the back of the head below its middle
    back = max(vertex.co.y for vertex in head.data.vertices)
    neck = head.vertex_groups.new(name="Neck")
    neck.add([v.index for v in head.data.vertices if v.co.y > 0.4 * back and v.co.z < 0.15 * back], 1.0, "ADD")
    head.dimple.pin_group, head.dimple.enabled = neck.name, True
    head.modifiers.new("Smooth", "SUBSURF").levels = 1
    tip = press_ball(1, FINGERTIP_MM / 1e3)
    hit, place, normal, _ = head.ray_cast(Vector((0.012, -1.0, 0.0655)), Vector((0.0, 1.0, 0.0)))
    assert hit
    touch = head.matrix_world @ (place + normal * FINGERTIP_MM / 1e3)
    key_press(tip, touch, -normal * 0.022)
    scene.dimple.finger_1 = tip
    scene.dimple.finger_radius_mm = FINGERTIP_MM
    choose(head)
    frame(centre=(0.0, 0.0, 0.11), distance=0.52)
    save(HERE / "suzanne.blend")


def choose(body: bpy.types.Object) -> None:
    """Select a body alone, so that whoever opens the file can press it."""
    bpy.ops.object.select_all(action="DESELECT")
    body.select_set(True)
    bpy.context.view_layer.objects.active = body


def soft_cube(name: str, edge: float, cells: int, place: Vector) -> bpy.types.Object:
    """Add a cube of cells x cells squares a side, its edges sharp."""
    bpy.ops.mesh.primitive_cube_add(size=edge, location=place)
    body = bpy.context.object
    body.name = body.data.name = name
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=cells - 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    body.data.shade_smooth()
    body.data.set_sharp_from_angle(angle=math.radians(60))
    return body


if __name__ == "__main__":
    install()
    three_objects()
    suzanne()
    pictures()
    press_picture()

"""What the samples and the demo share: installing the zip, a stage to look at, fingertips that press."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import bpy
from mathutils import Vector

RATE = 24  # frames a second
# frames of a press: touch, all the way down, still held, off again, and time to come to rest
TOUCH, DOWN, HELD, OFF, REST = 3, 13, 20, 28, 38


def install() -> argparse.Namespace:
    """Install the zip named on the command line through Blender's own installer and switch it on."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--zip", type=Path, required=True)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    bpy.ops.extensions.package_install_files(
        filepath=str(options.zip.resolve()), repo="user_default", enable_on_install=True
    )
    return options


def look(*, distance: float, aim: Sequence[float], elevation: float, floor: bool) -> bpy.types.Scene:
    """Empty the file and set a stage: camera, light, background, 24 frames a second."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = RATE, 1, REST
    scene.unit_settings.length_unit = "MILLIMETERS"
    rise, turn, aim = math.radians(elevation), math.radians(18), Vector(aim)
    direction = Vector((math.sin(turn) * math.cos(rise), -math.cos(turn) * math.cos(rise), math.sin(rise)))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = aim + distance * direction
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    camera.data.clip_start, camera.data.display_size = 0.01, 0.02 * distance
    light = bpy.data.objects.new("Key", bpy.data.lights.new("Key", "AREA"))
    light.data.energy, light.data.size = 9.0 * distance**2, 0.5 * distance
    light.location = aim + distance * Vector((-0.9, -0.35, 0.75))
    light.rotation_euler = (light.location - aim).to_track_quat("Z", "Y").to_euler()
    for thing in (camera, light):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes.get("Background") or scene.world.node_tree.nodes.new(
        "ShaderNodeBackground"
    )
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.8, 0.87, 1.0, 1.0), 0.35
    if floor:
        bpy.ops.mesh.primitive_plane_add(size=6.0)
        bpy.context.object.name = "Floor"
        bpy.context.object.data.materials.append(painted("Floor", (0.6, 0.6, 0.6)))
    return scene


def painted(name: str, colour: Sequence[float]) -> bpy.types.Material:
    """Return a material of one colour (r, g, b)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = 0.42
    material.diffuse_color = (*colour, 1.0)
    return material


def press_ball(number: int, radius: float) -> bpy.types.Object:
    """Add a ball to press with."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, segments=32, ring_count=16)
    tip = bpy.context.object
    tip.name = tip.data.name = f"Fingertip {number}"
    tip.data.shade_smooth()
    tip.data.materials.append(bpy.data.materials.get("Fingertip") or painted("Fingertip", (0.9, 0.9, 0.9)))
    tip.hide_render = False
    return tip


def key_press(tip: bpy.types.Object, touch: Vector, way: Vector) -> None:
    """Keyframe a fingertip: at the touch, a way in, held, and off again to clear of the body."""
    clear = touch - way.normalized() * 0.02
    for frame, place in ((1, clear), (TOUCH, touch), (DOWN, touch + way), (HELD, touch + way), (OFF, clear)):
        tip.location = place
        tip.keyframe_insert("location", frame=frame)


def frame(*, centre: Sequence[float], distance: float) -> None:
    """Let every viewport look at a place [m], the sidebar open and the poke its tool where that can be chosen."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type == "VIEW_3D":
                space = area.spaces.active
                space.show_region_ui, space.clip_start = True, 1e-3
                view = space.region_3d
                view.view_location, view.view_distance = centre, distance
                view.view_rotation = bpy.context.scene.camera.rotation_euler.to_quaternion()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                region = next(each for each in area.regions if each.type == "WINDOW")
                with bpy.context.temp_override(window=window, area=area, region=region):
                    bpy.ops.wm.tool_set_by_id(name="dimple.poke_tool")


def save(path: Path) -> None:
    """Save a small file with nothing in it that is not used."""
    bpy.context.scene.frame_set(1)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)

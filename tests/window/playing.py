"""K1 keyframed by hovering its field and the key I, baked, and played with the space bar."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import numpy as np
import robot

Check = Callable[..., None]
KEYS = ((1, 0.3), (40, 3.0))  # frame and K1 [N/mm]
STANDS = 10  # the frame from which the fingertip stands still


def keyframes(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Keyframe K1, bake, and play what was baked: a fingertip that stands still meets a harder body."""
    cube, scene = bpy.data.objects["Cube"], bpy.context.scene
    material = cube.active_material.dimple
    yield from set_end(KEYS[1][0])
    yield from clicking.wheel(clicking.FAR, "WHEELUPMOUSE")
    field = yield from clicking.constant("K1")
    for (frame, value), jump in zip(KEYS, ("LEFT_ARROW", "RIGHT_ARROW"), strict=True):
        yield from robot.move(*at)
        yield from clicking.strike(jump, at, shift=True)  # to the first frame, to the last
        yield from robot.until(lambda frame=frame: scene.frame_current == frame, f"a key leads to frame {frame}", 10)
        yield from clicking.type_into(field, value)
        yield from clicking.strike("I", field)
        yield from robot.looks(6)
    robot.screenshot(out / "0-keyframed.png")
    keyed = points(cube.active_material)
    check("the key I over the field keyframes K1", np.allclose(keyed, KEYS), f"{keyed}")
    yield from clicking.search("Add Fingertip", at)
    yield from robot.until(lambda: scene.dimple.finger_1 is not None, "there is a fingertip", 30)
    tip = scene.dimple.finger_1  # where it goes is no step of tuning, so that is written
    tip.keyframe_insert("location", frame=1)
    tip.location.z -= 0.12
    tip.keyframe_insert("location", frame=STANDS)
    scene.dimple.cache_dir = "/tmp"
    yield from clicking.search("Bake", at)
    yield from robot.until(lambda: "Dimple" in cube.modifiers, "it is baked", 400)
    (path, _), *_ = robot.extension("operators.bridge.offset").files(cube.modifiers["Dimple"])
    table = path.with_suffix(".csv")
    rows = np.genfromtxt(table, delimiter=",", names=True)
    shares, words = [], []
    for row in (STANDS + 2, KEYS[1][0] - 1):
        scene.frame_set(1 + row)
        force, depth = rows["force_1_n"][row], rows["depth_1_mm"][row]
        shares.append(force / (material.K1 * depth))
        words.append(f"{force:.2f} N at {depth:.2f} mm and {material.K1:.3f} N/mm: {shares[-1]:.3f} of the law")
    follows = abs(shares[1] / shares[0] - 1) < 0.05
    check("the baked force follows the keyframed K1 within 5 %", follows, "; ".join(words))
    yield from play(at, out, check)
    bpy.ops.dimple.unbake()
    bpy.data.objects.remove(tip)
    bpy.data.materials[cube.active_material.name].animation_data_clear()
    scene.frame_set(1)
    yield from robot.redrawn()


def set_end(frame: int) -> robot.Waits:
    """Type the last frame into the header of the timeline."""
    timeline = next(each for each in robot.window().screen.areas if each.type == "DOPESHEET_EDITOR")
    for kind in ("FOOTER", "HEADER"):
        for header in (each for each in timeline.regions if each.type == kind and each.width > 1 and each.height > 1):
            found = yield from clicking.fields(timeline, header, "frame_end")
            if "frame_end" in found:
                yield from clicking.type_into(found["frame_end"], frame)
                return
    raise robot.NotReached("the timeline has no field of the last frame")


def points(material: bpy.types.Material) -> list[tuple[float, float]]:
    """Return frame and value of each keyframe of a material's K1."""
    animation = material.animation_data
    if animation is None or animation.action is None:
        return []
    curves = [
        curve for layer in animation.action.layers for strip in layer.strips for bag in strip.channelbags
        for curve in bag.fcurves if curve.data_path == "dimple.K1"
    ]  # fmt: skip
    return [tuple(round(each, 3) for each in point.co) for curve in curves for point in curve.keyframe_points]


def play(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Strike the space bar: the frames go by, and the mesh moves."""
    cube, scene, seen = bpy.data.objects["Cube"], bpy.context.scene, {}
    yield from robot.move(*at)
    yield from clicking.strike("LEFT_ARROW", at, shift=True)
    yield from clicking.strike("SPACE", at)

    def gone_by() -> bool:
        seen.setdefault(scene.frame_current, dented(cube))
        return len(seen) > 8 and scene.frame_current > STANDS

    yield from robot.until(gone_by, "the frames go by", 60)
    playing = robot.window().screen.is_animation_playing
    robot.screenshot(out / "0-keyframes.png")
    yield from clicking.strike("SPACE", at)
    yield from robot.until(lambda: not robot.window().screen.is_animation_playing, "the space bar stops it", 30)
    shallow, deep = min(seen.values()), max(seen.values())
    words = f"{len(seen)} frames seen, dents of {shallow:.3f} to {deep:.3f} of the half height"
    check("the space bar plays what was baked", playing and shallow < 0.02 and deep > 0.05, words)


def dented(obj: bpy.types.Object) -> float:
    """Return how far the highest face's middle lies below its rim [units of the mesh], as it is seen."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    middle = points[np.linalg.norm(points - (0.0, 0.0, 1.0), axis=1).argmin()]
    return float(points[:, 2].max() - middle[2])

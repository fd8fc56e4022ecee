"""A chubby character with a rig and painted weights: made soft by clicks, of flesh; its belly sways as it hops."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bmesh
import bpy
import clicking
import minute
import numpy as np
import opening
import robot
from mathutils import Matrix

Check = Callable[..., None]
CLICKS = 4  # that may be needed at most, with the weights painted
FIRM_M, FREE_M = 0.30, 0.46  # [m] from a bone: within the one firm, beyond the other free
BESIDE = 200, 120  # [px] in the viewport beside the character, where the tool draws no circle
END = 72  # the last frame; the motion is over in the 38th
SEEN_MM, FIRM_MM, STILL_MM = 3.0, 1.0, 0.3  # that the belly sways at least, a firm part and a body at rest at most
BALLS = (  # of which the body is moulded: middle, radii
    ((0.0, 0.02, 1.30), (0.34, 0.28, 0.42)), ((0.0, -0.12, 1.02), (0.46, 0.42, 0.42)),
    ((0.0, 0.10, 0.85), (0.42, 0.34, 0.30)), ((0.0, 0.0, 1.98), (0.27, 0.27, 0.30)),
    ((0.0, 0.0, 1.68), (0.16, 0.16, 0.20)),
    *(((side * 0.21, 0.02, z), (0.20, 0.21, 0.30)) for side in (-1, 1) for z in (0.25, 0.6)),
    *(((side * 0.22, -0.06, 0.06), (0.17, 0.26, 0.10)) for side in (-1, 1)),
    *(((side * (0.36 + 0.17 * part), 0.0, 1.45 - 0.15 * part), (0.15, 0.14, 0.15)) for side in (-1, 1)
      for part in range(4)),
)  # fmt: skip
BONES = {  # name: head, tail, parent
    "Hips": ((0.0, 0.06, 0.80), (0.0, 0.06, 1.10), ""),
    "Chest": ((0.0, 0.06, 1.10), (0.0, 0.04, 1.70), "Hips"),
    "Head": ((0.0, 0.04, 1.70), (0.0, 0.04, 2.20), "Chest"),
    "Leg.L": ((0.21, 0.04, 0.80), (0.21, 0.0, 0.05), "Hips"),
    "Leg.R": ((-0.21, 0.04, 0.80), (-0.21, 0.0, 0.05), "Hips"),
    "Arm.L": ((0.30, 0.0, 1.50), (0.72, 0.0, 1.12), "Chest"),
    "Arm.R": ((-0.30, 0.0, 1.50), (-0.72, 0.0, 1.12), "Chest"),
}
HEIGHTS = {  # frame: height of the hips [m], and how the way to the next is gone: by the weight, or by the legs
    1: (0.0, "SINE", "EASE_IN_OUT"), 4: (0.0, "SINE", "EASE_IN_OUT"), 10: (-0.14, "QUAD", "EASE_IN"),
    13: (0.0, "QUAD", "EASE_OUT"), 20: (0.4, "QUAD", "EASE_IN"), 27: (0.0, "QUAD", "EASE_OUT"),
    30: (-0.14, "SINE", "EASE_IN_OUT"), 36: (0.0, "SINE", "EASE_IN_OUT"),
}  # fmt: skip
TURNS = {4: 0.0, 10: -0.1, 30: 0.65, 36: 0.6}  # of the hips [rad]
BENDS = {4: 0.0, 10: 0.25, 20: -0.1, 30: 0.25, 38: 0.0}  # of the chest [rad]


def character() -> bpy.types.Object:
    """Put a character in the place of the default cube: a skin, a rig that it follows, weights, and a hop."""
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    skin = moulded()
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail, parent) in BONES.items():
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = head, tail, rig.data.edit_bones.get(parent)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.select_set(True)
    skin.select_set(True)
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    paint(skin)
    animate(rig)
    rig.select_set(False)
    bpy.context.view_layer.objects.active = skin
    return skin


def moulded() -> bpy.types.Object:
    """Return a smooth closed skin round all balls."""
    lump = bpy.data.meshes.new("Lump")
    balls = bmesh.new()
    for middle, radii in BALLS:
        place = Matrix.LocRotScale(middle, None, radii)
        bmesh.ops.create_icosphere(balls, subdivisions=3, radius=1.0, matrix=place)
    balls.to_mesh(lump)
    balls.free()
    skin = bpy.data.objects.new("Bruno", lump)
    bpy.context.collection.objects.link(skin)
    remesh = skin.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.voxel_size = "VOXEL", 0.045
    smooth = skin.modifiers.new("Smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 20
    whole = bpy.data.meshes.new_from_object(skin.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    skin.modifiers.clear()
    skin.data = whole
    whole.polygons.foreach_set("use_smooth", [True] * len(whole.polygons))
    return skin


def paint(skin: bpy.types.Object) -> None:
    """Paint what is firm: 1 near the bones, 0 at the belly."""
    points = np.array([vertex.co for vertex in skin.data.vertices])
    away = np.min([distance(points, *map(np.array, ends[:2])) for ends in BONES.values()], axis=0)
    group = skin.vertex_groups.new(name="Pin")
    for vertex, weight in enumerate(np.clip((FREE_M - away) / (FREE_M - FIRM_M), 0.0, 1.0)):
        group.add([vertex], float(weight), "REPLACE")


def distance(points: np.ndarray, head: np.ndarray, tail: np.ndarray) -> np.ndarray:
    """Return how far points (n, 3) are from a bone (n,)."""
    along = tail - head
    share = np.clip((points - head) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(points - head - share[:, None] * along, axis=1)


def animate(rig: bpy.types.Object) -> None:
    """Key a hop and a turn."""
    bones = rig.pose.bones
    hips, chest, legs = bones["Hips"], bones["Chest"], (bones["Leg.L"], bones["Leg.R"])
    hips.rotation_mode = chest.rotation_mode = "XYZ"
    for frame, (height, _, _) in HEIGHTS.items():
        hips.location.y = height  # a bone's y is its axis
        hips.keyframe_insert("location", frame=frame)
        for leg in legs:  # in a crouch they are squashed: the feet stay on the ground
            leg.scale.y = 1 + min(height, 0.0) / leg.bone.length
            leg.keyframe_insert("scale", frame=frame)
    for bone, axis, angles in ((hips, 1, TURNS), (chest, 0, BENDS)):
        for frame, angle in angles.items():
            bone.rotation_euler[axis] = angle
            bone.keyframe_insert("rotation_euler", frame=frame)
    for curve in rig.animation_data.action.layers[0].strips[0].channelbags[0].fcurves:
        if "rotation" not in curve.data_path:
            for key in curve.keyframe_points:
                _, key.interpolation, key.easing = HEIGHTS[round(key.co[0])]
    bpy.context.scene.frame_end = END
    bpy.context.scene.frame_set(1)


def sway(out: Path, check: Check, measured: dict) -> robot.Waits:
    """Make the character soft, of flesh, and play it; look at it while it hops and comes to rest."""
    yield from opening.new_file()
    with robot.inside():
        skin = character()
    view = robot.area().spaces.active
    view.region_3d.view_location, view.region_3d.view_distance = (0.0, 0.0, 1.25), 5.0
    view.overlay.show_extras = view.overlay.show_bones = view.overlay.show_outline_selected = False
    yield from robot.redrawn()
    hand, at = minute.Hand(), robot.on_screen((0.0, 0.0, 1.1))
    yield from clicking.open_tab("Dimple", at)
    yield from hand.button("make_soft")
    yield from robot.until(lambda: skin.dimple.enabled, "the character is soft", 60)
    yield from pick((yield from clicking.in_sidebar("material")), "F", hand)
    yield from robot.until(lambda: skin.dimple.material == "flesh", "its material is flesh", 20)
    check("its painted weights hold it", skin.dimple.pinned and skin.dimple.pin_group == "Pin")
    robot.screenshot(out / "s-00-pinned.png")
    yield from hand.button("play")
    yield from robot.until(lambda: opening.body() is not None, "it plays", 120)
    check("a rigged character of flesh plays by four actions", hand.count <= CLICKS, str(hand.count))
    yield from robot.redrawn()
    robot.screenshot(out / "s-00-playing.png")
    view.show_region_ui = False
    yield from watched(skin, out, check, measured)


def pick(menu: clicking.Place, letter: str, hand: minute.Hand) -> robot.Waits:
    """Click a menu, and choose by the letter that is underlined."""
    yield from hand.click(menu)
    yield from robot.looks(10)
    yield from hand.key(letter, menu)


def watched(skin: bpy.types.Object, out: Path, check: Check, measured: dict) -> robot.Waits:
    """Play the timeline by the space bar, and note how far belly and firm parts are from the rig in each frame [mm]."""
    scene, posed = bpy.context.scene, by_rig(skin)
    rest = np.array([vertex.co for vertex in skin.data.vertices])
    firm, belly = weights(skin)["Pin"] == 1.0, int(rest[:, 1].argmin())
    mm, away = skin.dimple.size_mm / max(skin.dimensions), {}
    yield from robot.move(*BESIDE)
    yield from clicking.strike("SPACE", BESIDE)

    def over() -> bool:
        frame = scene.frame_current
        if opening.body().frame.time and frame not in away:
            gap = mm * np.linalg.norm(robot.positions(skin.name) - posed(), axis=1)
            away[frame] = np.array([gap[belly], gap[firm].max(), gap.max()])
            if frame % 2:
                robot.screenshot(out / f"s-{frame:02d}.png")
        return frame >= END

    yield from robot.until(over, "the timeline is played", 120)
    yield from clicking.strike("SPACE", BESIDE)
    yield from robot.until(lambda: not robot.window().screen.is_animation_playing, "the space bar stops it", 60)
    yield from robot.key("ESC", *BESIDE)
    yield from robot.until(lambda: opening.body() is None and not robot.modal_operators(), "Esc ends the play", 60)
    measured["sway_mm"] = {frame: [round(float(number), 2) for number in away[frame]] for frame in sorted(away)}
    (most, held, _), (_, _, left) = np.max(list(away.values()), axis=0), away[max(away)]
    check("the belly sways visibly", most > SEEN_MM, f"{most:.1f} mm of {skin.dimple.size_mm:.0f}")
    check("what is painted firm does not", held < FIRM_MM, f"{held:.3f} mm")
    check("and it comes to rest", left < STILL_MM, f"{left:.3f} mm in frame {max(away)}, {len(away)} frames seen")
    after = mm * np.linalg.norm(robot.positions(skin.name) - posed(), axis=1).max()
    check("Esc leaves the skin where its rig holds it", not skin.modifiers.get("Dimple Press") and after < 1e-3)


def by_rig(skin: bpy.types.Object) -> Callable[[], np.ndarray]:
    """Return a function that places the vertices (n, 3) where the bones carry them now, each by its weight."""
    rest = np.array([(*vertex.co, 1.0) for vertex in skin.data.vertices])
    shares, bones = weights(skin), bpy.data.objects["Rig"].pose.bones
    whole = sum(shares[bone.name] for bone in bones)

    def posed() -> np.ndarray:
        moves = {bone.name: np.array(bone.matrix @ bone.bone.matrix_local.inverted()) for bone in bones}
        return sum(shares[name][:, None] * (rest @ move.T) for name, move in moves.items())[:, :3] / whole[:, None]

    return posed


def weights(skin: bpy.types.Object) -> dict[str, np.ndarray]:
    """Return the weights (n,) of each vertex group."""
    found = {group.name: np.zeros(len(skin.data.vertices)) for group in skin.vertex_groups}
    for vertex in skin.data.vertices:
        for each in vertex.groups:
            found[skin.vertex_groups[each.group].name][vertex.index] = each.weight
    return found

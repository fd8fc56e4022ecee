"""From the bare cube of the default scene: Make Soft, press by force, tune K1 while the fingertip rests, undo."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bpy
import brushing
import clicking
import large
import opening
import robot
import seeing

Check = Callable[..., None]
Scene = Callable[[tuple[int, int], Path, Check], robot.Waits]
FORCE_N = 15.0  # past the knee of the soft one
SOFT, DRAGGED, HARD = 0.3, 2.0, 3.0  # [N/mm] of K1
CUTS = 20  # of an edge of the cube: then it is fine enough for the fingertip


def tune(name: str, out: Path, check: Check) -> robot.Waits:
    """Play a scene with a soft cube that is pressed by force, from the default file on."""
    yield from opening.new_file()
    at = robot.on_screen((0.0, 0.0, 1.0))
    yield from robot.move(*at)
    if name != "making":
        yield from at_once()
    yield from SCENES[name](at, out, check)


def by_hand(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Take the cube from nothing to a material that was chosen by eye, as an artist does."""
    yield from make_soft(at, out, check)
    yield from choose_force(FORCE_N, out, check)
    yield from clicking.open_tab("Dimple", at)
    yield from clicking.type_into((yield from clicking.constant("K1")), SOFT)
    check("K1 is typed in the sidebar", slope() == SOFT, f"{slope()} N/mm")
    yield from robot.redrawn()


def at_once() -> robot.Waits:
    """Leave the cube as `by_hand` leaves it, by operators."""
    with robot.inside():
        bpy.ops.dimple.make_soft()
        settings = bpy.context.scene.dimple
        settings.press_by, settings.press_force_n = "FORCE", FORCE_N
        bpy.data.objects["Cube"].active_material.dimple.K1 = SOFT
        bpy.ops.ed.undo_push(message="Soft")
    yield from robot.show_tab("Dimple")


def put_away() -> robot.Waits:
    """Go back to pressing by depth, with Blender's own tool."""
    settings = bpy.context.scene.dimple  # the steps that were undone since have replaced an earlier one
    settings.press_by, settings.finger_radius_mm, settings.active_finger = "DEPTH", 10.0, 1
    with robot.inside():
        bpy.ops.wm.tool_set_by_id(name="builtin.select_box")
    yield from robot.redrawn()


def make_soft(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Search for Make Soft: nothing is wrong with the cube, so nothing is asked."""
    yield from clicking.search("Make Soft", at)
    yield from robot.redrawn()
    robot.screenshot(out / "0-make-soft.png")
    yield from robot.until(lambda: bpy.data.objects["Cube"].dimple.enabled, "Make Soft is done", 60)
    cube = bpy.data.objects["Cube"]
    tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
    chosen = tool.idname if tool else ""
    planned = len(cube.data.vertices) == 8 and bool(cube.dimple.plan_reason)
    check("the bare cube is soft and planned, its mesh as it was", planned)
    check("the poke is the tool of the viewport", chosen == "dimple.poke_tool", chosen)


def choose_force(force: float, out: Path, check: Check) -> robot.Waits:
    """Choose Force in the tool's header, and type how much."""
    x, y = yield from clicking.in_header("press_by")
    for place in ((x, y), (x + 28, y), (x + 56, y)):  # Depth, then Force, side by side
        if bpy.context.scene.dimple.press_by != "FORCE":
            yield from robot.click(*place)
            yield from robot.looks(6)
    yield from clicking.type_into((yield from clicking.in_header("press_force_n")), force)
    settings = bpy.context.scene.dimple
    robot.screenshot(out / "0-by-force.png")
    ok = settings.press_by == "FORCE" and abs(settings.press_force_n - force) < 1e-4
    check("the tool's header takes the force", ok, f"{settings.press_by}, {settings.press_force_n:.2f} N")


def slope() -> float:
    """Return K1 [N/mm] of the cube's material."""
    return round(bpy.data.objects["Cube"].active_material.dimple.K1, 3)


def push() -> float:
    """Return the force [N] with which the body answers along the press."""
    frame, finger = opening.body().frame, next(iter(opening.body().session.fingers), None)
    if finger is None or not len(frame.finger_forces):
        return 0.0
    return -sum(float(f) * d for f, d in zip(frame.finger_forces[0], finger.inward, strict=True))


def depth_of(force: float, slope: float) -> float:
    """Return the depth [mm] of a force [N] by the law of the cube's material, with a slope K1 [N/mm]."""
    material = bpy.data.objects["Cube"].active_material.dimple
    return min(force / slope, material.x0) + max(force - slope * material.x0, 0.0) / material.K2


def resting() -> bool:
    """Tell whether the body answers with the force that presses."""
    return abs(push() - bpy.context.scene.dimple.press_force_n) < 0.01 * bpy.context.scene.dimple.press_force_n


ACTS_S, LESS_MM = 0.1, 0.1  # [s] of the body's time in which a harder K1 lifts the fingertip by so much, at least
STILL_S = 1.0  # [s] of the body's time; longer than a change takes to come in
_last = {"depth": -1.0, "since": -1.0}


def settled() -> bool:
    """Tell whether the fingertip has rested for a while at one depth."""
    frame = opening.body().frame
    depth = float(frame.depths[0]) if len(frame.depths) else 0.0
    moves = abs(depth - _last["depth"]) >= 2e-3 * depth or frame.time < _last["since"]
    if moves or not resting():
        _last["depth"], _last["since"] = depth, frame.time
    return frame.time > _last["since"] + STILL_S


def settle(what: str, also: Callable[[], bool] = lambda: True) -> robot.Waits:
    """Wait until the fingertip rests, with the viewport put aside: to draw it takes many times what stepping does."""
    place = robot.area()
    place.type = "TEXT_EDITOR"
    yield from robot.until(lambda: opening.body() is not None and also() and settled(), what, 400)
    place.type = "VIEW_3D"
    yield from robot.redrawn()


def press_and_undo(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    yield from press_by_force(at, out, check)
    yield from take_it_back(at, out, check)


def press_by_force(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Press with the tool, and harden the material while the fingertip rests: drag K1, then type the rest."""
    yield from leave_resting(at)
    yield from settle("the fingertip rests")
    soft = float(opening.body().frame.depths[0])
    yield from robot.redrawn()
    field = yield from clicking.constant("K1")
    robot.screenshot(out / "0-force-soft.png")
    session, seen, drawn, began = opening.body().session, [], robot.drawn(), time.monotonic()
    finish = session.finish

    def noted(*given: object, **named: object) -> object:
        frame = finish(*given, **named)
        seen.append((slope(), session.model.materials[0].K1 / 1e3, 1e3 * float(frame.depths[0]), frame.time))
        return frame

    session.finish = noted  # however it is stepped
    yield from clicking.drag(field, lambda: slope() >= DRAGGED)
    robot.screenshot(out / "0-dragged.png")
    dragged = slope()
    check("K1 is dragged while the fingertip rests", dragged >= DRAGGED, f"to {dragged} N/mm")
    yield from clicking.type_into(field, HARD)
    yield from robot.until(lambda: slope() == HARD, f"{HARD:g} is typed", 10)
    first = next(index for index, (value, *_) in enumerate(seen) if value != SOFT)
    yield from settle("the fingertip rests again", lambda: len(seen) > first + 30)
    del session.finish
    value, taken, _, begun = seen[first + 1]
    check("the body has K1 within two frames", taken > SOFT, f"{SOFT} to {value}, the body has {taken:.3f} N/mm")
    # a frame on a slow machine is a few milliseconds of the body's time
    depth, after = next((depth, t - begun) for _, _, depth, t in seen[first + 1 :] if t >= begun + ACTS_S)
    words = f"{1e3 * soft:.4f} and {depth:.4f} mm after {1e3 * after:.0f} ms"
    check("and acts by it within a tenth of a second", depth < 1e3 * soft - LESS_MM, words)
    hard, rate = float(opening.body().frame.depths[0]), (robot.drawn() - drawn) / (time.monotonic() - began)
    check("a harder material is pressed less deep", hard < 0.7 * soft, f"{1e3 * soft:.2f} and {1e3 * hard:.2f} mm")
    check("and that is seen, however slow the machine is", rate > 0, f"{rate:.1f} frames a second")
    check("by the same force", resting(), f"{push():.3f} N")
    for constant, depth in ((SOFT, soft), (HARD, hard)):
        wanted = depth_of(FORCE_N, constant)
        ratio = f"{1e3 * depth:.2f} mm for {wanted:.2f} mm by the law"
        name = f"the depth at {constant} N/mm is that of the law within 5 %"
        check(name, abs(1e3 * depth / wanted - 1) < 0.05, ratio)
    yield from robot.redrawn()
    robot.screenshot(out / "0-force-hard.png")


def take_it_back(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Ctrl-Z over the viewport takes K1 back while the poke goes on, and nothing from before it."""
    yield from robot.move(*at)
    for _ in range(2):  # what was typed, and what was dragged
        before = slope()
        yield from robot.key("Z", *at, ctrl=True)
        yield from robot.until(lambda before=before: slope() != before, "Ctrl-Z takes K1 back", 30)
    check("Ctrl-Z takes back first what was typed, then what was dragged", slope() == SOFT, f"{slope()} N/mm")
    session = opening.body().session
    yield from robot.until(lambda: session.model.materials[0].K1 == 1e3 * SOFT, "and the body follows", 30)
    yield from robot.key("Z", *at, ctrl=True)
    yield from robot.looks(10)
    check("Ctrl-Z takes back what was tuned, and only that", slope() == SOFT and opening.body() is not None)
    yield from robot.redrawn()
    robot.screenshot(out / "0-undone.png")
    yield from leave(at)


def leave(at: tuple[int, int]) -> robot.Waits:
    """Choose the first fingertip again and leave the poke."""
    yield from robot.move(*at)
    yield from robot.key("ONE", *at)
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: opening.body() is None, "ESC ends the poke", 30)


def leave_resting(at: tuple[int, int]) -> robot.Waits:
    """Press with the tool and choose the next finger, so that the first stays where it is."""
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    yield from robot.until(lambda: opening.body() is not None and resting(), "it rests", 120)
    yield from robot.key("TWO", *at)
    yield from robot.button(*at, "RELEASE")
    yield from robot.looks(10)


def finer() -> bpy.types.Object:
    """Subdivide the cube: weights are painted on vertices of its own."""
    with robot.inside():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.subdivide(number_cuts=CUTS)
        bpy.ops.object.mode_set(mode="OBJECT")
    return bpy.data.objects["Cube"]


def looks(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Photograph the overlay on a light theme, in four views and at twice the scale."""
    view = bpy.context.preferences.view
    yield from leave_resting(at)
    light = next(Path(bpy.utils.resource_path("SYSTEM")).rglob("Blender_Light.xml"))
    bpy.ops.script.execute_preset(filepath=str(light), menu_idname="USERPREF_MT_interface_theme_presets")
    yield from robot.redrawn()
    robot.screenshot(out / "0-light.png")
    with robot.inside():
        bpy.ops.screen.region_quadview()
    yield from robot.redrawn()
    robot.screenshot(out / "0-four-views.png")
    with robot.inside():
        bpy.ops.screen.region_quadview()
    view.ui_scale = 2.0
    yield from robot.redrawn()
    yield from robot.looks(20)
    robot.screenshot(out / "0-scale.png")
    view.ui_scale = 1.0
    with bpy.context.temp_override(window=robot.window()):
        bpy.ops.preferences.reset_default_theme()
    yield from robot.redrawn()
    check("the overlay goes on in every look", opening.body() is not None)
    yield from leave(at)


SCENES: dict[str, Scene] = {
    "making": by_hand,
    "tuning": press_and_undo,
    "brushing": brushing.brush,
    "colors": seeing.colours,
    "knee": seeing.paint_knee,
    "twins": seeing.two_materials,
    "looks": looks,
    "large": large.press_large,
}

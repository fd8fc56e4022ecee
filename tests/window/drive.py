"""What a person does in the window test, run inside Blender: blender ... --python drive.py

Reads /mnt/zip (the built extension), writes /mnt/out/*.png and /mnt/out/window.json. `run.py` starts it.
"""

from __future__ import annotations

import json
import os
import sys
import time
import traceback
from collections.abc import Generator
from functools import partial
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import animating
import calibrating
import clicking
import closing
import device
import exporting
import judging
import minute
import models
import opening
import robot
import swaying
import tuning

OUT = Path("/mnt/out")
ONLY = set(os.environ.get("DIMPLE_SCENES", "").split())  # names of functions below; none: all of them
BODY = "Ball"
DENT = 0.12  # [m] in the scene: the ball is 2 m wide there and stands for one of 165 mm, so 10 mm of the real one
ROUNDING = 1e-5  # [m] that a running body at rest may tremble
ALIKE = 20  # [px] that may differ between two pictures of the same mesh
NEAR = 25  # [px] that the deepest vertex may be from the pointer: a fingertip is 27 wide, an edge 11 long
BESIDE = 200, 120  # [px] in the viewport beside the ball, where the tool draws no circle
CHECKS: list[dict] = []
REPORT: dict = {"blender": bpy.app.version_string, "checks": CHECKS, "measured": {}, "seconds": {}}
STARTED = time.monotonic()


def check(name: str, ok: bool, detail: str = "") -> None:
    """Note one result; the run goes on."""
    CHECKS.append({"name": name, "ok": bool(ok), "detail": detail})
    at = REPORT["seconds"][name] = round(time.monotonic() - STARTED, 1)
    print(f"{at:6.1f} s {'ok  ' if ok else 'FAIL'} {name}{': ' + detail if detail else ''}", flush=True)


def moved(rest: np.ndarray) -> float:
    """Return how far the vertex that moved most has moved [m of the scene]."""
    return float(np.linalg.norm(robot.positions(BODY) - rest, axis=1).max())


def at_rest(rest: np.ndarray) -> bool:
    return np.array_equal(robot.positions(BODY), rest)


def traces() -> set[str]:
    """Return the names of all that the extension might leave on the body."""
    body = bpy.data.objects[BODY]
    keys = body.data.shape_keys.key_blocks.keys() if body.data.shape_keys else []
    return {*body.data.attributes.keys(), *keys, *body.modifiers.keys()}


def poking() -> bool:
    return "DIMPLE_OT_poke" in robot.modal_operators()


def open_scene() -> robot.Waits:
    """Make a soft ball that stands for a real one of 165 mm, and look at it."""
    with robot.inside():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1.0)
        bpy.ops.object.shade_smooth()
        body = bpy.context.object
        body.name = BODY
        body.dimple.size_mode = "CUSTOM"
        bpy.context.scene.dimple.finger_radius_mm = 15.0
        # scripted operators push no undo step of their own
        bpy.ops.ed.undo_push(message="Ball")
        view = robot.area().spaces.active
        view.region_3d.view_distance = 5.0
        view.overlay.show_cursor = False
    yield from robot.redrawn()


def click(name: str) -> clicking.Found:
    """Click the button of an operator in the sidebar, found by hovering; return where it is."""
    place = yield from clicking.button(name)
    yield from robot.click(*place)
    return place


def start_poke() -> robot.Waits:
    yield from click("poke")
    yield from robot.until(poking, "the poke runs", 20)


def press(at: tuple[int, int], rest: np.ndarray) -> robot.Waits:
    """Put the button down on the ball and hold it until the dent is deep enough."""
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    # by state, not by seconds: time runs slower here than in the world
    yield from robot.until(lambda: moved(rest) >= DENT, f"the press moves the mesh by {DENT} m", 120)


def deepest(rest: np.ndarray) -> tuple[float, tuple[int, int]]:
    """Return how deep the mesh is dented along the view [m of the scene], and where on the screen [px]."""
    to_viewer = np.array(robot.area().spaces.active.region_3d.view_matrix)[2, :3]
    inward = -((robot.positions(BODY) - rest) @ to_viewer)
    return float(inward.max()), robot.on_screen(tuple(rest[int(inward.argmax())]))


def judge_dent(at: tuple[int, int], rest: np.ndarray, when: str) -> None:
    """Check the pressed mesh: finite, dented away from the viewer, and where it was pressed."""
    depth, spot = deepest(rest)
    depth_mm, off = (
        depth / 2.0 * bpy.data.objects[BODY].dimple.size_mm,
        float(np.hypot(spot[0] - at[0], spot[1] - at[1])),
    )
    REPORT["measured"][when] = {"depth_mm": round(depth_mm, 3), "off_px": round(off, 1)}
    check(f"{when}: all positions are finite", bool(np.isfinite(robot.positions(BODY)).all()))
    check(f"{when}: the mesh gives way", 0.5 * DENT < depth < 4 * DENT, f"{depth_mm:.2f} mm")
    check(f"{when}: it gives way where it was pressed", off < NEAR, f"deepest {off:.0f} px from the pointer")


def drag(at: tuple[int, int], rest: np.ndarray) -> robot.Waits:
    """Drag the fingertip over the ball: the dent must come along."""
    to = at[0] + 40, at[1] + 20
    for share in (0.25, 0.5, 0.75, 1.0):
        yield from robot.move(at[0] + share * (to[0] - at[0]), at[1] + share * (to[1] - at[1]))
    came = robot.until(lambda: np.hypot(*np.subtract(deepest(rest)[1], to)) < NEAR, "the dent follows the drag", 60)
    yield from came
    judge_dent(to, rest, "dragged")


def leave(key: str, at: tuple[int, int]) -> robot.Waits:
    """Strike a key that ends the poke and wait until it has ended."""
    yield from robot.key(key, *at)
    yield from robot.until(lambda: not poking(), f"{key} ends the poke", 30)
    yield from robot.redrawn()


def compare(wanted: np.ndarray, at: tuple[int, int], name: str, mouse: tuple[int, int] = BESIDE) -> robot.Differs:
    """Take a picture and count the pixels on the ball that differ from an earlier one."""
    yield from robot.move(*mouse)
    yield from robot.redrawn()
    return robot.differing(wanted, robot.screenshot(OUT / name), at, robot.HALF)


def play() -> robot.Waits:
    """Install, then play all scenes, or those that were asked for by name."""
    bpy.ops.extensions.package_install_files(filepath="/mnt/zip", repo="user_default", enable_on_install=True)
    names = [name for name in bpy.context.preferences.addons.keys() if name.startswith("bl_ext.")]
    check("Blender's own installer takes the zip and enables it", len(names) == 1, ", ".join(names))
    own = {
        "closing": lambda: closing.close(check),
        "opening": lambda: opening.open_samples(OUT, check),
        "minute": lambda: minute.first(OUT, check),
        "swaying": lambda: swaying.sway(OUT, check, REPORT["measured"]),
        **{f"{name}_model": partial(models.model, name, OUT, check) for name in models.MODELS},
    }
    if unknown := ONLY - {*own, *tuning.SCENES, *ON_BALL, "on_ball"}:
        raise robot.NotReached(f"there is no scene {sorted(unknown)}; there are {[*own, *tuning.SCENES, *ON_BALL]}")
    for name in filter(wanted, own):
        yield from guarded(name, own[name]())
    for name in filter(wanted, tuning.SCENES):
        yield from guarded(name, tuning.tune(name, OUT, check))
    yield from tuning.put_away()
    ball = None
    for name in ON_BALL:
        if wanted(name) or "on_ball" in ONLY:
            ball = ball or (yield from ready_ball())
            if not (yield from guarded(name, ON_BALL[name](*ball))):
                ball = None


def wanted(name: str) -> bool:
    return not ONLY or name in ONLY


def guarded(name: str, scene: robot.Waits) -> Generator[float, None, bool]:
    """Play a scene; where it ends early, note that and go back to the default scene, for the next one."""
    try:
        yield from scene
    except (robot.NotReached, RuntimeError, ReferenceError, AttributeError, LookupError, ValueError, OSError) as error:
        robot.screenshot(OUT / f"failed-{name}.png")
        places = [f"{each.name}, line {each.lineno}" for each in traceback.extract_tb(error.__traceback__)[1:]]
        check(f"{name} reaches its end", False, f"{error!r} in {', '.join(places)}")
        if all(each.type != "VIEW_3D" for each in robot.window().screen.areas):  # a file browser fills the window
            yield from robot.key("ESC", robot.WIDTH / 2, robot.HEIGHT / 2)
            yield from robot.looks(20)
        yield from opening.new_file()
        return False
    return True


def ready_ball() -> Generator[float, None, tuple]:
    """Make a ball and look at it; return where it is on the screen, its positions, a picture, and what is on it."""
    yield from open_scene()
    yield from robot.show_tab("Dimple")
    yield from clicking.wheel(clicking.FAR, "WHEELUPMOUSE")  # where an earlier scene has left it
    at = robot.on_screen((0.0, 0.0, 0.0))
    rest, before = robot.positions(BODY).copy(), traces()
    yield from robot.move(*BESIDE)
    yield from robot.redrawn()
    resting = robot.screenshot(OUT / "1-rest.png")
    control = yield from compare(resting, at, "1-rest.png")
    check("two pictures of the resting ball are alike", control <= ALIKE, f"{control} pixels differ")
    return at, rest, resting, before


def press_twice(at: tuple[int, int], rest: np.ndarray, resting: np.ndarray, before: set[str]) -> robot.Waits:
    """Press, let go, leave; press again, keep, undo: nothing is left on the mesh."""
    yield from press_and_leave(at, rest, resting)
    check("ESC leaves nothing on the mesh", traces() == before, f"{traces() ^ before}")
    yield from press_and_keep(at, rest, resting)
    check("Ctrl-Z leaves nothing on the mesh", traces() == before, f"{traces() ^ before}")


def press_and_leave(at: tuple[int, int], rest: np.ndarray, resting: np.ndarray) -> robot.Waits:
    """Press and let go, then leave by ESC: nothing may remain."""
    yield from start_poke()
    check("a click on its sidebar button starts the poke", poking())
    yield from robot.move(*at)
    yield from robot.redrawn()
    hover = robot.screenshot(OUT / "2-hover.png")
    check("hovering presses nothing", moved(rest) < ROUNDING, f"{moved(rest):.1e} m, rounding of the running body")
    yield from press(at, rest)
    yield from robot.redrawn()
    judge_dent(at, rest, "pressed")
    gap = yield from compare(hover, at, "3-pressed.png", mouse=at)
    check("the press is seen", gap > robot.SEEN, f"{gap} pixels differ")
    yield from drag(at, rest)
    yield from robot.redrawn()
    robot.screenshot(OUT / "4-dragged.png")
    yield from robot.key("Z", *at, ctrl=True)
    check("Ctrl-Z while poking is swallowed", poking() and moved(rest) > 0.3 * DENT)
    yield from robot.button(*at, "RELEASE")
    yield from robot.until(lambda: moved(rest) < 0.3 * DENT, "the ball springs back", 120)
    check("the ball springs back when let go", True, f"{moved(rest):.4f} m from rest")
    yield from robot.redrawn()
    robot.screenshot(OUT / "5-released.png")
    yield from leave("ESC", at)
    check("ESC puts the mesh back bit for bit", at_rest(rest))
    gap = yield from compare(resting, at, "6-left.png")
    check("after ESC the picture is the resting one", gap <= ALIKE, f"{gap} pixels differ")


def press_and_keep(at: tuple[int, int], rest: np.ndarray, resting: np.ndarray) -> robot.Waits:
    """Press again, keep the dent by Enter, then undo it."""
    yield from start_poke()
    yield from press(at, rest)
    yield from leave("RET", at)
    yield from robot.button(*at, "RELEASE")
    judge_dent(at, rest, "kept by Enter")
    gap = yield from compare(resting, at, "7-kept.png")
    check("the kept dent is seen, with nothing drawn over it", gap > robot.SEEN, f"{gap} pixels differ")
    yield from robot.key("Z", *at, ctrl=True)
    yield from robot.until(lambda: at_rest(rest), "Ctrl-Z restores the mesh bit for bit")
    check("Ctrl-Z restores the mesh bit for bit", True)
    gap = yield from compare(resting, at, "8-undone.png")
    check("after Ctrl-Z the picture is the resting one", gap <= ALIKE, f"{gap} pixels differ")


def in_japanese() -> robot.Waits:
    """Photograph the sidebar in Japanese, look every word of ours up as a button does, and ask why one is grey."""
    view, said = bpy.context.preferences.view, ""
    view.language = "ja_JP"
    ours = robot.extension("addon.translations")
    words = [
        (english, text) for (context, english), text in ours.dictionaries()["ja_JP"].items() if context == ours.CONTEXT
    ]
    other = [english for english, text in words if bpy.app.translations.pgettext(english, ours.CONTEXT) != text]
    check("every word of ours is ours in Japanese", len(words) > 500 and not other, ", ".join(other[:9]))
    context = bpy.ops.dimple.make_soft.get_rna_type().translation_context
    shown = bpy.app.translations.pgettext("Tennis ball", context)
    depth = bpy.types.UILayout.enum_item_name(bpy.context.scene.dimple, "press_by", "DEPTH")
    check("an item of a menu is ours in Japanese", depth == dict(words)["Depth"], depth)
    check("a preset's button is Japanese", shown == dict(words)["Tennis ball"], shown)
    try:
        bpy.ops.dimple.reset()
    except RuntimeError as error:
        said = str(error).strip()
    check("why a button is grey is said in Japanese", "何も押していません" in said, said)
    yield from robot.redrawn()
    robot.screenshot(OUT / "10-japanese.png")
    view.language = "en_US"
    yield from robot.redrawn()


def play_on(rest: np.ndarray) -> robot.Waits:
    """Start the simulation by its button and leave it running: `finish` closes Blender in the middle."""
    bpy.context.scene.dimple.use_gravity = True  # so that something moves
    bpy.data.objects[BODY].dimple.pinned = False
    yield from click("play")
    yield from robot.until(lambda: moved(rest) > 0.01, "the free ball falls", 60)
    check("a click on its button plays: the free ball falls", "DIMPLE_OT_play" in robot.modal_operators())
    yield from robot.redrawn(6)  # Blender moves the panels to their new places
    robot.screenshot(OUT / "11-playing.png")


ON_BALL = {
    "pressing": press_twice,
    "calibrating": lambda at, *_: calibrating.calibrate(at, BODY, OUT, check),
    "device": lambda *_: device.feel(BODY, (0.0, 0.0, 1.2), OUT, check),
    "judging": lambda *_: judging.judge(BODY, OUT, check),
    "animating": lambda at, *_: animating.animate(at, BODY, OUT, check),
    "exporting": lambda at, *_: exporting.export(at, BODY, OUT, check),
    "japanese": lambda *_: in_japanese(),
    "playing": lambda _at, rest, *_: play_on(rest),
}


def finish(error: str) -> None:
    """Write the report and quit."""
    if error:
        robot.screenshot(OUT / "failed.png")
        check("the run reached its end", False, error)
    REPORT["measured"]["frames_per_second"] = round(robot.drawn() / (time.monotonic() - STARTED), 1)
    (OUT / "window.json").write_text(json.dumps(REPORT, indent=1))
    bpy.ops.wm.quit_blender()


bpy.context.preferences.view.show_splash = False
bpy.context.preferences.system.viewport_aa = "FXAA"  # eight draws of each picture take seconds in software
robot.run(play(), finish)

"""The first minute: from the empty default file by clicks and keys alone to a press, a baked fingertip and a GLB."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import exporting
import opening
import robot

Check = Callable[..., None]
Place = tuple[int, int]
PRESS, BAKE, EXPORT = 4, 8, 3  # actions that may be needed at most; a click, a key and a drag are one each
DEEP_M = 0.012


class Hand:
    """Counts what a hand does: finding a button by hovering is no action."""

    def __init__(self) -> None:
        self.count = 0

    def key(self, kind: str, at: Place) -> robot.Waits:
        """Strike a key over a place."""
        self.count += 1
        yield from robot.move(*at)
        yield from clicking.strike(kind, at)
        yield from robot.redrawn()

    def click(self, at: Place) -> robot.Waits:
        """Click a place."""
        self.count += 1
        yield from robot.click(*at)
        yield from robot.looks(6)

    def button(self, name: str) -> robot.Waits:
        """Click the button of an operator in the sidebar."""
        yield from self.click((yield from clicking.button(name)))

    def drag(self, at: Place, by: Place, picture: Path) -> robot.Waits:
        """Press on the body until the fingertip is deep, slide, take a picture, let go."""
        self.count += 1
        yield from robot.move(*at)
        yield from robot.button(*at, "PRESS")
        yield from robot.until(lambda: depth() > DEEP_M, "it is pressed", 300)
        for share in (0.25, 0.5, 0.75, 1.0):
            yield from robot.move(at[0] + share * by[0], at[1] + share * by[1])
            yield from robot.looks(4)
        yield from robot.redrawn()
        robot.screenshot(picture)
        yield from robot.button(at[0] + by[0], at[1] + by[1], "RELEASE")
        yield from robot.until(lambda: depth() == 0, "it is let go", 120)


def depth() -> float:
    """Return how deep the fingertip is [m]."""
    body = opening.body()
    return float(body.frame.depths.max(initial=0.0)) if body else 0.0


def first(out: Path, check: Check) -> robot.Waits:
    """Press the default cube, turn the press into a baked fingertip, and export that."""
    yield from opening.new_file()
    hand, at = Hand(), robot.on_screen((0.0, 0.0, 1.0))
    yield from hand.key("N", at)
    yield from clicking.open_tab("Dimple", at)  # by one click
    hand.count += 1
    yield from robot.redrawn()
    robot.screenshot(out / "m-1-sidebar.png")
    yield from hand.button("make_soft")
    yield from robot.until(lambda: bpy.data.objects["Cube"].dimple.enabled, "the cube is soft", 60)
    yield from robot.redrawn()
    robot.screenshot(out / "m-2-soft.png")
    yield from hand.drag(at, (30, 6), out / "m-3-pressed.png")
    check("the default cube is pressed by four actions", hand.count <= PRESS, f"{hand.count}")
    with tempfile.TemporaryDirectory() as place:
        yield from animate(Path(place), hand, out, check)
        yield from export(Path(place), hand, at, out, check)


def animate(place: Path, hand: Hand, out: Path, check: Check) -> robot.Waits:
    """Turn the press into keyframes, and bake them."""
    cube, scene, hand.count = bpy.data.objects["Cube"], bpy.context.scene, 0
    scene.dimple.cache_dir = str(place)
    yield from clicking.wheel(8)
    yield from hand.button("key_press")
    yield from robot.until(lambda: scene.dimple.finger_1 is not None, "the press is a fingertip", 20)
    yield from robot.redrawn()
    robot.screenshot(out / "m-4-keyed.png")
    yield from hand.button("bake")
    yield from robot.until(lambda: "Dimple" in cube.modifiers, "it is baked", 600)
    check("and becomes a baked fingertip by eight more", hand.count <= BAKE, f"{hand.count}")
    scene.frame_set(round(sum(scene.dimple.finger_1.animation_data.action.frame_range) / 2))
    yield from robot.redrawn()
    robot.screenshot(out / "m-5-baked.png")


def export(place: Path, hand: Hand, at: Place, out: Path, check: Check) -> robot.Waits:
    """Export that as GLB."""
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    hand.count, folder = 0, place / "exported"
    folder.mkdir()
    yield from hand.button("export_animation")
    yield from robot.until(lambda: exporting.browser() is not None, "the file browser opens", 60)
    yield from robot.looks(20)
    exporting.browser().spaces.active.params.directory = str(folder).encode()
    robot.screenshot(out / "m-6-export.png")
    if exporting.dialog().formats != {"GLB"}:
        yield from exporting.choose("GLB")
        hand.count += 1
    yield from hand.click(exporting.EXPORT)
    yield from robot.until(lambda: any(folder.glob("*.glb")) and not robot.modal_operators(), "it exports", 600)
    names = ", ".join(sorted(path.name for path in folder.iterdir()))
    check("and a GLB by three more", hand.count <= EXPORT, f"{hand.count}: {names}")
    yield from robot.redrawn()
    robot.screenshot(out / "m-7-exported.png")

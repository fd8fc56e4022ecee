"""The hand and the eye of the window test: simulated mouse and keys, buttons found by hovering, screenshots.

Runs inside Blender. Everything that takes time is a generator that yields seconds to wait; `run` ticks it
from a `bpy.app.timers` callback, so Blender handles events and draws in between.
"""

from __future__ import annotations

import importlib
import struct
import subprocess
import time
import traceback
import zlib
from collections.abc import Callable, Generator
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np

Waits = Generator[float, None, None]
Differs = Generator[float, None, int]
TICK_S = 0.05
WIDTH, HEIGHT = 1280, 800
HALF = 80  # [px] of a compared square: inside the ball's outline, whose smoothing is never the same twice
SEEN = 1000  # [px] that a dent or a chart changes at least
_draws = {"count": 0, "at": 0.0, "oldest": 0.0}


class NotReached(Exception):
    """Something that was waited for did not happen."""


def run(steps: Waits, finish: Callable[[str], None]) -> None:
    """Tick a generator until it ends, then call finish("" or the traceback of what went wrong)."""

    def tick() -> float | None:
        try:
            return next(steps)
        except StopIteration:
            finish("")
            return None
        except Exception:  # whatever it was, the run must end and tell
            finish(traceback.format_exc())
            raise

    bpy.types.SpaceView3D.draw_handler_add(_count_draw, (), "WINDOW", "POST_PIXEL")
    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)  # the run may load a file


def drawn() -> int:
    """Return how often viewports were drawn so far."""
    return _draws["count"]


def watch() -> None:
    """Begin to watch how old a picture becomes."""
    _draws["at"], _draws["oldest"] = time.monotonic(), 0.0


def oldest() -> float:
    """Return how old a picture became at most since then [s], the one that is seen now too."""
    return max(_draws["oldest"], time.monotonic() - _draws["at"])


def _count_draw() -> None:
    now = time.monotonic()
    _draws["count"] += 1
    _draws["oldest"], _draws["at"] = max(_draws["oldest"], now - _draws["at"]), now


def extension(name: str) -> ModuleType:
    """Return a module of the installed extension."""
    ours = next(each for each in bpy.context.preferences.addons.keys() if each.endswith(".dimple"))
    return importlib.import_module(f"{ours}.{name}")


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def area() -> bpy.types.Area:
    """Return the largest viewport."""
    views = [candidate for candidate in window().screen.areas if candidate.type == "VIEW_3D"]
    return max(views, key=lambda candidate: candidate.width * candidate.height)


def region(kind: str = "WINDOW") -> bpy.types.Region:
    return next(candidate for candidate in area().regions if candidate.type == kind)


def inside() -> object:
    """Return a context in which an operator runs as one called in the largest viewport."""
    return bpy.context.temp_override(window=window(), area=area(), region=region())


def until(happened: Callable[[], bool], what: str, limit_s: float = 60.0) -> Waits:
    """Wait for a condition.

    Args:
        limit_s: at full speed; on a slow machine, where Blender comes round less often, as many looks.

    Raises:
        NotReached: not within the limit.
    """
    for _ in range(round(limit_s / TICK_S)):
        if happened():
            return
        yield TICK_S
    if not happened():
        raise NotReached(f"looked {limit_s / TICK_S:.0f} times, and it did not happen: {what}")


def looks(count: int) -> Waits:
    """Let Blender come round so many times."""
    for _ in range(count):
        yield TICK_S


def redrawn(draws: int = 2) -> Waits:
    """Wait until the viewport has been drawn anew: software rendering is slow, seconds mean nothing."""
    wanted = _draws["count"] + draws

    def done() -> bool:
        area().tag_redraw()
        return _draws["count"] >= wanted

    yield from until(done, "the viewport is drawn")
    yield TICK_S


def move(x: float, y: float) -> Waits:
    """Move the mouse to a window position [px], origin at the lower left."""
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=round(x), y=round(y))
    yield TICK_S


def button(x: float, y: float, value: str, kind: str = "LEFTMOUSE") -> Waits:
    """Press ("PRESS") or release ("RELEASE") a mouse button at a window position."""
    window().event_simulate(type=kind, value=value, x=round(x), y=round(y))
    yield TICK_S


def click(x: float, y: float) -> Waits:
    yield from move(x, y)
    yield from button(x, y, "PRESS")
    yield from button(x, y, "RELEASE")


def key(kind: str, x: float, y: float, *, ctrl: bool = False) -> Waits:
    """Strike a key while the mouse is at a window position."""
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=kind, value=value, x=round(x), y=round(y), ctrl=ctrl)
        yield TICK_S


def show_tab(name: str) -> Waits:
    """Open the sidebar at a tab; the tab can be chosen only after the sidebar was drawn once."""
    area().spaces.active.show_region_ui = True
    yield from redrawn()
    sidebar = region("UI")
    yield from until(lambda: sidebar.active_panel_category != "UNSUPPORTED", "the sidebar is drawn")
    sidebar.active_panel_category = name
    area().tag_redraw()
    yield from redrawn()


def command_under(where: bpy.types.Region) -> str:
    """Return the Python command of the button under the mouse in a region of the viewport, "" where there is none."""
    with bpy.context.temp_override(window=window(), area=area(), region=where):
        if not bpy.ops.ui.copy_python_command_button.poll():
            return ""
        bpy.ops.ui.copy_python_command_button()
    return bpy.context.window_manager.clipboard


def find_buttons(wanted: str = "", step: int = 14) -> Generator[float, None, dict[str, tuple[int, int]]]:
    """Find operator buttons of the sidebar by hovering down its middle and its quarters.

    No pixel or layout arithmetic, so theme, language, font and order do not matter: Blender's own
    "Copy Python Command" knows which button is under the mouse and which operator it calls.

    Args:
        wanted: how a command begins; stop when it is found.
        step: [px]; a button is 20 high.

    Returns:
        The Python command of each button, such as "bpy.ops.dimple.poke()", and a window position on it.
    """
    sidebar, found = region("UI"), {}
    for share in (0.5, 0.25, 0.75):
        x = sidebar.x + round((sidebar.width - 30) * share)  # the tabs take the last pixels
        for y in range(sidebar.y + sidebar.height - 4, sidebar.y, -step):
            yield from move(x, y)
            command = command_under(sidebar)
            if command:
                found.setdefault(command, (x, y))
            if wanted and command.startswith(wanted):
                for place in ((x, y), (x, y + step)):  # a slow machine may tell what was under the mouse before
                    yield from move(*place)
                    yield from looks(6)
                    if command_under(sidebar) == command:
                        return {**found, command: place}
    return found


def modal_operators() -> set[str]:
    return {operator.bl_idname for operator in window().modal_operators}


def on_screen(point: tuple[float, float, float]) -> tuple[int, int]:
    """Project a world position to a window position [px] in the viewport."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d

    view = region()
    flat = location_3d_to_region_2d(view, area().spaces.active.region_3d, point)
    return round(view.x + flat[0]), round(view.y + flat[1])


def positions(name: str) -> np.ndarray:
    """Read the vertex positions (n, 3) of an object as it is seen, by name: undo replaces the data itself."""
    mesh = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def free_room() -> tuple[float, float, float, float]:
    """Return the left, lower, right and upper end of what is free of the viewport for numbers [px]."""
    with inside():
        return extension("addon.viewport_room").free_room(bpy.context, bpy.context.preferences.system.ui_scale)


def screenshot(path: Path) -> np.ndarray:
    """Grab the whole screen, write it as PNG and return it, (rows from the top, columns, 3) of 0..255.

    Blender's own screenshot operator is black under software OpenGL.
    """
    grab = ["import", "-window", "root", "-depth", "8", "rgb:-"]
    raw = subprocess.run(grab, stdout=subprocess.PIPE, check=True)
    pixels = np.frombuffer(raw.stdout, np.uint8).reshape(HEIGHT, WIDTH, 3)
    rows = np.concatenate([np.zeros((HEIGHT, 1), np.uint8), pixels.reshape(HEIGHT, -1)], axis=1)
    header = struct.pack(">2I5B", WIDTH, HEIGHT, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b"")]
    with path.open("wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n")
        for name, body in chunks:
            out.write(struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)))
    return pixels


def differing(one: np.ndarray, other: np.ndarray, centre: tuple[int, int], half: int) -> int:
    """Count the pixels that differ by more than 6 of 255 in a square round a window position."""
    x, row = centre[0], HEIGHT - 1 - centre[1]
    square = slice(row - half, row + half), slice(x - half, x + half)
    gap = np.abs(one[square].astype(np.int16) - other[square].astype(np.int16)).max(axis=2)
    return int((gap > 6).sum())

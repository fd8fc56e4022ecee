"""What is drawn over the viewport: fingertips, forces, numbers, and a chart of force against depth.

It shows the last Frame of each running session, or without one the calibration, and changes nothing. `gpu` is
imported only when there is something to draw, so the extension also registers where nothing can be drawn.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy

from ..operators import calibration
from ..operators.messages import wrapped
from ..operators.sessions import sessions
from ..operators.translation import translated
from ..operators.under_way import is_blind
from . import dent, readout, room, shapes
from .readout import iface_
from .room import Room
from .shapes import Point, Segment

FINGERTIP = (1.0, 0.62, 0.15, 1.0)
FORCE = (0.95, 0.2, 0.15, 1.0)
LAW = (0.55, 0.75, 1.0, 0.9)
BAND = (0.55, 0.75, 1.0, 0.35)
MEASURED = (1.0, 1.0, 0.55, 0.9)
SIMULATED = (0.3, 0.95, 0.45, 0.95)
TEXT = (1.0, 1.0, 1.0, 1.0)
FAINT = (1.0, 1.0, 1.0, 0.35)
BACK = (0.0, 0.0, 0.0, 0.6)  # dark enough for all of these on a light theme

LINE_WIDTH = 2.0  # in units of Blender's own line width
# all sizes below in pixels at a resolution scale of 1
CROSS = 2.5  # half the width of a measured point
TEXT_SIZE = 12.0
LINE_HEIGHT = 17.0
MARGIN = 16.0
FEWEST = 3  # lines that numbers have at least, or there is no chart: the name, the force, the depth
CHART = (230.0, 130.0)


class Screen(NamedTuple):
    """The region that is drawn in.

    width, height: [px].
    scale: the resolution scale of the interface.
    line: width of a line [px].
    """

    width: float
    height: float
    scale: float
    line: float


class Curves(NamedTuple):
    """The curves of a chart, as points (depth [m], force [N]).

    law: K1, K2 [N/m] and x0 [m] of Eq. (1).
    band: the lower and upper end of the law's 95 % interval.
    measured: of the instrument.
    simulated: of the virtual press.
    trail: of the running session.
    """

    law: Point
    band: tuple[list[Point], list[Point]] = ([], [])
    measured: list[Point] = []
    simulated: list[Point] = []
    trail: list[Point] = []


_handlers: list[tuple[object, str]] = []


def screen_of(context: bpy.types.Context) -> Screen:
    """Return the region that is being drawn; lines are as thick as the preferences say."""
    system, region = context.preferences.system, context.region
    return Screen(region.width, region.height, system.ui_scale, LINE_WIDTH * system.pixel_size)


def overlays_shown(context: bpy.types.Context) -> bool:
    """Return whether overlays are switched on in this viewport."""
    return context.space_data.overlay.show_overlays


def draw_bodies() -> None:
    """Draw fingertips, force arrows, and dents that a mesh cannot show, in the scene (POST_VIEW)."""
    context = bpy.context
    for body, entry in shown_bodies(context):
        dent.draw_dent(body, entry)
        draw_fingers(entry, screen_of(context))


def draw_numbers() -> None:
    """Draw the read-out and the chart of each session on top of the picture (POST_PIXEL)."""
    context = bpy.context
    if is_blind():
        return
    shown = shown_bodies(context)
    calibrated = None if shown else calibrated_curves(context)
    if calibrated and not overlays_shown(context):
        return
    if not shown and not calibrated:
        return
    screen = screen_of(context)
    scale = screen.scale
    free = free_room(context, scale)
    if free is None:
        return
    if calibrated and fits(free, scale, 0):
        draw_curves(calibrated, free[:2], screen)
    for body, entry in shown:
        if context.scene.dimple.show_chart and fits(free, scale, FEWEST):
            end = draw_curves(pressed_curves(body, entry), free[:2], screen)
            free = free._replace(bottom=end + MARGIN * scale)
        end = draw_rows(body, entry, free, scale, numbers=not room.shown_in_sidebar(context, body))
        free = free._replace(bottom=end + MARGIN * scale)


def free_room(context: bpy.types.Context, scale: float) -> Room | None:
    """Return what is free for numbers, None where another of the four views has them."""
    return room.free_room(context, MARGIN * scale, LINE_HEIGHT * scale)


def fits(free: Room, scale: float, lines: int) -> bool:
    """Tell whether a chart with its key has room, and so many lines above it."""
    high = CHART[1] + LINE_HEIGHT + (MARGIN + lines * LINE_HEIGHT if lines else 0.0)
    return free.right - free.left > CHART[0] * scale and free.top - free.bottom > high * scale


def draw_fingers(entry: Any, screen: Screen) -> None:
    """Draw each fingertip that is down, and the force on it where that may be known."""
    for finger, force in _fingers(entry):
        centre, radius = _in_scene(entry, finger)
        draw_lines(shapes.sphere(centre, radius), FINGERTIP, screen)
        if not is_blind():
            draw_lines(shapes.arrow(centre, force, radius), FORCE, screen)


def draw_rows(body: bpy.types.Object, entry: Any, free: Room, scale: float, *, numbers: bool = True) -> float:
    """Write the numbers of a session upwards from the corner of what is free and return where they end [px].

    Args:
        numbers: leave them and the notes out where another part of the interface shows them.
    """
    lines = [(body.name, TEXT)]
    if entry.recorder:
        lines.append((f"● {iface_('Recording')} {entry.recorder.frames}", FORCE))
    if numbers:
        rows = readout.rows(entry.frame, entry.session.tick)
        notes = readout.sentences([*entry.session.model.notes, *filter(None, [entry.refused])], entry.frame)
        lines += [(f"{label}: {value}", TEXT) for label, value in rows]
        lines += [(line, TEXT) for sentence in notes for line in wrapped(translated(sentence, iface_), 60)]
    # what finds no room is left out, the last first
    lines = lines[: max(int((free.top - free.bottom) / (LINE_HEIGHT * scale)), 0)]
    if not lines:
        return free.bottom
    edge, height = 4 * scale, free.bottom
    wide = max(width(line, scale) for line, _ in lines)
    high = len(lines) * LINE_HEIGHT * scale
    draw_filled((free.left - edge, height - edge), (free.left + wide + edge, height + high), BACK)
    for line, colour in reversed(lines):
        write(line, (free.left, height), scale, colour)
        height += LINE_HEIGHT * scale
    return height


def pressed_curves(body: bpy.types.Object, entry: Any) -> Curves:
    """Return the curves of a session's chart: force against depth, and the law of the material that is pressed."""
    which = pressed_material(body, entry)
    material, slot = entry.session.model.materials[which], entry.link.slots[which]
    theirs = body.material_slots[slot].material if slot < len(body.material_slots) else None
    known = _material_curves(theirs.dimple) if theirs else None
    law = (material.K1, material.K2, material.x0)
    trail = [(float(depth), float(force)) for depth, force in entry.trail]
    return (known or Curves(law))._replace(law=law, trail=trail)


def pressed_material(body: bpy.types.Object, entry: Any) -> int:
    """Return the index, in the model, of the material nearest to the deepest fingertip, else of the active one."""
    frame, slots = entry.frame, entry.link.slots
    down = [(depth, which) for depth, which in zip(frame.depths, frame.materials, strict=True) if which >= 0]
    if down:
        return max(down)[1]
    return slots.index(body.active_material_index) if body.active_material_index in slots else 0


def calibrated_curves(context: bpy.types.Context) -> Curves | None:
    """Return the curves while nothing is pressed: of the last calibration, else of the active material's."""
    settings, body = context.scene.dimple, context.object
    if not settings.show_overlay or not settings.show_chart:
        return None
    if record := calibration.load(settings.calibration):
        law = (record["K1"] * 1e3, record["K2"] * 1e3, record["x0"] / 1e3)
        return Curves(law, _band(record), _metres(record["points"]))
    material = body.active_material if body else None
    return _material_curves(material.dimple) if material else None


def _material_curves(settings: bpy.types.PropertyGroup) -> Curves | None:
    """Return the curves of a material, None where it has neither a measured nor a simulated press."""
    record = calibration.load(settings.calibration)
    measured = record.get("points", [])
    simulated = calibration.identification(settings).get("points", [])
    if not measured and not simulated:
        return None
    law = (settings.K1 * 1e3, settings.K2 * 1e3, settings.x0 / 1e3)
    band = ([], []) if settings.edited else _band(record)
    return Curves(law, band, _metres(measured), _metres(simulated))


def _band(record: dict[str, Any]) -> tuple[list[Point], list[Point]]:
    rows = record.get("band", [])
    return _metres([(depth, low) for depth, low, _ in rows]), _metres([(depth, high) for depth, _, high in rows])


def _metres(rows: Sequence[Sequence[float]]) -> list[Point]:
    return [(depth / 1e3, force) for depth, force in rows]


def draw_key(curves: Curves, corner: Point, scale: float) -> float:
    """Write the names of the curves in their colours, from a corner [px]; return where the line ends [px]."""
    law = iface_("Law") + (" ± 95 %" if curves.band[0] else "")
    words = [(law, LAW, curves.law), (iface_("Measured"), MEASURED, curves.measured)]
    words += [(iface_("Simulated"), SIMULATED, curves.simulated), (iface_("Pressed"), FORCE, curves.trail)]
    words = [(word, colour, shown) for word, colour, shown in words if shown]
    wide = sum(width(word, scale) + MARGIN * scale for word, _, _ in words)
    left, top = corner[0], corner[1] + LINE_HEIGHT * scale
    draw_filled(corner, (left + max(wide, CHART[0] * scale), top), BACK)
    for word, colour, _ in words:
        left += write(word, (left, corner[1] + 5 * scale), scale, colour) + MARGIN * scale
    return top


def draw_curves(curves: Curves, corner: Point, screen: Screen) -> float:
    """Draw a chart and its key upwards from a corner [px] and return where they end [px]."""
    scale = screen.scale
    size = (CHART[0] * scale, CHART[1] * scale)
    seen = [*curves.measured, *curves.simulated, *curves.trail]
    # the knee is always in view, to show how far the press has come
    deepest = max([curves.law[2] * 1.1, *(depth for depth, _ in seen)])
    law = shapes.law_curve(*curves.law, deepest)
    ends = (shapes.round_up(deepest), shapes.round_up(max(force for _, force in [*law, *seen])))
    right, top = corner[0] + size[0], corner[1] + size[1]
    draw_filled(corner, (right, top), BACK)
    draw_lines([((corner[0], top), tuple(corner)), (tuple(corner), (right, corner[1]))], FAINT, screen)
    draw_lines(shapes.crosses(shapes.into_box(curves.measured, ends, corner, size), CROSS * scale), MEASURED, screen)
    for end in curves.band:
        draw_lines(shapes.chained(shapes.into_box(end, ends, corner, size)), BAND, screen)
    draw_lines(shapes.chained(shapes.into_box(law, ends, corner, size)), LAW, screen)
    draw_lines(shapes.chained(shapes.into_box(curves.simulated, ends, corner, size)), SIMULATED, screen)
    trail = shapes.into_box(curves.trail, ends, corner, size)
    draw_lines(shapes.chained(trail), FORCE, screen)
    if trail:
        draw_lines(shapes.circle(trail[-1], (4 * scale, 0.0), (0.0, 4 * scale)), FINGERTIP, screen)
    write(f"{ends[1]:g} N", (corner[0] + 4 * scale, top - LINE_HEIGHT * scale), scale)
    write(f"{ends[0] * 1e3:g} mm", (right - 48 * scale, corner[1] + 5 * scale), scale)
    return draw_key(curves, (corner[0], top), scale)


def shown_bodies(context: bpy.types.Context) -> list[tuple[bpy.types.Object, Any]]:
    """Return the sessions to draw in this viewport, each with its object."""
    if not sessions or not context.scene.dimple.show_overlay or not overlays_shown(context):
        return []
    here = {body.session_uid: body for body in context.scene.objects}
    return [(here[uid], entry) for uid, entry in sessions.items() if uid in here]


def _fingers(entry: Any) -> list[tuple[Any, Point]]:
    """Return each fingertip that is down with the force on it [N]."""
    forces = [tuple(map(float, force)) for force in entry.frame.finger_forces]
    forces += [(0.0, 0.0, 0.0)] * len(entry.fingers)
    return [(finger, force) for finger, force in zip(entry.fingers, forces, strict=False) if finger]


def _in_scene(entry: Any, finger: Any) -> tuple[Point, float]:
    """Return the centre and the radius of a fingertip in scene units."""
    x, y, z = finger.position
    centre, edge = entry.to_world((x, y, z)), entry.to_world((x + finger.radius, y, z))
    radius = sum((b - a) ** 2 for a, b in zip(centre, edge, strict=True)) ** 0.5
    return tuple(map(float, centre)), float(radius)


def free_corner(area: bpy.types.Area, scale: float) -> Point:
    """Return the lower left corner [px] beside Blender's own toolbar."""
    tools = next((region for region in area.regions if region.type == "TOOLS"), None)
    return ((tools.width if tools else 0) + MARGIN * scale, 2 * MARGIN * scale)


def draw_lines(segments: Sequence[Segment], colour: Point, screen: Screen) -> None:
    if not segments:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    points = [(*point, 0.0)[:3] for segment in segments for point in segment]
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.uniform_float("viewportSize", (screen.width, screen.height))
    shader.uniform_float("lineWidth", screen.line)
    shader.uniform_float("color", colour)
    gpu.state.blend_set("ALPHA")
    batch_for_shader(shader, "LINES", {"pos": points}).draw(shader)
    gpu.state.blend_set("NONE")


def draw_filled(low: Point, high: Point, colour: Point) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    corners = [(low[0], low[1], 0), (high[0], low[1], 0), (high[0], high[1], 0), (low[0], high[1], 0)]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", colour)
    gpu.state.blend_set("ALPHA")
    batch_for_shader(shader, "TRIS", {"pos": corners}, indices=[(0, 1, 2), (0, 2, 3)]).draw(shader)
    gpu.state.blend_set("NONE")


def write(text: str, at: Point, scale: float, colour: Point = TEXT) -> float:
    """Write a line and return how wide it is [px]."""
    import blf

    font = 0
    blf.size(font, TEXT_SIZE * scale)
    blf.color(font, *colour)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 0.9)
    blf.position(font, at[0], at[1], 0)
    blf.draw(font, text)
    blf.disable(font, blf.SHADOW)
    return width(text, scale)


def width(text: str, scale: float) -> float:
    """Return how wide a line is [px]."""
    import blf

    blf.size(0, TEXT_SIZE * scale)
    return blf.dimensions(0, text)[0]


def register() -> None:
    """Add both draw functions to every 3D viewport."""
    for draw, moment in ((draw_bodies, "POST_VIEW"), (draw_numbers, "POST_PIXEL")):
        _handlers.append((bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", moment), "WINDOW"))


def unregister() -> None:
    """Stop drawing."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(*_handlers.pop())

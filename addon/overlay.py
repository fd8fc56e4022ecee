"""The overlay of the viewport: fingertips, forces, numbers, and a chart of force against depth.

It shows the last Frame of each running session, or the calibration if no session runs, and changes nothing.
"""

from itertools import zip_longest
from typing import Any

import bpy

from ..operators.experiment.blind_trial import is_blind
from ..operators.press.modal_runs import runs
from ..operators.press.sessions import sessions
from ..operators.reporting import wrapped
from ..operators.translation import translated
from . import canvas, device, force_chart, readout, shapes, viewport_room
from .canvas import FINGERTIP, FORCE, LINE_HEIGHT, MARGIN, Screen
from .readout import iface_
from .viewport_room import Room

FEWEST = 3  # lines of text that must fit above a chart, or it is left out: the name, the force, the depth


def draw_bodies() -> None:
    """Draw fingertips and force arrows in the scene (POST_VIEW)."""
    context = bpy.context
    for _, entry in shown_bodies(context):
        draw_fingers(entry, canvas.screen_of(context))


def draw_numbers() -> None:
    """Draw the read-out and the chart of each session on top of the picture (POST_PIXEL)."""
    context = bpy.context
    if is_blind():
        return
    shown = shown_bodies(context)
    calibrated = None if shown else force_chart.calibrated_curves(context)
    if not shown and not (calibrated and canvas.overlays_shown(context)):
        return
    screen = canvas.screen_of(context)
    scale = screen.scale
    free = viewport_room.free_room(context, scale)
    if free is None:
        return
    if calibrated and force_chart.fits(free, scale, 0):
        force_chart.draw_curves(calibrated, free[:2], screen)
    for body, entry in shown:
        matters = len(shown) == 1 or max(entry.frame.depths, default=0) > 0  # of several bodies only the pressed ones
        if matters and context.scene.dimple.show_chart and force_chart.fits(free, scale, FEWEST):
            end = force_chart.draw_curves(force_chart.pressed_curves(body, entry), free[:2], screen)
            free = free._replace(bottom=end + MARGIN * scale)
        end = draw_rows(body, entry, free, scale)
        free = free._replace(bottom=end + MARGIN * scale)


def draw_fingers(entry: Any, screen: Screen) -> None:
    """Draw each fingertip in use, and the force on it unless a blind trial is under way."""
    import gpu

    view = gpu.matrix.get_model_view_matrix()
    for finger, force in zip_longest(entry.fingers, entry.frame.finger_forces):
        if not finger:
            continue
        centre, radius = entry.to_world(finger.position), finger.radius / entry.link.scale
        canvas.draw_lines(shapes.outline(centre, radius, view), FINGERTIP, screen)
        if not is_blind():
            canvas.draw_lines(shapes.arrow(centre, (0.0, 0.0, 0.0) if force is None else force, radius), FORCE, screen)


def draw_rows(body: bpy.types.Object, entry: Any, free: Room, scale: float) -> float:
    """Write the numbers of a session upwards from the lower left corner of the free area; return their top [px]."""
    lines = [(body.name, canvas.ink())]
    if any(run.paused for run in runs):
        lines.append((iface_("Paused"), FORCE))
    lines += [(line, FORCE) for sentence in device.slow() for line in wrapped(sentence, 40)]
    if 0 < readout.rate_hz(entry.frame) * entry.session.clock.tick < 1:
        lines.append((": ".join(readout.real_time(entry.frame, entry.session.clock.tick)), canvas.ink()))
    lines += [(f"{label}: {value}", canvas.ink()) for label, value in readout.rows(entry.frame)]
    notes = readout.warnings(entry)
    lines += [(line, canvas.ink()) for sentence in notes for line in wrapped(translated(sentence, iface_), 60)]
    # lines that do not fit are left out, the last ones first
    lines = lines[: max(int((free.top - free.bottom) / (LINE_HEIGHT * scale)), 0)]
    if not lines:
        return free.bottom
    edge, height = 4 * scale, free.bottom
    wide = max(canvas.width(line, scale) for line, _ in lines)
    high = len(lines) * LINE_HEIGHT * scale
    canvas.draw_filled((free.left - edge, height - edge), (free.left + wide + edge, height + high))
    for line, colour in reversed(lines):
        canvas.write(line, (free.left, height), scale, colour)
        height += LINE_HEIGHT * scale
    return height


def shown_bodies(context: bpy.types.Context) -> list[tuple[bpy.types.Object, Any]]:
    """Return the sessions to draw in this viewport, each with its object."""
    if not sessions or not context.scene.dimple.show_overlay or not canvas.overlays_shown(context):
        return []
    here = {body.session_uid: body for body in context.scene.objects if body.visible_get()}
    return [(here[uid], entry) for uid, entry in sessions.items() if uid in here]


register, unregister = canvas.drawing(draw_bodies, draw_numbers)

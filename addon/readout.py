"""The numbers of a session with their units: force and depth first, in the sidebar or over the viewport."""

from typing import Any

from bpy.app.translations import pgettext_iface

from ..operators.reporting import Note
from ..operators.translation import CONTEXT


def iface_(text: str) -> str:
    """Translate one of our texts into the language of the interface."""
    return pgettext_iface(text, CONTEXT)


def volume_change(frame: Any) -> float:
    """Return the change of volume as a share of the volume at rest; 0 for a body without volume."""
    return frame.volume / frame.rest_volume - 1 if frame.rest_volume > 0 else 0.0


def rate_hz(frame: Any) -> float:
    """Return the ticks that this computer simulates in a second [Hz]; 0 if none was timed."""
    return frame.steps / frame.cost if frame.cost > 0 else 0.0


def rows(frame: Any) -> list[tuple[str, str]]:
    """Return rows (label, number with unit) of the force and depth of each press; zeros if nothing presses."""
    # one value per row, so that a narrow sidebar does not cut off its unit
    lines = []
    touches = enumerate(zip(frame.pushes, frame.depths, strict=True), start=1)
    for number, (force, depth) in [each for each in touches if each[1][1] > 0] or [(1, (0.0, 0.0))]:
        lines.append((iface_("Force {}").format(number), f"{force:.2f} N"))
        lines.append((iface_("Depth {}").format(number), f"{1e3 * depth:.2f} mm"))
    return lines


def real_time(frame: Any, tick: float) -> tuple[str, str]:
    """Return (label, percentage): the speed of the simulation relative to real time, 100 % at most.

    Args:
        tick: control step of the session [s].
    """
    return iface_("Real Time"), f"{min(rate_hz(frame) * tick or 1.0, 1.0):.0%}"


def more_rows(frame: Any, tick: float) -> list[tuple[str, str]]:
    """Return rows (label, number with unit) of the other quantities of a frame."""
    volume = f"{frame.volume * 1e6:.1f} cm³" if frame.volume < 0.1 else f"{frame.volume:.4f} m³"
    return [  # + 0.0 turns -0 into 0
        (iface_("Pressure"), f"{round(frame.pressure / 1e3, 3) + 0.0:.3f} kPa"),
        (iface_("Volume"), volume),
        (iface_("Change of Volume"), f"{round(volume_change(frame), 4) + 0.0:+.2%}"),
        (iface_("Time"), f"{frame.time:.3f} s"),
        real_time(frame, tick),
    ]


def warnings(entry: Any) -> list[str]:
    """Return the messages on a session that an artist has to see."""
    wrong = [note for note in entry.session.model.notes if not isinstance(note, Note)]
    session = entry.session
    return [*wrong, *filter(None, [session.contact_note, session.held_note, entry.refused, entry.frame.note])]

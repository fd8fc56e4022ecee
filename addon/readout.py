"""The numbers of a session with their units: all of them in the sidebar, fewer over the viewport."""

from collections.abc import Sequence
from typing import Any

from bpy.app.translations import pgettext_iface

from .translations import CONTEXT


def iface_(text: str) -> str:
    """Translate a text of ours into the language of the interface."""
    return pgettext_iface(text, CONTEXT)


def finger_numbers(frame: Any) -> list[tuple[int, float, float]]:
    """Return (number, force [N], depth [mm]) of every fingertip in contact."""
    rows = enumerate(zip(frame.pushes, frame.depths, strict=True), start=1)
    return [(i, float(force), float(depth) * 1e3) for i, (force, depth) in rows if depth > 0]


def volume_change(frame: Any) -> float:
    """Return the change of volume as a share of the volume at rest; 0 for a body without volume."""
    return frame.volume / frame.rest_volume - 1 if frame.rest_volume > 0 else 0.0


def rate_hz(frame: Any) -> float:
    """Return the ticks per second that this computer manages [Hz]; 0 when none was timed."""
    return frame.steps / frame.cost if frame.cost > 0 else 0.0


def short_rows(frame: Any, tick: float) -> list[tuple[str, str]]:
    """Return the rows for the viewport, which must not be covered by more: what presses, and what it does inside."""
    hidden = {iface_(label) for label in ("Volume", "Time", "Rate", "Steps per Tick")}
    hidden |= {iface_("Real Time")} if not 0 < rate_hz(frame) * tick < 1 else set()
    return [row for row in rows(frame, tick) if row[0] not in hidden]


def rows(frame: Any, tick: float) -> list[tuple[str, str]]:
    """Return (label, number with unit) of everything in a frame, in the language of the interface.

    Args:
        tick: control step of the session [s].
    """
    # every value has a row of its own, so that a narrow sidebar does not cut off its unit; + 0.0 turns -0 into 0
    lines = []
    for number, force, depth in finger_numbers(frame):
        lines.append((iface_("Force {}").format(number), f"{force:.2f} N"))
        lines.append((iface_("Depth {}").format(number), f"{depth:.2f} mm"))
    lines.append((iface_("Pressure"), f"{round(frame.pressure / 1e3, 3) + 0.0:.3f} kPa"))
    lines.append((iface_("Volume"), volume_text(frame.volume)))
    lines.append((iface_("Change of Volume"), f"{round(volume_change(frame), 4) + 0.0:+.2%}"))
    lines.append((iface_("Time"), f"{frame.time:.3f} s"))
    rate = rate_hz(frame)
    lines.append((iface_("Rate"), f"{rate:.0f} Hz"))
    lines.append((iface_("Steps per Tick"), f"{frame.substeps}"))
    speed = min(rate * tick, 1.0) if rate else 1.0
    lines.append((iface_("Real Time"), f"{speed:.0%}"))  # also at 100 %: a row that comes and goes moves the others
    return lines


def volume_text(volume: float) -> str:
    """Return a volume [m3] in the unit that suits it."""
    return f"{volume * 1e6:.1f} cm³" if volume < 0.1 else f"{volume:.4f} m³"


def sentences(notes: Sequence[str], frame: Any | None) -> list[str]:
    """Return the messages for the artist: notes on the mesh, then that of the last frame."""
    return [*notes, frame.note] if frame is not None and frame.note else list(notes)

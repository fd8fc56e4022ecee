"""The chart of force against depth: the law of a material, its measured points, and the point of a fingertip."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy

from ..core.material import Indenter, law_power
from ..operators.calibrate import results
from . import canvas, shapes
from .canvas import FINGERTIP, LINE_HEIGHT, MARGIN, Screen
from .readout import iface_
from .shapes import Law, Point
from .viewport_room import Room

LAW = (0.55, 0.75, 1.0, 0.9)
HERE = (0.75, 1.0, 0.6, 0.9)
BAND = (0.55, 0.75, 1.0, 0.35)
MEASURED = (1.0, 1.0, 0.55, 0.9)
# [px] the sizes below, at a resolution scale of 1
SIZE = (230.0, 130.0)
CROSS = 2.5  # half the width of a measured point
DOT = 4.0  # radius of a fingertip's point


class Curves(NamedTuple):
    """The curves of a chart, as points (depth [m], force [N])."""

    law: Law  # drawn by `shapes.law_curve`
    band: tuple[list[Point], list[Point]] = ([], [])  # the lower and upper bound of the law's 95 % interval
    measured: list[Point] = []  # points of the instrument
    fingertip: Point | None = None  # point of the deepest fingertip, None if none presses
    here: list[Point] = []  # the law that acts on this fingertip, if it is not the measured one
    name: str = ""  # label of `here`
    begins: str = ""  # the touch and the tare of the measurement, which are the zeros of the axes

    @property
    def seen(self) -> list[Point]:
        """Return the points that the axes must include."""
        return [*self.measured, *([self.fingertip] if self.fingertip else [])]

    @property
    def deepest(self) -> float:
        """Return the depth that the axis must reach [m]; it includes the knee, to relate the press to it."""
        return max([self.law[2] * 1.1, *(depth for depth, _ in self.seen)])


def fits(free: Room, scale: float, lines: int) -> bool:
    """Return whether there is room for a chart with its key and some lines of text above it."""
    high = SIZE[1] + LINE_HEIGHT + (MARGIN + lines * LINE_HEIGHT if lines else 0.0)
    return free.right - free.left > SIZE[0] * scale and free.top - free.bottom > high * scale


def pressed_curves(body: bpy.types.Object, entry: Any) -> Curves:
    """Return the curves of a session's chart: the law of the pressed material, and the point of the fingertip."""
    frame, slots, model = entry.frame, entry.link.slots, entry.session.model
    down = [index for index, material in enumerate(frame.materials) if material >= 0]
    deepest = max(down, key=lambda index: frame.depths[index], default=None)
    if deepest is None:
        which = slots.index(body.active_material_index) if body.active_material_index in slots else 0
    else:
        which = frame.materials[deepest]
    pressed, slot = model.materials[which], slots[which]
    law = (pressed.K1, pressed.K2, pressed.x0, pressed.power)
    theirs = body.material_slots[slot].material if slot < len(body.material_slots) else None
    curves = ((theirs and _material_curves(theirs.dimple)) or Curves(law))._replace(law=law)
    if deepest is None or not frame.depths[deepest] > 0:
        return curves
    curves = curves._replace(fingertip=(float(frame.depths[deepest]), float(frame.pushes[deepest])))
    return curves._replace(**_acting(entry.session, deepest, pressed, curves))


def _acting(session: Any, index: int, material: Any, curves: Curves) -> dict[str, Any]:
    """Return the law that acts on a fingertip and its label, as fields of Curves; {} if it is the measured law."""
    depths = shapes.evenly(curves.deepest)
    forces, radius = session.law(index, depths), session.fingers[index].radius
    if all(abs(force - material.law(depth)) <= 1e-6 * force for force, depth in zip(forces, depths, strict=True)):
        return {}
    if material.indenter != Indenter(shape="sphere", radius=radius):
        name = iface_("Predicted for {} mm").format(f"{1e3 * radius:.3g}")
    else:
        name = iface_("As Painted")
    return {"here": list(zip(depths, forces, strict=True)), "name": name}


def calibrated_curves(context: bpy.types.Context) -> Curves | None:
    """Return the curves to show while nothing is pressed: of the last calibration, else of the active material."""
    settings, body = context.scene.dimple, context.object
    if not settings.show_overlay or not settings.show_chart:
        return None
    if record := results.load(settings.calibration):
        law = (record["K1"] * 1e3, record["K2"] * 1e3, record["x0"] / 1e3, 1.0)
        return Curves(law, _band(record), _metres(record["points"]), begins=_begins(record))
    material = body.active_material if body else None
    return _material_curves(material.dimple) if material else None


def _material_curves(settings: bpy.types.PropertyGroup) -> Curves | None:
    """Return the curves of a material, None if it was not measured."""
    record = results.load(settings.calibration)
    measured = record.get("points", [])
    if not measured:
        return None
    power = law_power(settings.K1, settings.K2, settings.fill.lower(), settings.tip.lower())
    law = (settings.K1 * 1e3, settings.K2 * 1e3, settings.x0 / 1e3, power)
    band = ([], []) if settings.edited or power > 1 else _band(record)  # the band is that of the two-slope law
    return Curves(law, band, _metres(measured), begins=_begins(record))


def _begins(record: dict[str, Any]) -> str:
    return iface_("Touch at {} mm, tare {} N").format(f"{record['contact']:.4g}", f"{record['tare']:.3g}")


def _band(record: dict[str, Any]) -> tuple[list[Point], list[Point]]:
    rows = record.get("band", [])
    return _metres([(depth, low) for depth, low, _ in rows]), _metres([(depth, high) for depth, _, high in rows])


def _metres(rows: Sequence[Sequence[float]]) -> list[Point]:
    return [(depth / 1e3, force) for depth, force in rows]


def draw_key(curves: Curves, corner: Point, scale: float) -> float:
    """Write the names of the curves in their colours, from the lower left corner [px]; return the upper edge [px]."""
    law = iface_("Law") + (" ± 95 %" if curves.band[0] else "")
    words = [
        (law, LAW, curves.law), (iface_("Measured"), MEASURED, curves.measured), (curves.name, HERE, curves.here),
        (iface_("Fingertip"), FINGERTIP, curves.fingertip),
    ]  # fmt: skip
    words = [(word, colour, shown) for word, colour, shown in words if shown]
    wide = sum(canvas.width(word, scale) + MARGIN * scale for word, _, _ in words)
    left, top = corner[0], corner[1] + LINE_HEIGHT * scale
    canvas.draw_filled(corner, (left + max(wide, SIZE[0] * scale), top))
    for word, colour, _ in words:
        left += canvas.write(word, (left, corner[1] + 5 * scale), scale, colour) + MARGIN * scale
    return top


def draw_curves(curves: Curves, corner: Point, screen: Screen) -> float:
    """Draw a chart and its key upwards from the lower left corner [px]; return the upper edge [px]."""
    scale = screen.scale
    size = (SIZE[0] * scale, SIZE[1] * scale)
    law = shapes.law_curve(curves.law, curves.deepest)
    highest = max(force for _, force in [*law, *curves.here, *curves.seen])
    ends = (shapes.round_up(curves.deepest), shapes.round_up(highest))
    right, top = corner[0] + size[0], corner[1] + size[1]
    canvas.draw_filled(corner, (right, top))
    canvas.draw_lines([((corner[0], top), tuple(corner)), (tuple(corner), (right, corner[1]))], canvas.faint(), screen)
    measured = shapes.into_box(curves.measured, ends, corner, size)
    canvas.draw_lines(shapes.crosses(measured, CROSS * scale), MEASURED, screen)
    for end in curves.band:
        canvas.draw_lines(shapes.chained(shapes.into_box(end, ends, corner, size)), BAND, screen)
    canvas.draw_lines(shapes.chained(shapes.into_box(law, ends, corner, size)), LAW, screen)
    canvas.draw_lines(shapes.chained(shapes.into_box(curves.here, ends, corner, size)), HERE, screen)
    if curves.fingertip:
        (at,) = shapes.into_box([curves.fingertip], ends, corner, size)
        canvas.draw_lines(shapes.circle(at, (DOT * scale, 0.0), (0.0, DOT * scale)), FINGERTIP, screen)
    canvas.write(f"{ends[1]:g} N", (corner[0] + 4 * scale, top - LINE_HEIGHT * scale), scale)
    if curves.begins:
        canvas.write(curves.begins, (corner[0] + 4 * scale, top - 2 * LINE_HEIGHT * scale), scale)
    canvas.write(f"{ends[0] * 1e3:g} mm", (right - 48 * scale, corner[1] + 5 * scale), scale)
    return draw_key(curves, (corner[0], top), scale)

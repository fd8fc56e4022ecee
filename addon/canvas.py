"""Drawing over the viewport: colours, sizes, lines, filled boxes and text.

`gpu` is imported only to draw, so the extension also registers in a Blender that cannot draw (background mode).
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import bpy

from .shapes import Point, Segment

FINGERTIP = (1.0, 0.62, 0.15, 1.0)
FORCE = (0.95, 0.2, 0.15, 1.0)
FAINT, BACK = 0.35, 0.6  # opacity of thin lines, and of the background of numbers

LINE_WIDTH = 2.0  # in multiples of the line width of Blender's interface
# [px] the sizes below, at a resolution scale of 1
TEXT_SIZE = 12.0
LINE_HEIGHT = 17.0
MARGIN = 16.0


def drawing(in_scene: Callable[[], None], on_top: Callable[[], None]) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return functions that start and stop drawing in the scene of each viewport and on top of its image."""
    view, handlers = bpy.types.SpaceView3D, list[object]()

    def register() -> None:
        for draw, moment in ((in_scene, "POST_VIEW"), (on_top, "POST_PIXEL")):
            handlers.append(view.draw_handler_add(draw, (), "WINDOW", moment))

    def unregister() -> None:
        while handlers:
            view.draw_handler_remove(handlers.pop(), "WINDOW")

    return register, unregister


class Screen(NamedTuple):
    """The region to draw in."""

    width: float  # [px]
    height: float  # [px]
    scale: float  # the resolution scale of the interface
    line: float  # width of a line [px]


def screen_of(context: bpy.types.Context) -> Screen:
    """Return the region that is being drawn; lines are as thick as the preferences say."""
    system, region = context.preferences.system, context.region
    return Screen(region.width, region.height, system.ui_scale, LINE_WIDTH * system.pixel_size)


def ink() -> Point:
    """Return the theme's text colour over a viewport."""
    return *bpy.context.preferences.themes[0].view_3d.space.text_hi, 1.0


def faint() -> Point:
    """Return the colour of thin lines behind the text."""
    return *ink()[:3], FAINT


def paper() -> Point:
    """Return the background colour of numbers: black behind light text, white behind dark text."""
    return (0.0, 0.0, 0.0, BACK) if sum(ink()[:3]) > 1.5 else (1.0, 1.0, 1.0, BACK)


def overlays_shown(context: bpy.types.Context) -> bool:
    """Return whether overlays are switched on in this viewport."""
    return context.space_data.overlay.show_overlays


def draw(
    kind: str, points: Any, *, colour: Point | None = None, colours: Any = None, indices: Any = None,
    screen: Screen | None = None, behind: bool = True,
) -> None:
    """Draw "LINES", "TRIS" or a "TRI_STRIP" through points, in one colour or with a colour for each point.

    Args:
        screen: the region, for lines with the width `screen.line`.
        behind: also draw the parts that surfaces of the scene hide.
    """
    import gpu
    from gpu_extras.batch import batch_for_shader

    name = "POLYLINE_UNIFORM_COLOR" if screen else "UNIFORM_COLOR" if colour else "SMOOTH_COLOR"
    shader = gpu.shader.from_builtin(name)
    if screen:
        shader.uniform_float("viewportSize", (screen.width, screen.height))
        shader.uniform_float("lineWidth", screen.line)
    if colour:
        shader.uniform_float("color", colour)
    content = {"pos": points} if colour else {"pos": points, "color": colours}
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("NONE" if behind else "LESS_EQUAL")
    batch_for_shader(shader, kind, content, indices=indices).draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def draw_lines(segments: Sequence[Segment], colour: Point, screen: Screen) -> None:
    """Draw straight segments between points in the scene or on the screen [px]."""
    if segments:
        points = [(*point, 0.0)[:3] for segment in segments for point in segment]
        draw("LINES", points, colour=colour, screen=screen)


def draw_filled(low: Point, high: Point) -> None:
    """Fill a rectangle between two corners [px], as the background of numbers."""
    corners = [(low[0], low[1], 0), (high[0], low[1], 0), (high[0], high[1], 0), (low[0], high[1], 0)]
    draw("TRIS", corners, colour=paper(), indices=[(0, 1, 2), (0, 2, 3)])


def write(text: str, at: Point, scale: float, colour: Point | None = None) -> float:
    """Write a line of text, by default in the colour of the theme, and return its width [px]."""
    import blf

    font, colour = 0, colour or ink()
    blf.size(font, TEXT_SIZE * scale)
    blf.color(font, *colour)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, *paper()[:3], 0.9)
    blf.position(font, at[0], at[1], 0)
    blf.draw(font, text)
    blf.disable(font, blf.SHADOW)
    return width(text, scale)


def width(text: str, scale: float) -> float:
    """Return the width of a line of text [px]."""
    import blf

    blf.size(0, TEXT_SIZE * scale)
    return blf.dimensions(0, text)[0]

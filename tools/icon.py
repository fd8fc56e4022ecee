"""Draw the icon of the poke tool into addon/poke_tool.dat: python -m tools.icon

The format is Blender's own for tool icons: triangles in a square of 255 x 255, y upwards; first all corners, then all
colours. Source: BKE_icon_geom_from_memory in Blender's source/blender/blenkernel/intern/icons.cc.
"""

import math
import struct
from pathlib import Path

PATH = Path(__file__).resolve().parents[1] / "addon" / "poke_tool.dat"
BODY, FINGERTIP = (229, 229, 229, 255), (255, 158, 38, 255)
LEFT, RIGHT, BOTTOM, TOP = 22, 233, 40, 150
RADIUS, DEPTH = 44.0, 52.0  # radius of the fingertip, depth of the dent
STRIPS = 28

Point = tuple[float, float]
Triangle = tuple[tuple[Point, Point, Point], tuple[int, int, int, int]]


def skin(x: float) -> float:
    """Return the height of the body's surface: a box with round shoulders and a dent in its middle."""
    share = (x - 127.5) / (RIGHT - 127.5)
    shoulders = (1 - abs(share) ** 8) ** 0.5
    dent = DEPTH * math.exp(-(((x - 127.5) / 36) ** 2))
    return BOTTOM + (TOP - BOTTOM) * shoulders - dent


def triangles() -> list[Triangle]:
    """Return the triangles of the icon, each with its colour."""
    made: list[Triangle] = []
    edges = [LEFT + (RIGHT - LEFT) * i / STRIPS for i in range(STRIPS + 1)]
    for a, b in zip(edges, edges[1:], strict=False):
        corners = ((a, BOTTOM), (b, BOTTOM), (b, skin(b)), (a, skin(a)))
        made += [((corners[0], corners[1], corners[2]), BODY), ((corners[0], corners[2], corners[3]), BODY)]
    centre = (127.5, skin(127.5) + RADIUS + 12)  # the gap separates fingertip and body
    turns = [2 * math.pi * i / STRIPS for i in range(STRIPS + 1)]
    rim = [(centre[0] + RADIUS * math.cos(t), centre[1] + RADIUS * math.sin(t)) for t in turns]
    made += [((centre, a, b), FINGERTIP) for a, b in zip(rim, rim[1:], strict=False)]
    return made


def encoded() -> bytes:
    """Return the bytes of the file."""
    made = triangles()
    corners = [round(c) for points, _ in made for point in points for c in point]
    colours = [c for _, colour in made for c in colour * 3]
    return b"VCO\x00" + struct.pack("4B", 255, 255, 0, 0) + bytes(corners) + bytes(colours)


if __name__ == "__main__":
    PATH.write_bytes(encoded())

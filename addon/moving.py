"""What Blender stores of how a body is simulated, and what all properties share."""

from decimal import Decimal

from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from .translations import CONTEXT

# no property is animatable; labels are looked up where Blender has no words of its own
FIXED = {"options": set(), "translation_context": CONTEXT}

_MOVES = (
    ("AUTO", "Automatic", "The mesh itself where that runs live, else the smallest stand-in within the tolerances"),
    ("MESH", "Mesh Itself", "Every vertex moves by itself, however slow that is"),
    ("STAND_IN", "Stand-In", "A coarser body moves in place of the mesh and carries its skin along"),
)


def exact(value: float, thousands: int = 0) -> float:
    """Return a stored 32-bit value as the number typed (0.61, not 0.6100000143) times a power of a thousand."""
    return float(Decimal(f"{value:.7g}").scaleb(3 * thousands))


def _told(name: str, description: str) -> StringProperty:
    return StringProperty(name=name, description=description, **FIXED)


class Moving:
    """Give an object's settings what moves in place of its mesh, and what the planner made of it."""

    moves: EnumProperty(name="What Moves", description="What is simulated in place of the mesh", items=_MOVES, **FIXED)
    stand_in_vertices: IntProperty(
        name="Vertices", description="About how many vertices the stand-in has",
        default=1000, min=60, max=8000, soft_min=100, **FIXED,
    )  # fmt: skip
    tolerance_mm: FloatProperty(
        name="Skin Within (mm)",
        description="How far the skin of a dent may lie from where the mesh itself would have it (root of mean square)",
        default=0.5, min=0.001, soft_min=0.05, soft_max=5.0, step=10, precision=2, **FIXED,
    )  # fmt: skip
    tolerance_percent: FloatProperty(
        name="Force Within (%)", description="How much the force may differ from that of the mesh itself",
        default=10.0, min=0.1, soft_min=1.0, soft_max=50.0, step=100, precision=0, **FIXED,
    )  # fmt: skip
    plan_key: _told("Plan Key", "What the choice hangs on: when it changes, a new one is made")
    plan_vertices: IntProperty(name="Planned Vertices", description="Of the stand-in; 0 is the mesh itself", **FIXED)
    plan_reason: _told("Plan", "What moves, and why")
    comparison: _told("Comparison", "What every way to simulate this object came to")

    def to_plan(self) -> dict[str, float | str]:
        """Return what moves: "auto", "mesh" or "stand_in", its vertices, and tolerances [m] and as a share."""
        return {
            "moves": self.moves.lower(),
            "vertices": self.stand_in_vertices,
            "tolerance": exact(self.tolerance_mm, -1),
            "force_tolerance": exact(self.tolerance_percent) / 100,
        }

"""The settings of how an object is simulated, and what all stored properties share."""

from decimal import Decimal

from bpy.props import EnumProperty, IntProperty, StringProperty

FIXED = {"options": set()}
KEYED = {"options": {"ANIMATABLE"}}  # a bake and what plays follow its keyframes

_SIMULATED = (
    ("AUTO", "Automatic", "The full mesh, subdivided where it is coarse, or the finest proxy that runs live"),
    ("MESH", "Full Mesh", "Every vertex of the mesh is simulated and no more, however slow or coarse that is"),
    ("PROXY", "Proxy", "A coarser body is simulated in place of the mesh and deforms it"),
)


def exact(value: float, thousands: int = 0) -> float:
    """Return a stored 32-bit value as the number typed (0.61, not 0.6100000143) times a power of a thousand."""
    return float(Decimal(f"{value:.7g}").scaleb(3 * thousands))


def kept_text(name: str, description: str) -> StringProperty:
    """Return a text property for what operators keep with an object, a material or a scene."""
    return StringProperty(name=name, description=description, **FIXED)


class ReductionSettings:
    """The properties of an object that say what is simulated, and the planner's answer."""

    simulated: EnumProperty(
        name="Simulate", description="What is simulated: the full mesh or a proxy", items=_SIMULATED, **FIXED
    )
    proxy_vertices: IntProperty(
        name="Vertices", description="Approximate number of vertices of the proxy",
        default=1000, min=60, max=16000, soft_min=100, **FIXED,
    )  # fmt: skip
    plan_key: kept_text("Plan Key", "Checksum of everything the plan depends on; a new plan is made when it differs")
    plan_vertices: IntProperty(name="Planned Vertices", description="Of the proxy; 0 is the full mesh", **FIXED)
    plan_reason: kept_text("Plan", "What is simulated, and why")

    def to_plan(self) -> dict[str, int | str]:
        """Return simulated, "auto", "mesh" or "proxy", and vertices, of the proxy."""
        return {"simulated": self.simulated.lower(), "vertices": self.proxy_vertices}

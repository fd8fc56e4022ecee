"""The simulation and contact settings of an object, and helpers for all stored properties."""

from decimal import Decimal

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

FIXED = {"options": set()}
KEYED = {"options": {"ANIMATABLE"}}  # bakes and live sessions follow the keyframes of such a property

_SIMULATED = (
    ("AUTO", "Automatic", "Simulate the full mesh if it runs live, otherwise the finest proxy that does. A coarse "
                          "mesh is subdivided"),
    ("MESH", "Full Mesh", "Simulate every vertex of the mesh, however slow, and never subdivide it"),
    ("PROXY", "Proxy", "Simulate a coarser body, which deforms the mesh"),
)


def exact(value: float, thousands: int = 0) -> float:
    """Return a stored 32-bit value as the number typed (0.61, not 0.6100000143) times a power of a thousand."""
    return float(Decimal(f"{value:.7g}").scaleb(3 * thousands))


def switch(name: str, description: str, *, on: bool = False, options: dict[str, set[str]] = FIXED) -> BoolProperty:
    """Return a boolean property."""
    return BoolProperty(name=name, description=description, default=on, **options)


def kept_text(name: str, description: str) -> StringProperty:
    """Return a text property for data that operators store with an object, a material or a scene."""
    return StringProperty(name=name, description=description, **FIXED)


class ReductionSettings:
    """The choice between mesh and proxy for an object, and the planner's decision."""

    simulated: EnumProperty(
        name="Simulate", description="Choose between accuracy and speed: simulate the full mesh, or a coarser proxy "
                                     "that deforms it", items=_SIMULATED, **FIXED
    )
    proxy_vertices: IntProperty(
        name="Vertices", description="How fine the proxy is: its approximate number of vertices. More are slower and "
                                     "more accurate",
        default=1000, min=60, soft_min=100, soft_max=16000, **FIXED,
    )  # fmt: skip
    plan_reason: kept_text("Plan", "What is simulated, and why")

    def to_plan(self) -> dict[str, int | str | bool]:
        """Return simulated ("auto", "mesh" or "proxy"), vertices (of the proxy) and self_contact."""
        return {
            "simulated": self.simulated.lower(), "vertices": self.proxy_vertices, "self_contact": self.self_contact
        }  # fmt: skip


class ContactSettings:
    """The contact settings of an object."""

    collider: switch(
        "Dimple Collider", "Let soft bodies collide with this object, and with each other. Nothing passes through them"
    )
    collider_friction: FloatProperty(
        name="Collider Friction",
        description="How well this object grips bodies that touch it: coefficient of friction, 0 is frictionless",
        default=0.5, min=0.0, soft_max=1.5, precision=2, **FIXED,
    )  # fmt: skip
    is_prop: switch(
        "Falls",
        "Let the collider drop like a rigid weight, and rest on soft bodies, colliders, other props and the ground",
    )
    prop_mass_kg: FloatProperty(
        name="Prop Mass (kg)", description="Mass of the prop", default=1.0, min=0.0, soft_min=0.001, soft_max=100.0,
        step=10, precision=3, **FIXED,
    )  # fmt: skip
    self_contact: switch("Self Contact", "Keep the body from passing through itself where it folds")

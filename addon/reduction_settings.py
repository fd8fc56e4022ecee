"""The settings of how an object is simulated, and what all stored properties share."""

from decimal import Decimal

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .translations import CONTEXT

# labels are translated in a context of our own
FIXED = {"options": set(), "translation_context": CONTEXT}
KEYED = {"options": {"ANIMATABLE"}, "translation_context": CONTEXT}  # a bake and what plays follow its keyframes

_SIMULATED = (
    ("AUTO", "Automatic", "The full mesh, cut finer where it is coarse, or the smallest proxy within the tolerances"),
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
        default=1000, min=60, max=8000, soft_min=100, **FIXED,
    )  # fmt: skip
    tolerance_mm: FloatProperty(
        name="Surface Tolerance (mm)",
        description="Allowed root-mean-square distance of the dented surface from that of the full mesh",
        default=0.5, min=0.001, soft_min=0.05, soft_max=5.0, step=10, precision=2, **FIXED,
    )  # fmt: skip
    tolerance_percent: FloatProperty(
        name="Force Tolerance (%)", description="Allowed difference of the force from that of the full mesh",
        default=10.0, min=0.1, soft_min=1.0, soft_max=50.0, step=100, precision=0, **FIXED,
    )  # fmt: skip
    plan_key: kept_text("Plan Key", "Checksum of everything the plan depends on; a new plan is made when it differs")
    plan_vertices: IntProperty(name="Planned Vertices", description="Of the proxy; 0 is the full mesh", **FIXED)
    plan_faster: IntProperty(
        name="Times Faster", description="How many times faster than slow fingertips it is simulated",
        default=1, **FIXED
    )  # fmt: skip
    plan_slack: FloatProperty(
        name="Slack (m)", description="Parts of the mesh that move by less rest; 0: all of it is simulated",
        default=0.0, **FIXED,
    )  # fmt: skip
    plan_graded: BoolProperty(
        name="Graded", description="The proxy is fine where it will be pressed and coarse elsewhere", **FIXED
    )  # fmt: skip
    plan_cells: kept_text("Plan Cells", "Which vertices move together in a large proxy: it is made sooner from them")
    plan_cells_graded: kept_text("Plan Cells, Graded", "The same of one that is fine where it will be pressed")
    plan_reason: kept_text("Plan", "What is simulated, and why")
    comparison: kept_text("Comparison", "Cost and errors of every variant of this object")

    def to_plan(self) -> dict[str, float | str]:
        """Return the settings in SI units.

        Returns:
            simulated: "auto", "mesh" or "proxy"; vertices: of the proxy; tolerance: of the surface [m];
            force_tolerance: of the force, as a share.
        """
        return {
            "simulated": self.simulated.lower(),
            "vertices": self.proxy_vertices,
            "tolerance": exact(self.tolerance_mm, -1),
            "force_tolerance": exact(self.tolerance_percent) / 100,
        }

"""The settings of a material: its measured constants."""

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ..core.errors import DimpleError
from ..core.fills import FILLS
from ..core.material import DEFAULT_MATERIAL, Indenter, Material
from ..operators.names import TIPS
from .object_settings import FIXED, KEYED, exact, kept_text, switch

_MASS_FROM = (
    ("DENSITY", "Density", "Calculate the mass from the density and the volume of the body"),
    ("MASS", "Mass", "Enter the mass of the whole body"),
)
_FILLS = [(name.upper(), fill.label, fill.description, fill.number) for name, fill in FILLS.items()]


def _mark_edited(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    # changed constants are no longer those that the source measured
    settings.edited = bool(settings.provenance)


def _mark_measured(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    # a preset and a calibration set the source after the constants
    settings.edited = False


LEAST_MM = 0.01  # [mm] smallest softness: 5 N at this depth are 0.5 kN/mm, too hard to be worth pressing


def _softness(settings: bpy.types.PropertyGroup) -> float:
    from ..core.other_tip import softness  # not at import: numpy takes long to load, and enabling must be quick

    try:
        return softness(Material(**settings.to_params())) * 1e3
    except DimpleError:
        return 0.0  # the panel says what is wrong


def _set_softness(settings: bpy.types.PropertyGroup, depth_mm: float) -> None:
    from ..core.other_tip import as_soft

    try:
        scaled = as_soft(Material(**settings.to_params()), exact(max(depth_mm, LEAST_MM), -1))
    except DimpleError:
        return
    settings.K1, settings.K2 = scaled.K1 / 1e3, scaled.K2 / 1e3


def _stiffness(name: str, default: float, description: str) -> FloatProperty:
    return FloatProperty(
        name=name, description=description, default=default / 1e3, min=0.0, soft_min=0.01, soft_max=100.0,
        step=10, precision=3, update=_mark_edited, **KEYED,
    )  # fmt: skip


class DIMPLE_PG_material(bpy.types.PropertyGroup):
    """The constants of one material, as measured on a real object."""

    softness_mm: FloatProperty(
        name="Softness (mm)",
        description="Make the material softer or harder: how deep a fingertip of 10 mm sinks in with 5 N. Changing it "
                    "scales the whole force curve",
        min=LEAST_MM, max=1000.0, soft_min=0.1, soft_max=100.0, step=10, precision=2,
        get=_softness, set=_set_softness, **FIXED,
    )  # fmt: skip
    K1: _stiffness(
        "K1 (N/mm)", DEFAULT_MATERIAL.K1, "How hard the first millimeters are: force per depth, up to the knee"
    )
    K2: _stiffness(
        "K2 (N/mm)", DEFAULT_MATERIAL.K2, "How hard the material is deeper down: force per depth, beyond the knee"
    )
    x0: FloatProperty(
        name="Knee x0 (mm)", description="How deep the soft part is: where the stiffness changes from K1 to K2",
        default=1e3 * DEFAULT_MATERIAL.x0, min=0.0, soft_min=0.1, soft_max=100.0, step=10, precision=2,
        update=_mark_edited, **KEYED,
    )  # fmt: skip
    k: _stiffness(
        "Surface k (N/mm)", DEFAULT_MATERIAL.k,
        "How stiff the skin is against stretching: the stiffer it is, the farther a dent reaches",
    )
    spread_mm: FloatProperty(
        name="Spread (mm)",
        description="How far a dent reaches beyond the fingertip. At 0, it follows from the surface stiffness k",
        default=1e3 * DEFAULT_MATERIAL.spread, min=0.0, soft_max=200.0, step=100, precision=1, **KEYED,
    )  # fmt: skip
    mass_from: EnumProperty(
        name="Mass From", description="Enter the mass directly, or calculate it from a density",
        items=_MASS_FROM, **FIXED,
    )  # fmt: skip
    density: FloatProperty(
        name="Density (kg/m³)", description="How heavy the material is: mass per volume. Water has 1000",
        default=DEFAULT_MATERIAL.density, min=0.0, soft_min=1.0, soft_max=5000.0, step=100, precision=1, **KEYED,
    )  # fmt: skip
    mass_kg: FloatProperty(
        name="Mass (kg)", description="How heavy the body is, as if all of it were made of this material",
        default=0.2, min=0.0, soft_min=0.001, soft_max=100.0, step=1, precision=3, **KEYED,
    )  # fmt: skip
    damping_ratio: FloatProperty(
        name="Damping Ratio", description="How quickly wobbling dies away: 0 is undamped, 1 is critically damped",
        default=DEFAULT_MATERIAL.damping_ratio, min=0.0, max=2.0, soft_max=1.0, precision=2, **KEYED,
    )  # fmt: skip
    friction: FloatProperty(
        name="Friction",
        description="How well the surface grips fingertips and the ground: coefficient of friction, 0 is frictionless",
        default=DEFAULT_MATERIAL.friction, min=0.0, soft_max=1.5, precision=2, **KEYED,
    )  # fmt: skip
    fill: EnumProperty(name="Fill", description="What is inside the surface: it decides how the body gives way and "
                                                "where it bulges", items=_FILLS, **KEYED)
    pressure_kpa: FloatProperty(
        name="Pressure (kPa)",
        description="Inflate or deflate the body: gauge pressure at rest. Positive swells it, negative shrinks it. "
        "K1, K2 and x0 are measured without it",
        default=0.0, min=-100.0, max=1000.0, soft_min=-20.0, soft_max=100.0, step=10, precision=2, **KEYED,
    )  # fmt: skip
    tip: EnumProperty(
        name="Tip", description="Shape of the tip that measured the object",
        items=TIPS, default="SPHERE", **FIXED,
    )  # fmt: skip
    tip_radius_mm: FloatProperty(
        name="Tip Radius (mm)", description="Radius of the tip that measured the object",
        default=1e3 * DEFAULT_MATERIAL.indenter.radius, min=0.01, soft_max=50.0, step=10, precision=2, **FIXED,
    )  # fmt: skip
    provenance: StringProperty(
        name="Source", description="Where these constants come from; empty if they were typed in",
        update=_mark_measured, **FIXED,
    )  # fmt: skip
    edited: switch("Edited", "The constants were changed by hand after they were measured")
    calibration: kept_text("Calibration", "The measurement behind these constants")

    def to_params(self) -> dict[str, object]:
        """Return the keyword arguments of `core.material.Material`, in SI units."""
        mass = {"density": exact(self.density)} if self.mass_from == "DENSITY" else {"mass": exact(self.mass_kg)}
        return {
            "K1": exact(self.K1, 1),  # [N/m]
            "K2": exact(self.K2, 1),
            "k": exact(self.k, 1),
            "x0": exact(self.x0, -1),  # [m]
            "spread": exact(self.spread_mm, -1) or None,
            "indenter": Indenter(shape=self.tip.lower(), radius=exact(self.tip_radius_mm, -1)),
            **mass,
            "damping_ratio": exact(self.damping_ratio),
            "friction": exact(self.friction),
            "fill": self.fill.lower(),
            "pressure": exact(self.pressure_kpa, 1),  # [Pa]
        }

"""The properties that Blender stores: settings of objects, materials and scenes, and unsaved state of the interface.

Operators read these through RNA only (`obj.dimple.to_params()`), so names and units here are the contract.
Panels show the units of the paper (mm, N/mm); `to_params` returns SI units. A running session adopts a changed setting
at its next step, and follows the keyframes of the animatable ones: constants, pins and gravity.
"""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..operators.bridge import sizing
from ..operators.names import MAPS, PLACES
from . import tool
from .device import DevicePlace
from .hand_table import HandTable
from .material_choice import MaterialChoice
from .material_settings import DIMPLE_PG_material
from .object_settings import FIXED, KEYED, ContactSettings, ReductionSettings, exact, kept_text, switch

_SIZE_MODES = (
    ("REAL", "As Modeled", "Press the body at its size in the scene"),
    ("CUSTOM", "Custom Size", "Press the body as a real object of the size that you enter, whatever its size in the "
                              "scene"),
)
_PRESS_BY = (
    ("DEPTH", "Depth", "Press to a set depth, and read the force"),
    (
        "FORCE", "Force",
        "Press straight into the surface with a set force: the softer the body, the deeper the fingertip sinks in",
    ),
)


_FIELDS = (
    ("NONE", "None", "Show the mesh in its own colors"),
    ("PRESSURE", "Contact Pressure", "How hard the surface is pressed (kPa)"),
    ("DEPTH", "Depth", "How far the surface is below its shape at rest (mm)"),
    ("STRETCH", "Stretch", "How much longer or shorter its edges are than at rest (%)"),
)


def _is_fingertip(_settings: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return not candidate.dimple.enabled


def _map(which: int) -> StringProperty:
    _, label, meaning = MAPS[which]
    return StringProperty(name=label, description=f"Vertex group or float attribute that paints {meaning}", **FIXED)


class DIMPLE_PG_object(ContactSettings, MaterialChoice, ReductionSettings, bpy.types.PropertyGroup):
    """The settings that make an object a soft body."""

    enabled: switch("Dimple", "Make this mesh a soft body that can be pressed")
    pinned: switch(
        "Pinned", "Hold a part of the body in place, so that the rest gives way. Otherwise the body can be pushed "
        "away, fall and roll", on=True, options=KEYED,
    )  # fmt: skip
    pin_group: StringProperty(
        name="Pin Group",
        description="Vertex group that is held in place where its weight is 0.5 or more; with Sway, the weight sets "
        "how firmly. If empty, the lowest tenth of the body is held, or the border of a sheet. Make Soft uses a "
        "group named Pin",
        **FIXED,
    )  # fmt: skip
    softness_group: _map(0)
    knee_group: _map(1)
    spread_group: _map(2)
    presses: PointerProperty(
        name="Presses",
        description="The body that this fingertip was made for. While the fingertip is active, Bake and Export act "
        "on that body",
        type=bpy.types.Object,
    )  # fmt: skip
    sway: FloatProperty(
        name="Sway",
        description="How much the whole body swings, sags and trembles when it, its rig or anything that touches it "
        "moves; 0 turns this off. Pins hold it firmly where their weight is 1, and less where it is lower",
        default=0.0, min=0.0, max=1.0, subtype="FACTOR", **KEYED,
    )  # fmt: skip
    sway_hz: FloatProperty(
        name="Frequency (Hz)",
        description="How often the body swings per second at its lowest frequency; 0 takes it from the material",
        default=0.0, min=0.0, soft_max=10.0, max=100.0, step=10, precision=2, **KEYED,
    )  # fmt: skip
    sway_damping: FloatProperty(
        name="Sway Damping", description="How soon the body stops swinging; at 1 it does not swing back",
        default=0.1, min=0.0, max=1.0, subtype="FACTOR", **KEYED,
    )  # fmt: skip
    size_mode: EnumProperty(
        name="Physical Size", description="Press the object at its size in the scene, or as a real object of another "
                                          "size", items=_SIZE_MODES, **FIXED
    )
    size_mm: FloatProperty(
        name="Size (mm)", description="Largest dimension of the real object",
        default=sizing.USUAL_MM, min=0.001, soft_min=1.0, soft_max=5000.0, step=100, precision=1, **FIXED,
    )  # fmt: skip

    def to_params(self) -> dict[str, float | str | tuple[float, float, float] | None]:
        """Return pinned (the pin group, "" for the base, None if nothing is), the group of each map, sway (amount,
        frequency [Hz] and damping; None if the object does not sway) and size (longest side [m]; None if as modelled).
        """
        return {
            "pinned": self.pin_group if self.pinned else None,
            **{f"{name}_group": getattr(self, f"{name}_group") for name, _, _ in MAPS},
            "sway": (self.sway, self.sway_hz, self.sway_damping) if self.sway > 0 else None,
            "size": exact(self.size_mm, -1) if self.size_mode == "CUSTOM" else None,
        }


def _finger(number: int) -> PointerProperty:
    return PointerProperty(
        name=f"Fingertip {number}", description="Object that presses bodies as a fingertip; keyframe it to animate a "
                                                "press",
        type=bpy.types.Object, poll=_is_fingertip,
    )  # fmt: skip


def _follows(setting: str) -> BoolProperty:
    def follow(self: bpy.types.PropertyGroup, on: bool) -> None:
        if on:
            setattr(self, setting, sizing.fitted(self, setting))

    return BoolProperty(
        name="Follow Size", description="Match this value to the size of each body that you press, until you type a "
                                        "value",
        get=lambda self: sizing.follows(self, setting), set=follow, **FIXED,
    )  # fmt: skip


class DIMPLE_PG_scene(DevicePlace, HandTable, bpy.types.PropertyGroup):
    """The settings of a scene: fingertips, surroundings, animation and display of all its sessions."""

    finger_radius_mm: FloatProperty(
        name="Fingertip Radius (mm)",
        description="How large the fingertip is: radius of the tool and of added fingertips, at the physical size of "
                    "the body",
        default=sizing.DEFAULTS["finger_radius_mm"], min=sizing.LEAST_MM, soft_min=0.1, soft_max=1000.0, step=10,
        precision=1, **FIXED,
    )  # fmt: skip
    radius_follows: _follows("finger_radius_mm")
    depth_follows: _follows("press_depth_mm")
    fitted_mm: FloatProperty(
        name="Fitted Size (mm)", description="Size of the body that fingertip and depth were fitted to last",
        default=sizing.USUAL_MM, **FIXED,
    )  # fmt: skip
    active_finger: IntProperty(
        name="Finger", description="Fingertip that the mouse moves", default=1, min=1, max=3, **FIXED
    )
    finger_1: _finger(1)
    finger_2: _finger(2)
    finger_3: _finger(3)
    press_by: EnumProperty(
        name="Press By", description="Press to a set depth, or with a set force. Ctrl F and pen pressure change it",
        items=_PRESS_BY, **FIXED,
    )  # fmt: skip
    press_depth_mm: FloatProperty(
        name="Depth (mm)", description="How deep the fingertip presses",
        default=sizing.DEFAULTS["press_depth_mm"], min=sizing.LEAST_MM, soft_min=0.1, soft_max=1000.0, step=10,
        precision=2, **FIXED,
    )  # fmt: skip
    by_force: BoolProperty(
        name="By Force", description="The tool presses with a force", get=lambda self: self.press_by == "FORCE", **FIXED
    )
    press_force_n: FloatProperty(
        name="Force (N)", description="How hard the fingertip presses",
        default=5.0, min=0.001, soft_min=0.1, soft_max=100.0, step=10, precision=2, **FIXED,
    )  # fmt: skip
    frame_budget_percent: FloatProperty(
        name="Simulation Share (%)",
        description="How much of each second the simulation may use. Blender needs the rest to draw",
        default=60.0, min=5.0, max=95.0, step=500, precision=0, **FIXED,
    )  # fmt: skip
    use_gravity: switch("Gravity", "Let the gravity of the scene act on soft bodies", options=KEYED)
    use_ground: switch("Ground", "Add a floor at height 0 of the scene, for bodies to land on", options=KEYED)
    calibration: kept_text("Calibration", "The last result, until it is applied to a material")
    tip_place: EnumProperty(name="Press At", description="Where the tip presses", items=PLACES, **FIXED)
    cache_dir: StringProperty(
        name="Cache Folder",
        description="Folder for bakes. Empty: beside the .blend file, or Dimple's own folder for "
                    "unsaved files",
        subtype="DIR_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip
    show_overlay: switch("Overlay", "Draw fingertips, forces and numbers in the viewport", on=True)
    show_field: EnumProperty(
        name="Colors", description="Color bodies by pressure, depth or stretch, with a scale", items=_FIELDS, **FIXED
    )
    show_chart: switch("Chart", "Draw force against depth, with the material's curve", on=True)


class DIMPLE_PG_window_manager(bpy.types.PropertyGroup):
    """The state of the interface, which is not saved."""

    radius_zoom: FloatVectorProperty(
        name="Zoom", description="Pixels per millimeter of the fingertip's radius", size=2, get=tool.radius_zoom,
        options={"SKIP_SAVE"},
    )  # fmt: skip
    amount_zoom: FloatVectorProperty(
        name="Zoom", description="Pixels per millimeter of depth, or per newton", size=2, get=tool.amount_zoom,
        options={"SKIP_SAVE"},
    )  # fmt: skip


_POINTERS = (
    (bpy.types.Material, DIMPLE_PG_material),
    (bpy.types.Object, DIMPLE_PG_object),
    (bpy.types.Scene, DIMPLE_PG_scene),
    (bpy.types.WindowManager, DIMPLE_PG_window_manager),
)
_register_classes, _unregister_classes = bpy.utils.register_classes_factory([group for _, group in _POINTERS])


def register() -> None:
    _register_classes()
    for owner, group in _POINTERS:
        owner.dimple = PointerProperty(type=group, name="Dimple", description="Settings of Dimple")


def unregister() -> None:
    for owner, _ in reversed(_POINTERS):
        del owner.dimple
    _unregister_classes()

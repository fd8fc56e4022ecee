"""The preferences of the extension: the share of CPU cores, and the haptic device."""

import bpy
from bpy.props import IntProperty

from ..operators.names import Op
from .device import DeviceChoice


class DIMPLE_AP_preferences(DeviceChoice, bpy.types.AddonPreferences):
    """The settings that apply to every file."""

    bl_idname = __package__.rpartition(".")[0]  # the extension itself: bl_ext.<repository>.dimple

    cores: IntProperty(
        name="Cores While Playing",
        description="Share of the processor's cores that simulate soft bodies while you press or play. Blender has "
                    "the rest. A bake uses all cores",
        subtype="PERCENTAGE", default=75, min=1, max=100,
    )  # fmt: skip

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "cores")
        layout.prop(self, "device_secret")
        layout.prop(self, "device_anywhere")
        layout.operator(Op.COPY_REPORT, icon="COPYDOWN")

"""The preferences of the extension: the name of its tab, the folder for recordings, and the haptic device."""

import bpy
from bpy.props import StringProperty

from ..operators.names import Op
from . import panels
from .device import DeviceChoice

PACKAGE = __package__.rpartition(".")[0]  # the extension itself: bl_ext.<repository>.dimple


class DIMPLE_AP_preferences(DeviceChoice, bpy.types.AddonPreferences):
    """The settings that are the same in every file."""

    bl_idname = PACKAGE

    tab_name: StringProperty(
        name="Sidebar Tab", description="Show the panels in a tab of this name, in the sidebar of the 3D viewport",
        default=panels.TAB, update=lambda preferences, _context: panels.move_to_tab(preferences.tab_name),
    )  # fmt: skip
    cache_dir: StringProperty(
        name="Default Cache Folder",
        description="Folder for recordings and bakes of unsaved files, unless the scene names one. Empty: Dimple's own"
                    " folder",
        subtype="DIR_PATH",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "tab_name")
        layout.prop(self, "cache_dir")
        layout.prop(self, "device_secret")
        layout.prop(self, "device_anywhere")
        layout.operator(Op.COPY_REPORT, icon="COPYDOWN")


_register_classes, _unregister_classes = bpy.utils.register_classes_factory([DIMPLE_AP_preferences])


def register() -> None:
    """Register the preferences and move the sidebar's panels to the tab the user chose."""
    _register_classes()
    addon = bpy.context.preferences.addons.get(PACKAGE)
    if addon is not None:  # enabled without being kept in the preferences, as a script may do
        panels.move_to_tab(addon.preferences.tab_name)


def unregister() -> None:
    _unregister_classes()

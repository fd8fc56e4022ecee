"""The preferences of the extension: the name of its tab and the folder for recordings."""

import bpy
from bpy.props import StringProperty

from . import panels

PACKAGE = __package__.rpartition(".")[0]  # the extension itself: bl_ext.<repository>.dimple


def _move_tab(preferences: bpy.types.AddonPreferences, _context: bpy.types.Context) -> None:
    panels.move_to_tab(preferences.tab_name)


class DIMPLE_AP_preferences(bpy.types.AddonPreferences):
    """The settings that are the same in every file."""

    bl_idname = PACKAGE

    tab_name: StringProperty(
        name="Sidebar Tab", description="Name of the tab in the sidebar of the 3D viewport",
        default=panels.TAB, update=_move_tab,
    )  # fmt: skip
    cache_dir: StringProperty(
        name="Default Cache Folder",
        description="Where recordings go when neither the scene names a folder nor the file is saved. "
        "Empty: Dimple's own folder",
        subtype="DIR_PATH",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw both settings."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "tab_name")
        layout.prop(self, "cache_dir")


_register_classes, _unregister_classes = bpy.utils.register_classes_factory([DIMPLE_AP_preferences])


def register() -> None:
    """Register the preferences and move the sidebar's panels to the tab the user chose."""
    _register_classes()
    addon = bpy.context.preferences.addons.get(PACKAGE)
    if addon is not None:  # enabled without being kept in the preferences, as a script may do
        panels.move_to_tab(addon.preferences.tab_name)


def unregister() -> None:
    """Unregister the preferences."""
    _unregister_classes()

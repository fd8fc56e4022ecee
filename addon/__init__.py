"""What Blender shows and stores: properties, presets, panels, preferences, overlay, tool and translations."""

from .. import operators
from . import (
    fingertip_gizmo,
    material_choice,
    overlay,
    panels,
    preferences,
    presets,
    properties,
    reduction,
    still_warning,
    surface_colours,
    tool,
    translations,
)

# in order of dependence: operators read the properties, panels name the operators and the presets' popover,
# the preferences move the panels
PARTS = (
    translations, material_choice, properties, operators, presets, panels, reduction, preferences, surface_colours,
    overlay, fingertip_gizmo, tool, still_warning,
)  # fmt: skip


def register() -> None:
    """Register every part."""
    for part in PARTS:
        part.register()


def unregister() -> None:
    """Unregister every part, the last first."""
    for part in reversed(PARTS):
        part.unregister()

"""The interface and the stored settings: properties and panels, pictures of materials, the tool and its gizmo, the
overlay with its charts and colours, preferences, and translations.
"""

from .. import operators
from . import (
    fingertip_gizmo,
    material_choice,
    my_materials,
    overlay,
    panels,
    preferences,
    properties,
    still_warning,
    surface_colours,
    tool,
    translations,
)

# in order of dependency: operators read the properties; panels refer to the operators and to the popover of presets
PARTS = (
    translations, material_choice, properties, operators, my_materials, panels, preferences, surface_colours,
    overlay, fingertip_gizmo, tool, still_warning,
)  # fmt: skip


def register() -> None:
    for part in PARTS:
        operators.registration(part)[0]()


def unregister() -> None:
    for part in reversed(PARTS):
        operators.registration(part)[1]()

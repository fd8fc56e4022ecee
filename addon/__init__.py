"""What Blender shows and stores."""

from .. import operators
from . import methods, overlay, panels, preferences, presets, properties, tool, translations

# in order of need: operators read the properties, panels name the operators and the presets' popover,
# the preferences move the panels
PARTS = (translations, properties, operators, presets, panels, preferences, overlay, methods, tool)


def register() -> None:
    """Register every part."""
    for part in PARTS:
        part.register()


def unregister() -> None:
    """Unregister every part, the last first."""
    for part in reversed(PARTS):
        part.unregister()

"""The choice of an object's material among pictures, softest first: a ball of each, pressed with the same 5 N.

`dev.py samples` makes the pictures.
"""

from pathlib import Path

import bpy
from bpy.props import EnumProperty
from bpy.utils import previews

from ..core.errors import DimpleError
from ..operators.bridge.material_presets import give
from .object_settings import FIXED
from .readout import iface_

PICTURES = Path(__file__).parent / "pictures"
Item = tuple[str, str, str, int | str, int]

_items: dict[str, list[Item]] = {}  # by language; kept, because Blender does not copy the strings of dynamic items
_pictures: list[previews.ImagePreviewCollection] = []


def choices(_settings: bpy.types.PropertyGroup | None, _context: bpy.types.Context | None) -> list[Item]:
    """Return the known materials as enum items: identifier, name, source, picture, number; 0 is a custom material."""
    from ..core.everyday_presets import OBJECTS  # not at import: it needs numpy, and enabling must be quick

    if not _pictures:
        _pictures.append(previews.new())
        for preset in OBJECTS:
            _pictures[0].load(preset.name, str(PICTURES / f"{preset.name}.webp"), "IMAGE")
    language = bpy.app.translations.locale
    if language not in _items:  # Blender does not translate the items of a grid of pictures
        _items[language] = [
            (each.name, iface_(each.label), iface_(each.provenance), _pictures[0][each.name].icon_id, number)
            for number, each in enumerate(OBJECTS, start=1)
        ]
        own = iface_("Custom"), iface_("Your own constants, typed in or measured")
        _items[language].append(("OWN", *own, "MATERIAL", 0))
    return _items[language]


def _in_use(settings: bpy.types.PropertyGroup) -> int:
    from ..core.everyday_presets import OBJECTS, found
    from ..core.material import DEFAULT_MATERIAL, Material

    material = settings.id_data.active_material
    try:
        preset = found(Material(**material.dimple.to_params()) if material else DEFAULT_MATERIAL)
    except DimpleError:
        return 0
    return OBJECTS.index(preset) + 1 if preset else 0


def _use(settings: bpy.types.PropertyGroup, number: int) -> None:
    from ..core.everyday_presets import OBJECTS

    if number:
        give(settings.id_data, OBJECTS[number - 1])


class MaterialChoice:
    """The property of an object that chooses one of the known materials."""

    material: EnumProperty(
        name="Material", description="Choose what the object is made of, from soft to hard. Each picture shows a press"
                                     " with 5 N",
        items=choices, get=_in_use, set=_use, **FIXED,
    )  # fmt: skip


def draw_choice(layout: bpy.types.UILayout, body: bpy.types.Object) -> None:
    """Draw the material's picture, which opens the grid of pictures, and its name, which opens the list."""
    column = layout.column(align=True)
    material = body.active_material
    column.enabled = material is None or material.library is None
    column.template_icon_view(body.dimple, "material", show_labels=True, scale=5.0, scale_popup=4.2)
    column.prop(body.dimple, "material", text="")


def unregister() -> None:
    _items.clear()
    while _pictures:
        previews.remove(_pictures.pop())

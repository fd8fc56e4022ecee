"""A material as one small file, to share or drop into a viewport: constants, intervals, source, tip, date, license."""

from datetime import date
from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from ...core.errors import DimpleError
from ...core.material import Material
from ...core.message import from_json, to_json
from ..bridge.material_presets import material_of
from ..names import Op
from ..press import polls
from . import results
from .from_file import Dropped, Opened, Saved, shown_files

ENDING = ".dimple"
LARGEST = 2**20  # [bytes] read at most; a material has some 20 kB
# set in this order: constants mark the material as edited, the source clears the mark, `edited` restores the saved one
VALUES = (
    "K1", "K2", "x0", "k", "spread_mm", "mass_from", "density", "mass_kg", "damping_ratio", "friction", "fill",
    "pressure_kpa", "tip", "tip_radius_mm", "calibration", "provenance", "edited",
)  # fmt: skip


class DIMPLE_OT_save_material(polls.Declared, Saved, bpy.types.Operator):
    """Save the active material as a small file to share: constants, intervals, source, tip, date and license"""

    bl_idname = Op.SAVE_MATERIAL
    bl_label = "Save Material to File"
    filename_ext = ENDING

    filter_glob: shown_files(f"*{ENDING}")
    license: StringProperty(name="License", description="What others may do with the constants", default="CC0-1.0")

    needs = (polls.need(lambda context: context.object and context.object.active_material, "Apply a material first"),)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        self.filepath = bpy.path.clean_name(context.object.active_material.name) + ENDING
        return Saved.invoke(self, context, event)

    def run(self, context: bpy.types.Context) -> None:
        material = context.object.active_material
        record = {"name": material.name, "license": self.license, "date": date.today().isoformat()}
        record |= {name: getattr(material.dimple, name) for name in VALUES}
        record["calibration"] = results.load(material.dimple.calibration)
        path = bpy.path.ensure_ext(bpy.path.abspath(self.filepath), ENDING)
        try:
            Path(path).write_text(to_json(record) + "\n", encoding="utf-8")
        except OSError as error:
            raise DimpleError("{path} cannot be written: {error}.", path=path, error=error.strerror) from None


class DIMPLE_OT_open_material(Opened, polls.Declared, bpy.types.Operator):
    """Give the active object the material of a Dimple material file"""

    bl_idname = Op.OPEN_MATERIAL
    bl_label = "Open Material File"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: shown_files(f"*{ENDING}")

    needs = polls.in_object_mode, polls.needs_mesh, polls.is_own

    def run(self, context: bpy.types.Context) -> None:
        path, body = Path(bpy.path.abspath(self.filepath)), context.object
        try:
            with path.open(encoding="utf-8") as file:
                record = from_json(file.read(LARGEST))
            record |= {"calibration": to_json(record["calibration"]) if record["calibration"] else ""}
            Material(**{name: 1e3 * record[name] for name in ("K1", "K2", "k")}, x0=record["x0"] / 1e3, density=1.0)
            trial = bpy.data.materials.new(record["name"])  # a bad value must not leave a material half changed
            try:
                _set(trial, record)
            finally:
                bpy.data.materials.remove(trial)
            _set(material_of(body, record["name"]), record)
        except OSError as error:
            raise DimpleError("{name} cannot be read: {error}.", name=path.name, error=error.strerror) from None
        except DimpleError:
            raise
        except (KeyError, TypeError, ValueError):
            raise DimpleError("{name} is not a material that Dimple saved.", name=path.name) from None
        body.dimple.enabled = True


def _set(material: bpy.types.Material, record: dict[str, Any]) -> None:
    for name in VALUES:
        setattr(material.dimple, name, record[name])


class DIMPLE_FH_material(Dropped, bpy.types.FileHandler):
    """Open a material file that is dropped into the viewport."""

    bl_idname = "DIMPLE_FH_material"
    bl_label = "Dimple Material"
    bl_import_operator = Op.OPEN_MATERIAL
    bl_file_extensions = ENDING

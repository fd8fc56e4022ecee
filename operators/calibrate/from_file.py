"""Calibrate from an instrument's file, with the result in the scene: by file browser, drag and drop, or script.

If the file leaves something open, a dialog asks the core's question, with a preview of each answer; nothing is guessed.
"""

from dataclasses import Field, fields
from functools import lru_cache
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ...core.calibration.question import Answers, Undecided
from ...core.material import Indenter
from ...core.message import to_json
from ..names import TIPS, Op
from ..press import polls
from ..reporting import say, wrapped
from ..translation import translated
from . import results

if TYPE_CHECKING:
    from ...core.calibration.calibrate import Calibration

OPEN = "NONE"  # the answer to a question that is still open
ASKED_AT_ONCE = 4
WIDTH, CHARACTERS = 640, 96  # width of the dialog [px], and number of characters that fit on a line of it
DETECTED = "detected"
HIDDEN = {"HIDDEN", "SKIP_SAVE"}


@lru_cache(maxsize=32)
def _items(asked: str, number: int) -> list[tuple[str, str, str]]:
    """Return the answers to a question as enum items; the cache keeps their strings alive, as Blender requires."""
    found = results.load(asked).get("questions", [])
    candidates = found[number]["candidates"] if number < len(found) else []
    return [(OPEN, "Choose", ""), *((str(i), c["value"], c["label"]) for i, c in enumerate(candidates))]


def _answer(number: int) -> EnumProperty:
    return EnumProperty(
        name="Answer", description="Answer to a question that the file leaves open", options=HIDDEN,
        items=lambda operator, _context: _items(operator.asked, number),
    )  # fmt: skip


def _property(field: Field):
    """Return the Blender property for one of the core's Answers; hidden if only a script or a question sets it."""
    kind, choices = str(field.type), field.metadata["choices"]
    how = {"name": field.metadata["label"], "description": field.metadata["text"], "options": {"SKIP_SAVE"}}
    if choices:
        items = [(DETECTED, "Detected", "Take it from the file"), *((each, each.capitalize(), "") for each in choices)]
        return EnumProperty(items=items, **how)
    if kind.startswith("float"):
        return FloatProperty(precision=4, **how)
    how["options"] = HIDDEN
    return IntProperty(min=0, **how) if kind.startswith("int") else StringProperty(**how)


class Tip:
    """Give an operator properties for the tip and for the size of the measured object."""

    tip: EnumProperty(name="Tip", description="Shape of the tip that pressed the object", items=TIPS)
    tip_radius_mm: FloatProperty(
        name="Tip Radius (mm)", description="Radius of that tip", default=2.0, min=0.01, soft_max=50.0
    )
    length_mm: FloatProperty(
        name="Object Size (mm)", description="Edge length of the measured object, for k; 0 if unknown",
        default=0.0, min=0.0, soft_max=1000.0, options={"SKIP_SAVE"},
    )  # fmt: skip

    def measured(self) -> dict:
        """Return the tip, and the size of the object, as arguments of the core."""
        tip = Indenter(shape=self.tip.lower(), radius=self.tip_radius_mm / 1e3)
        return {"tip": tip, "length": self.length_mm / 1e3 or None}

    def take_size(self, context: bpy.types.Context) -> None:
        """Start with the size of the active object if it has a custom size."""
        body = context.object
        if body and body.dimple.size_mode == "CUSTOM" and not self.properties.is_property_set("length_mm"):
            self.length_mm = body.dimple.size_mm

    def keep(self, context: bpy.types.Context, found: "Calibration") -> None:
        """Store a result in the scene, and report it."""
        context.scene.dimple.calibration = results.to_text(found)
        record = results.load(context.scene.dimple.calibration)
        for warning in record["warnings"]:
            say(self, {"WARNING"}, translated(warning).partition("\n")[0])
        say(self, {"INFO"}, results.source(record, record["source_of_k"]))


def shown_files(pattern: str) -> StringProperty:
    """Return the property by which a file browser shows only some files."""
    return StringProperty(name="Filter", description="Files that are shown", options={"HIDDEN"}, default=pattern)


class Opened:
    """Give an operator a file to read, which it asks for unless the file is dropped, or named by a script."""

    filepath: StringProperty(name="File", description="File to read", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if self.properties.is_property_set("filepath"):
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}


class DIMPLE_OT_calibrate(Tip, Opened, polls.Declared, bpy.types.Operator):
    """Fit a material to the force-depth file of an instrument: CSV or text, as the instrument wrote it"""

    bl_idname = Op.CALIBRATE
    bl_label = "Calibrate"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: shown_files(results.FILTER)
    asked: StringProperty(name="Question", description="Question that the file leaves open", options=HIDDEN)
    found: StringProperty(name="Found", description="Touch and tare that the fit found", options=HIDDEN)
    answer_0: _answer(0)
    answer_1: _answer(1)
    answer_2: _answer(2)
    answer_3: _answer(3)

    needs = (polls.in_object_mode,)  # there the result is one undo step

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file, or the questions that it leaves open; a dropped file is read at once."""
        self.take_size(context)
        if self.asked:
            for number, question in enumerate(results.load(self.asked)["questions"][:ASKED_AT_ONCE]):
                values = [candidate["value"] for candidate in question["candidates"]]
                if question["default"] in values:  # the likeliest answer is preselected
                    setattr(self, f"answer_{number}", str(values.index(question["default"])))
            return context.window_manager.invoke_props_dialog(self, width=WIDTH, title=translated("Which is right?"))
        return Opened.invoke(self, context, event)

    def run(self, context: bpy.types.Context) -> set[str] | None:
        """Read the file and fit the law; if that fails, the last result stays."""
        from ...core.calibration.calibrate import calibrate

        try:
            if not self._take_answers():
                return self._ask(context, self.asked, "")
            found = calibrate(self.filepath, self._answers(), **self.measured())
        except Undecided as undecided:
            return self._ask(context, to_json(undecided.to_record()), str(undecided))
        self.keep(context, found)
        return self._show(contact_mm=found.loading.reading(0.0), tare_n=found.loading.tare)

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw the questions, or if there are none the touch, the tare, the tip, the size of the object and
        options of the file.
        """
        layout = self.layout
        if self.asked:
            return self._draw_questions(layout)
        layout.use_property_split = True
        for name in (*_KEPT, "press"):
            layout.prop(self, name)
        return None

    def _draw_questions(self, layout: bpy.types.UILayout) -> None:
        for number, question in enumerate(results.load(self.asked)["questions"][:ASKED_AT_ONCE]):
            column = layout.column(align=True)
            for line in wrapped(translated(question["text"]), CHARACTERS):
                column.label(text=line, translate=False)
            for i, candidate in enumerate(question["candidates"]):
                text = f"{candidate['value']}   {translated(candidate['label'])}"
                column.prop_enum(self, f"answer_{number}", str(i), text=text, translate=False)

    def _take_answers(self) -> bool:
        """Turn the choices of the dialog into answers; return False if a question is still open."""
        for number, question in enumerate(results.load(self.asked).get("questions", [])[:ASKED_AT_ONCE]):
            chosen = getattr(self, f"answer_{number}")
            if chosen == OPEN:
                return False
            value, name = question["candidates"][int(chosen)]["value"], question["name"]
            setattr(self, name, type(getattr(self, name))(value))
        self.asked = ""
        return True

    def _answers(self) -> Answers:
        """Return the answers that are given."""
        given = {name: getattr(self, name) for name in _ANSWERS if getattr(self, name) not in ("", 0, DETECTED)}
        return Answers(**given, **{name: getattr(self, name) for name in _NUMBERS if self._is_typed(name)})

    def _is_typed(self, name: str) -> bool:
        """Return whether a property was set to another value than the fit found."""
        return self.properties.is_property_set(name) and getattr(self, name) != results.load(self.found).get(name)

    def _show(self, **used: float) -> None:
        """Show what the fit found in the fields, where it can be changed while the chart follows."""
        found = [name for name in used if not self._is_typed(name)]
        for name in found:
            setattr(self, name, used[name])
        self.found = to_json({name: getattr(self, name) for name in found})

    def _ask(self, context: bpy.types.Context, asked: str, message: str) -> set[str]:
        """Open the dialog with the open questions; in background mode, report an error instead."""
        if bpy.app.background:
            say(self, {"ERROR"}, message or "A question in the dialog has no answer.")
            return {"CANCELLED"}
        given = {name: getattr(self, name) for name in _KEPT if self._is_typed(name)}
        given |= {name: getattr(self, name) for name in _ANSWERS if getattr(self, name)}
        bpy.ops.dimple.calibrate("INVOKE_DEFAULT", **(given | {"filepath": self.filepath, "asked": asked}))
        return {"CANCELLED"}  # the new call continues


# a property for each answer to a question that a file may leave open
DIMPLE_OT_calibrate.__annotations__ |= {field.name: _property(field) for field in fields(Answers)}
_NUMBERS = ("contact_mm", "tare_n", "until_mm")
_ANSWERS = tuple(field.name for field in fields(Answers) if field.name not in _NUMBERS)
_KEPT = (*_NUMBERS, "tip", "tip_radius_mm", "length_mm")


class Saved(ExportHelper):
    """Give an operator a file to write; its name is completed before Blender asks whether to overwrite the file."""

    filepath: StringProperty(name="File", description="Path of the file", subtype="FILE_PATH", options={"SKIP_SAVE"})
    check_existing: BoolProperty(
        name="Check Existing", description="Ask before a file is overwritten", options={"HIDDEN"}, default=True
    )


class Dropped:
    """Accept files that are dropped into a 3D viewport."""

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Return whether the files are over a 3D viewport."""
        return context.area is not None and context.area.type == "VIEW_3D"


class DIMPLE_FH_force_depth(Dropped, bpy.types.FileHandler):
    """Calibrate from a file that is dropped into the viewport."""

    bl_idname = "DIMPLE_FH_force_depth"
    bl_label = "Force-Depth Measurement"
    bl_import_operator = Op.CALIBRATE
    bl_file_extensions = results.EXTENSIONS

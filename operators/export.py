"""File > Export > Dimple Animation: one dialog for every format."""

import contextlib
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ..core.messages import Message
from . import modal_runs, polls, sessions
from .messages import conclude, duration, megabytes, wrapped
from .names import EXPORTS, Op
from .translation import translated
from .working import READY, Working

CHARACTER = 8.5  # [px] of a line of the dialog for each character, its icon and borders included
_ASKED = ("formats", "source", "frame_start", "frame_end", "step", "key_error", "normals", "overwrite")
_SOURCES = (
    ("PLAYED", "Bake or Recording", "What the objects play; those that play nothing are simulated"),
    ("SIMULATE", "Simulate Anew", "Simulate the objects as a bake does, whatever they play"),
)


def _measure(_settings: bpy.types.OperatorProperties, context: bpy.types.Context) -> None:
    """Measure what a choice in the dialog takes: Blender's file browser calls no `check` for it."""
    dialog = getattr(context.space_data, "active_operator", None)
    if dialog is not None and dialog.bl_idname == DIMPLE_OT_export_animation.__name__:
        dialog.measure(context)


class DIMPLE_OT_export_animation(Working, bpy.types.Operator):
    """Export the press of the selected bodies, with a table of forces and a JSON that describes the files"""

    bl_idname = Op.EXPORT
    bl_label = "Export Animation"
    verb, stopped = "Exporting", "The export was cancelled; the files that were finished are kept"
    ready = READY

    directory: StringProperty(
        name="Folder", description="Where the files go, named after the objects", subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip
    formats: EnumProperty(
        name="Formats", description="What to write", items=EXPORTS, options={"ENUM_FLAG"}, default={"ALEMBIC"},
        update=_measure,
    )  # fmt: skip
    source: EnumProperty(
        name="Source", description="What is exported", items=_SOURCES, update=_measure,
        translation_context="*",  # Blender's word: ours is where a number comes from
    )  # fmt: skip
    frame_start: IntProperty(name="First Frame", description="By default the scene's first frame", default=1)
    frame_end: IntProperty(name="Last Frame", description="By default the scene's last frame", default=250)
    step: IntProperty(
        name="Frame Step",
        description="In formats with shape keys, one for this many frames; the JSON says how far those between are off",
        default=1, min=1, soft_max=25,
    )  # fmt: skip
    key_error: FloatProperty(
        name="Key Error (%)",
        description="In formats with shape keys, few with which no vertex is off by more of the object's size. "
        "0 makes one every n frames",
        default=0.0, min=0.0, soft_max=1.0, max=100.0, precision=3,
    )  # fmt: skip
    normals: BoolProperty(
        name="Normals", description="Write the normals that shade the surface; files are larger",
        default=True, update=_measure,
    )  # fmt: skip
    overwrite: BoolProperty(name="Overwrite", description="Replace files that are there already", default=False)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, and nothing else at work."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode to export")
        return polls.is_free(cls)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder, then export between Blender's events."""
        if self.properties.is_property_set("directory"):
            return Working.invoke(self, context, event)
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self._browsing = True
        self.measure(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def measure(self, context: bpy.types.Context) -> None:
        """Measure how long the export will take; not while a body is live, whose mesh is in use."""
        from ..core.base import DimpleError
        from . import export_time

        if not sessions.sessions:
            with contextlib.suppress(DimpleError):  # which `draw` says
                export_time.measure(context, self._plan(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Export at once; behind the file browser start anew, for this one cannot go on between events."""
        if getattr(self, "_browsing", False):
            settings = {name: getattr(self, name) for name in _ASKED}
            bpy.ops.dimple.export_animation("INVOKE_DEFAULT", directory=self.directory, **settings)
            return {"CANCELLED"}
        return Working.execute(self, context)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the settings, and how large the files will be and how long they will take."""
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        column.use_property_split = False  # beside a label their names would be cut off
        column.label(text="Formats")
        column.prop(self, "formats")
        for name in _ASKED[1:]:
            row = layout.row()
            row.active = name != "step" or not self.key_error  # with few shape keys every frame counts
            row.prop(self, name)
        sentence, icon = self._estimate(context)
        column = layout.box().column(align=True)
        for line in wrapped(
            translated(sentence), int(context.region.width / context.preferences.system.ui_scale / CHARACTER)
        ):
            column.label(text=line, translate=False, icon=icon)
            icon = "BLANK1"

    def _estimate(self, context: bpy.types.Context) -> tuple[str, str]:
        """Return a sentence on frames, size and time, and its icon."""
        from ..core.base import DimpleError
        from . import export_plan, export_time

        try:
            plan = self._plan(context)
            export_plan.check_choice(plan)
            size, took = export_plan.estimate(context, plan), export_time.seconds(plan)
        except DimpleError as error:
            return str(error), "ERROR"
        said = Message("{frames} frames, about {size} MB", frames=plan.last - plan.first + 1, size=megabytes(size))
        if took is not None:
            said = Message("{files}, {time} on this computer", files=said, time=duration(took))
        return said, "TIME"

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "export", "Exporting: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps; live sessions end first, for what is exported starts at rest."""
        from ..core.base import DimpleError
        from . import exporting

        if not self.directory:
            raise DimpleError("No folder is chosen. Choose where the files go.")
        if self.directory.startswith("//") and not bpy.data.filepath:
            raise DimpleError("The folder is relative to the .blend file, which is not saved yet. Save the file first.")
        sessions.stop_all()
        self._messages: list[str] = []
        self._written: list[Path] = []
        return exporting.export(context, self._plan(context), self._messages, self._written)

    def _plan(self, context: bpy.types.Context):
        from . import exporting, live

        given, scene = self.properties.is_property_set, context.scene
        return exporting.ExportPlan(
            objects=[obj for obj in live.candidates(context) if obj.type == "MESH"] or live.candidates(context),
            formats=[key for key, *_ in EXPORTS if key in self.formats],
            folder=Path(bpy.path.abspath(self.directory)),
            first=self.frame_start if given("frame_start") else scene.frame_start,
            last=self.frame_end if given("frame_end") else scene.frame_end,
            step=self.step,
            key_error=self.key_error / 100,
            simulate=self.source == "SIMULATE",
            overwrite=self.overwrite,
            normals=self.normals,
        )

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        count, folder = len(self._written), self._written[0].parent
        conclude(self, Message("Exported {count} files to {folder}", count=count, folder=folder), self._messages)
        return {"FINISHED"}


def _draw_in_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(Op.EXPORT, text="Dimple Animation...")


_register_class, _unregister_class = bpy.utils.register_classes_factory([DIMPLE_OT_export_animation])


def register() -> None:
    """Register the operator and its place in File > Export."""
    _register_class()
    bpy.types.TOPBAR_MT_file_export.append(_draw_in_menu)


def unregister() -> None:
    """Take both away."""
    bpy.types.TOPBAR_MT_file_export.remove(_draw_in_menu)
    _unregister_class()

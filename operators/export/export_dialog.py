"""File > Export > Dimple Animation: one dialog for every format."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from ...core.errors import DimpleError
from ...core.message import Message
from ..names import Op
from ..press import polls, sessions
from ..press.progress import READY, FrameRange, Working
from ..reporting import megabytes, wrapped
from ..translation import translated

CHARACTER = 8.5  # [px] width of a character in the dialog, with a share of icon and borders
_MODIFIERS = (
    ("VIEWPORT", "Viewport", "As in the viewport"),
    ("RENDER", "Render", "As in a render, often with more subdivision"),
)
# the formats; `formats` writes them, and is not imported with the dialog
EXPORTS = (
    ("ALEMBIC", "Alembic (.abc)", "For other 3D programs and renderers", 1),
    ("USD", "USD (.usdc)", "File and textures in a folder, for other 3D programs, renderers and pipelines", 2),
    ("GLB", "glTF Binary (.glb)", "For game engines and the web, with morph targets", 4),
    ("FBX", "FBX (.fbx)", "For game engines, with shape keys", 8),
    ("PC2", "PC2 Point Cache (.pc2)", "For 3ds Max, and Blender's Mesh Cache modifier", 16),
    ("VAT", "Vertex Animation Texture", "Two EXR images for shaders, with positions and normals, and the mesh", 256),
)


class DIMPLE_OT_export_animation(FrameRange, Working, bpy.types.Operator):
    """Export the animation of the selected bodies, with a table of forces. Bodies without a bake are simulated first"""

    bl_idname = Op.EXPORT
    bl_label = "Export Animation"
    verb, stopped = "Exporting", "The export was cancelled; the files that were finished are kept"
    ready = READY
    asked = "directory", "formats", "frame_start", "frame_end", "modifiers", "key_error", "overwrite"

    directory: StringProperty(
        name="Folder", description="Folder for the files, which are named after the objects", subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip
    formats: EnumProperty(
        name="Formats", description="File formats to write", items=EXPORTS, options={"ENUM_FLAG"}, default={"ALEMBIC"},
    )  # fmt: skip
    modifiers: EnumProperty(
        name="Modifiers", description="Export the mesh with its modifiers as in the viewport, or as in a render",
        items=_MODIFIERS,
    )  # fmt: skip
    key_error: FloatProperty(
        name="Key Error (%)",
        description="For glTF and FBX: write fewer shape keys, such that no vertex is off by more than this share of "
        "the object's size, and no normal by more than a degree. 0 writes one for each frame that differs",
        default=0.0, min=0.0, soft_max=1.0, max=100.0, precision=3,
    )  # fmt: skip
    overwrite: BoolProperty(name="Overwrite", description="Replace existing files", default=False)

    needs = polls.in_object_mode, polls.is_free

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder, then export between Blender's events."""
        if self.properties.is_property_set("directory"):
            return Working.invoke(self, context, event)
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self.browsing = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        column.use_property_split = False  # next to a label their names would be cut off
        column.label(text="Formats")
        column.prop(self, "formats")
        for name in self.asked[2:]:
            layout.prop(self, name)
        sentence, icon = self._estimate(context)
        column = layout.box().column(align=True)
        for line in wrapped(
            translated(sentence), int(context.region.width / context.preferences.system.ui_scale / CHARACTER)
        ):
            column.label(text=line, translate=False, icon=icon)
            icon = "BLANK1"

    def _estimate(self, context: bpy.types.Context) -> tuple[str, str]:
        from . import export_plan

        known = self._sizes = getattr(self, "_sizes", {})
        try:
            plan = self._plan(context)
            export_plan.check_choice(plan)
            for obj in plan.objects:  # counted once, not at every redraw
                if (obj.session_uid, plan.rendered) not in known:
                    known[obj.session_uid, plan.rendered] = export_plan.size_of(context, obj, plan)
            sizes = [known[obj.session_uid, plan.rendered] for obj in plan.objects]
            size, vertices = megabytes(export_plan.estimate(plan, sizes)), sum(each.vertices for each in sizes)
        except DimpleError as error:
            return str(error), "ERROR"
        frames = plan.last - plan.first + 1
        said = "{frames} frames of {vertices:,} vertices, at most {size} MB"
        return Message(said, frames=frames, vertices=vertices, size=size), "INFO"

    def _begin(self, context: bpy.types.Context):
        """Return the steps of the export; live sessions end first, because an export starts at rest."""
        from . import export_plan

        if not self.directory:
            raise DimpleError("No folder is chosen. Choose a folder for the files.")
        if self.directory.startswith("//") and not bpy.data.filepath:
            raise DimpleError("The folder is relative to the .blend file, which is not saved yet. Save the file first.")
        sessions.stop_all()
        self._messages: list[str] = []
        self._written: list[Path] = []
        return export_plan.export(context, self._plan(context), self._messages, self._written)

    def _plan(self, context: bpy.types.Context):
        from ..press import live_step
        from . import export_plan

        first, last = self._frames(context.scene)
        chosen = live_step.candidates(context)
        return export_plan.ExportPlan(
            objects=[obj for obj in chosen if obj.type == "MESH"] or chosen,
            formats=[key for key, *_ in EXPORTS if key in self.formats],
            folder=Path(bpy.path.abspath(self.directory)),
            first=first,
            last=last,
            key_error=self.key_error / 100,
            overwrite=self.overwrite,
            rendered=self.modifiers == "RENDER",
        )

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        return self._done(
            Message("Exported {count} files to {folder}", count=len(self._written), folder=self._written[0].parent),
            self._messages,
        )


def _draw_in_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(Op.EXPORT, text="Dimple Animation...")


_register_class, _unregister_class = bpy.utils.register_classes_factory([DIMPLE_OT_export_animation])


def register() -> None:
    _register_class()
    bpy.types.TOPBAR_MT_file_export.append(_draw_in_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(_draw_in_menu)
    _unregister_class()

"""The experiment under way, and the object that its trials present: blind, and put back when it ends."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ...core.errors import DimpleError
from ..press import sessions

if TYPE_CHECKING:
    from ...core.experiment.plan import Trial
    from ...core.experiment.run import Experiment
    from ...core.poke import PokeState

MATERIAL = "Dimple Trial"  # shown in place of the object's own, so that its name tells nothing
SEEN_N = 5.0  # [N] of the press that is replayed for those who only see: by force, a softer body sinks in deeper
PRESS_S, HOLD_S, RELEASE_S = 0.6, 0.6, 0.4  # [s] of that press: as quick as a person who tests a fruit
FELT_S = 3.0  # [s] that a script lets a device press


@dataclass(slots=True, kw_only=True)
class UnderWay:
    """An experiment under way."""

    experiment: Experiment  # plan, participant and answers
    agreed: bool = False  # the participant has read the consent
    obj: tuple[str, bpy.types.Material | None] = ("", None)  # uid of the object, and the material it had
    shown: int = 0  # intervals of the trial that were shown
    # time [s], depth [m] and force [N] of what was touched in this trial
    samples: list[tuple[float, float, float]] = field(default_factory=list)
    began: float = 0.0  # when the trial did [s]


experiments: list[UnderWay] = []  # the experiment, where one is under way


def get() -> UnderWay | None:
    """Return the experiment under way, None where there is none."""
    return experiments[0] if experiments else None


def is_blind() -> bool:
    """Tell whether a participant judges: no number and no chart may show how stiff the object is."""
    return bool(experiments) and experiments[0].agreed


def trial() -> Trial | None:
    """Return the trial that is next."""
    return experiments[0].experiment.next() if experiments else None


def log_path(plan: Path, participant: str) -> Path:
    """Return where the answers of a participant are kept: beside the plan."""
    return plan.with_name(f"{plan.stem}_{bpy.path.clean_name(participant)}_answers.csv")


def close() -> None:
    """End the experiment under way; its answers are kept."""
    while experiments:
        sessions.stop_all()
        name, material = experiments.pop().obj
        obj = bpy.data.objects.get(name)
        if obj and obj.active_material and obj.active_material.name.startswith(MATERIAL):
            trial_material = obj.active_material
            obj.active_material = material
            if not trial_material.users:
                bpy.data.materials.remove(trial_material)


def source_of(name: str) -> object:
    """Return the preset or the material that a task names.

    Raises:
        DimpleError: there is none.
    """
    from ...core.everyday_presets import OBJECTS

    preset = next((each for each in OBJECTS if name in (each.name, each.label)), None)
    if preset is None and (bpy.data.materials.get(name) is None or name.startswith(MATERIAL)):
        raise DimpleError('There is no material or preset "{name}", which the experiment names.', name=name)
    return preset or bpy.data.materials[name]


def dress(obj: bpy.types.Object, name: str, level: float) -> None:
    """Give an object the material of a task, with its stiffness scaled."""
    from ..calibrate.apply_preset import apply

    source = source_of(name)
    material = bpy.data.materials.get(MATERIAL) or bpy.data.materials.new(MATERIAL)
    if isinstance(source, bpy.types.Material):
        old, material = material, source.copy()
        obj.active_material = material
        bpy.data.materials.remove(old)
        material.name = MATERIAL
    else:
        obj.active_material = material
        apply(material.dimple, source)
        obj.dimple.enabled, obj.dimple.size_mode, obj.dimple.size_mm = True, "CUSTOM", source.size * 1e3
    material.dimple.K1, material.dimple.K2 = level * material.dimple.K1, level * material.dimple.K2


def seen_press(context: bpy.types.Context) -> PokeState:
    """Return the press that is replayed: by force, straight into the surface."""
    from ...core.poke import PokeState

    radius = context.scene.dimple.finger_radius_mm / 1e3
    state = PokeState(radius=radius, depth=radius, force=SEEN_N, by_force=True)
    return replace(state, press_s=PRESS_S, release_s=RELEASE_S)

"""A large body is simulated where it is pressed: what of it does not move rests, in poke, play and bake alike."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.point_cache import read_point_cache

LAST, RADIUS = 8, 10.0  # frames, [mm]


@pytest.fixture
def mattress(bpy: ModuleType, scene: Any) -> Any:
    """A foam of 0.9 m with edges of 7.5 mm, held along its border, which a fingertip presses."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=120, size=0.9)
    obj = bpy.context.object
    material = bpy.data.materials.new("Foam")
    obj.data.materials.append(material)
    law = material.dimple
    law.fill, law.K1, law.K2, law.x0, law.k, law.spread_mm = "NONE", 0.4, 1.2, 10.0, 0.5, 10.0
    scene.dimple.finger_radius_mm = RADIUS
    tip = bpy.data.objects.new("Tip", None)
    scene.collection.objects.link(tip)
    scene.dimple.finger_1 = tip
    for frame, height in ((1, 1.0), (6, 0.3)):
        tip.location = 0.055, 0.035, height * RADIUS / 1e3
        tip.keyframe_insert("location", frame=frame)
    return obj


@pytest.fixture
def far_from_live(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is above 1,000 vertices does not run live; more than 500 no proxy has."""
    from bl_ext.user_default.dimple.core.reduction import decision, processor_time, proxy

    for module in (decision, proxy):
        monkeypatch.setattr(module, "LARGEST", 500)
    monkeypatch.setattr(processor_time, "cost_of", lambda model: 0.6 * len(model.mass) / 1000)


def test_what_a_poke_does_not_move_rests(bpy: ModuleType, mattress: Any, far_from_live: None, sessions: Any) -> None:
    bpy.ops.dimple.poke(depth_mm=1.0, press_s=0.02, hold_s=0.02, release_s=0.0)
    assert mattress.dimple.plan_slack == pytest.approx(1e-4) and mattress.dimple.plan_vertices == 0
    assert "What moves by less than 0.1 mm rests; a fingertip moves about" in mattress.dimple.plan_reason
    bpy.ops.dimple.play(frames=2)
    session = sessions.get(mattress).session
    assert session.slack == mattress.dimple.plan_slack and session.proxy is None
    assert 0 < session._last.stepped < len(session.model.mass) / 4
    sessions.stop_all()


def test_a_bake_is_the_play_bit_for_bit_and_the_force_of_the_full_mesh(
    bpy: ModuleType, scene: Any, mattress: Any, far_from_live: None, simulated: Callable[[Any], np.ndarray]
) -> None:
    scene.frame_set(1)
    bpy.ops.dimple.play(frames=LAST - 1)
    shown = simulated(mattress)

    def baked() -> tuple[np.ndarray, float]:
        bpy.ops.dimple.bake(frame_start=1, frame_end=LAST)
        path = Path(mattress.modifiers["Dimple"].filepath)
        points, table = read_point_cache(path)[2][-1], path.with_suffix(".csv").read_text().splitlines()
        bpy.ops.dimple.unbake()
        names, last = table[0].split(","), table[-1].split(",")
        return points, max(float(last[k]) for k, name in enumerate(names) if name.startswith("force"))

    points, force = baked()
    assert mattress.dimple.plan_slack > 0 and np.array_equal(np.asarray(shown, "<f4"), points)
    assert np.array_equal(baked()[0], points), "the same bits again"
    mattress.dimple.simulated = "MESH"
    full, whole = baked()
    assert mattress.dimple.plan_slack == 0, "as chosen: every vertex"
    assert whole > 0.05 and force == pytest.approx(whole, rel=0.01) and np.abs(points - full).max() < 2e-4


def test_what_meets_others_is_stepped_whole(bpy: ModuleType, mattress: Any, far_from_live: None, sessions: Any) -> None:
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(0.3, 0.3, 0.3))
    bpy.context.object.dimple.collider = True
    bpy.context.object.select_set(False)
    bpy.context.view_layer.objects.active = mattress
    mattress.select_set(True)
    bpy.ops.dimple.play(frames=1)
    assert mattress.dimple.plan_slack == 0 and sessions.get(mattress).session.slack == 0
    sessions.stop_all()


def test_a_large_body_answers_the_law(bpy: ModuleType, scene: Any, mattress: Any) -> None:
    mattress.data.materials[0].dimple.x0 = 20.0
    bpy.ops.dimple.bake(frame_start=1, frame_end=LAST + 12)
    names, *_, last = Path(mattress.modifiers["Dimple"].filepath).with_suffix(".csv").read_text().splitlines()
    row = dict(zip(names.split(","), map(float, last.split(",")), strict=True))
    assert row["law_force_1_n"] > 2.0
    assert row["force_1_n"] == pytest.approx(row["law_force_1_n"], rel=0.1)

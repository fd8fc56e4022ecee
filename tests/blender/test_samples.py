"""What ships in blend_samples/ still holds for the meshes as they are cut and pressed now."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

SAMPLES = Path(__file__).parents[2] / "blend_samples"
SINKING, LISTENING = 0.02, 0.01  # [s] between two depths, and of taking the mean of the force


def test_suzanne_answers_the_law_she_was_identified_for_where_her_fingertip_presses(
    bpy: ModuleType, empty_file: ModuleType
) -> None:
    """Where this fails for a change that is wanted, `python3 dev.py samples` identifies her anew."""
    from bl_ext.user_default.dimple.core.session import Finger, Session
    from bl_ext.user_default.dimple.operators import bridge, calibration, indentation

    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / "suzanne.blend"))
    scene, head = bpy.context.scene, bpy.data.objects["Suzanne"]
    settings, way = head.active_material.dimple, []
    for frame in (scene.frame_start, scene.frame_start + 10):
        scene.frame_set(frame)
        way.append(scene.dimple.finger_1.matrix_world.translation.copy())
    scene.cursor.location = way[0] + (way[1] - way[0]).normalized() * settings.tip_radius_mm / 1e3
    bench = indentation.set_up(bpy.context, head, "CURSOR", 0.0, identify="NO")
    _, model = bridge.read_body(bpy.context, head, identify="NO")
    assert calibration.changed(settings, model.mesh) == [], "another mesh is pressed than was identified"

    session, radius, law, forces = Session(model), bench.indenter.radius, model.materials[0].law, []
    depths = bench.deepest * np.arange(13) / 12
    for depth in depths:
        session.set_fingers([Finger(tuple(bench.site.point + (depth - radius) * bench.site.inward), radius)])
        session.step(SINKING)
        forces.append(-float(session.step(LISTENING).finger_forces[0] @ bench.site.inward))
    wanted = np.array([law(depth) for depth in depths.tolist()])
    assert bench.deepest == pytest.approx(1.5 * model.materials[0].x0)
    assert np.sum(forces) == pytest.approx(wanted.sum(), rel=0.025)
    assert np.sqrt(np.mean((forces - wanted) ** 2)) < 0.02 * wanted.max()

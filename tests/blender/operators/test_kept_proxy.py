"""What is dear to find of a proxy is kept with the file, and used for the very mesh that it was found on."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest


@pytest.fixture
def fine(ball: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> Any:
    """A ball that a proxy stands for, as if it were large."""
    from bl_ext.user_default.dimple.core.reduction import cell_record

    monkeypatch.setattr(cell_record, "SMALLEST", 100)
    obj = ball("Fine", 5)
    obj.dimple.simulated, obj.dimple.proxy_vertices = "PROXY", 300
    return obj


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many seeds were asked for in each search for cells."""
    from bl_ext.user_default.dimple.core.reduction import proxy

    found, spread = [], proxy.spread_seeds

    def counted(mesh: Any, place: Any, used: Any, count: int, *others: Any) -> Any:
        found.append(count)
        return spread(mesh, place, used, count, *others)

    monkeypatch.setattr(proxy, "spread_seeds", counted)
    return found


def proxy_of(bpy: ModuleType, obj: Any) -> Any:
    """Start an object as if nothing had run before, and return its proxy."""
    from bl_ext.user_default.dimple.operators import planning, sessions

    planning._choices.clear()
    planning._moving.clear()
    proxy = sessions.start(obj, bpy.context)[0].session.proxy
    sessions.stop_all()
    return proxy


def test_a_file_that_is_opened_again_has_its_proxy_without_a_search(
    bpy: ModuleType, fine: Any, searched: list[int], tmp_path: Path
) -> None:
    first = proxy_of(bpy, fine)
    assert searched and len(fine.dimple.plan_cells) < 2 * len(fine.data.vertices)
    searched.clear()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    opened = proxy_of(bpy, bpy.data.objects["Fine"])
    assert searched == []
    for name in ("followed", "weights", "places", "coarse_rest", "corners"):
        assert np.array_equal(getattr(opened.binding, name), getattr(first.binding, name)), name
    copy = bpy.data.objects["Fine"].copy()
    bpy.context.collection.objects.link(copy)
    assert np.array_equal(proxy_of(bpy, copy).seeds, first.seeds) and searched == []
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {copy})
    with bpy.data.libraries.load(str(tmp_path / "library.blend")) as (there, wanted):
        wanted.objects = there.objects
    bpy.context.collection.objects.link(wanted.objects[0])
    assert np.array_equal(proxy_of(bpy, wanted.objects[0]).seeds, first.seeds) and searched == []


def test_a_record_that_is_damaged_or_of_another_mesh_is_not_used(
    bpy: ModuleType, fine: Any, ball: Any, searched: list[int]
) -> None:
    first = proxy_of(bpy, fine)
    record = fine.dimple.plan_cells
    searched.clear()
    damaged = "", "no record", "é", record[:-40], record[:50] + "A" + record[51:], record[:8] + record[12:]
    for text in damaged:
        fine.dimple.plan_cells = text
        assert text != record and np.array_equal(proxy_of(bpy, fine).seeds, first.seeds)
        assert fine.dimple.plan_cells == record
    assert searched == [300] * len(damaged)
    fine.data.vertices[7].co *= 1.01
    proxy_of(bpy, fine)
    assert len(searched) > len(damaged) and fine.dimple.plan_cells != record
    fine.dimple.proxy_vertices = 280
    proxy_of(bpy, fine)
    assert searched[-1] == 280


def test_undo_before_the_first_press_takes_the_record_along_and_redo_brings_it_back(
    bpy: ModuleType, fine: Any, searched: list[int]
) -> None:
    bpy.ops.ed.undo_push(message="Before")
    first = proxy_of(bpy, fine)
    record = fine.dimple.plan_cells
    bpy.ops.ed.undo_push(message="Pressed")
    bpy.ops.ed.undo()
    assert bpy.data.objects["Fine"].dimple.plan_cells == "" != record
    bpy.ops.ed.redo()
    assert bpy.data.objects["Fine"].dimple.plan_cells == record
    searched.clear()
    assert np.array_equal(proxy_of(bpy, bpy.data.objects["Fine"]).seeds, first.seeds) and searched == []
    bpy.ops.ed.undo()
    again = proxy_of(bpy, bpy.data.objects["Fine"])
    assert searched and np.array_equal(again.seeds, first.seeds)
    assert bpy.data.objects["Fine"].dimple.plan_cells == record


def test_a_linked_body_keeps_the_record_of_its_library_and_an_override_of_it_is_pressed_by_it(
    bpy: ModuleType, fine: Any, searched: list[int], tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.core.errors import DimpleError

    first = proxy_of(bpy, fine)
    record, path = fine.dimple.plan_cells, str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {fine})
    with bpy.data.libraries.load(path, link=True) as (there, wanted):
        wanted.objects = there.objects
    linked = wanted.objects[0]
    bpy.context.collection.objects.link(linked)
    assert linked.library and linked.dimple.plan_cells == record
    with pytest.raises(DimpleError, match="linked"):
        proxy_of(bpy, linked)
    searched.clear()
    override = linked.override_create()
    bpy.context.collection.objects.link(override)
    try:
        pressed = proxy_of(bpy, override)
    except DimpleError as error:
        print("OVERRIDE", error)
        raise
    assert np.array_equal(pressed.seeds, first.seeds) and searched == []
    assert linked.dimple.plan_cells == override.dimple.plan_cells == record

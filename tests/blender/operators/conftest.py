"""What the operators' tests share: bodies to press, and their coordinates bit for bit."""

from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType, ModuleType, NoneType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.device_rig import port  # noqa: F401

CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FINE_ENOUGH = 3  # subdivisions of a ball of 165 mm that a fingertip of 10 mm presses as it is
SIDE = 5  # vertices along an edge of the cube: 98 in all


@pytest.fixture
def add(empty_file: ModuleType) -> Callable[..., Any]:
    """Return a function that adds a mesh object that stands for one of 165 mm, and selects it alone."""
    bpy = empty_file

    def add_mesh(points: Any = CUBE, faces: Any = FACES, name: str = "Body") -> Any:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(points, [], faces)
        obj = bpy.data.objects.new(name, mesh)
        bpy.context.collection.objects.link(obj)
        for other in bpy.context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        obj.dimple.size_mode, obj.dimple.simulated = "CUSTOM", "MESH"  # so few vertices would be cut finer
        return obj

    return add_mesh


def icosphere(mesh: Any, subdivisions: int) -> None:
    import bmesh

    made = bmesh.new()
    bmesh.ops.create_icosphere(made, subdivisions=subdivisions, radius=1.0)
    made.to_mesh(mesh)
    made.free()


@pytest.fixture
def ball(add: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that adds a ball of radius 1 that stands for one of 165 mm; of 42 vertices by default."""

    def add_ball(name: str = "Ball", subdivisions: int = 2) -> Any:
        obj = add([], [], name)
        icosphere(obj.data, subdivisions)
        if subdivisions >= FINE_ENOUGH:
            obj.dimple.simulated = "AUTO"
        return obj

    return add_ball


@pytest.fixture
def rest(empty_file: ModuleType, coordinates: Callable[[Any], bytes]) -> bytes:
    """The coordinates of a ball as it is made, bit for bit; the ball itself is gone."""
    mesh = empty_file.data.meshes.new("Rest")
    icosphere(mesh, 2)
    bits = coordinates(SimpleNamespace(data=mesh))
    empty_file.data.meshes.remove(mesh)
    return bits


@pytest.fixture
def cube(add: Callable[..., Any]) -> Any:
    """A cube of 98 vertices that stands for the paper's second object, of 165 mm."""
    import bmesh

    obj = add([], [], "Cube")
    made = bmesh.new()
    bmesh.ops.create_cube(made, size=2.0)
    bmesh.ops.subdivide_edges(made, edges=made.edges[:], cuts=SIDE - 2, use_grid_fill=True)
    made.to_mesh(obj.data)
    made.free()
    return obj


@pytest.fixture
def vinyl(bpy: ModuleType, cube: Any) -> Any:
    """The settings of the cube's material."""
    bpy.context.object.dimple.material = "object_2_vinyl_air"
    return cube.active_material.dimple


@pytest.fixture
def coordinates() -> Callable[[Any], bytes]:
    """Return a function that reads the coordinates of a mesh bit for bit."""

    def read(obj: Any) -> bytes:
        numbers = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.vertices.foreach_get("co", numbers)
        return numbers.tobytes()

    return read


@pytest.fixture
def shown(bpy: ModuleType) -> Callable[[Any], np.ndarray]:
    """Return a function that reads the evaluated coordinates (n, 3) of an object: what one sees."""

    def read(obj: Any) -> np.ndarray:
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        numbers = np.empty(3 * len(evaluated.vertices), np.float32)
        evaluated.vertices.foreach_get("co", numbers)
        return numbers.reshape(-1, 3)

    return read


@pytest.fixture
def simulated(bpy: ModuleType) -> Callable[[Any], np.ndarray]:
    """Return a function that reads how far (n, 3) a session has come from its shape at rest, bit for bit."""

    def read(obj: Any) -> np.ndarray:
        from bl_ext.user_default.dimple.operators.press import sessions

        return sessions.get(obj).offsets()

    return read


@pytest.fixture
def sessions(bpy: ModuleType) -> Any:
    """The running sessions; after the test nothing may be left of them."""
    from bl_ext.user_default.dimple.operators.press import modal_runs, sessions

    yield sessions
    assert not sessions.sessions and not modal_runs.runs


@pytest.fixture
def playing(bpy: ModuleType, ball: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that adds a ball and lets it hang from its base in gravity until it is out of shape."""

    def play(keys: bool = False) -> Any:
        obj = ball()
        if keys:
            obj.shape_key_add(name="Basis")
            obj.shape_key_add(name="Other").value = 0.5
        bpy.context.scene.dimple.use_gravity = True
        bpy.ops.ed.undo_push(message="Before")
        bpy.ops.dimple.play(seconds=0.05)
        return obj

    return play


@pytest.fixture
def scene(bpy: ModuleType, empty_file: ModuleType, tmp_path: Path) -> Any:
    """A scene whose caches go to a folder of its own."""
    scene = bpy.context.scene
    scene.dimple.cache_dir = str(tmp_path / "caches")
    return scene


@pytest.fixture
def pressed(bpy: ModuleType, scene: Any, ball: Callable[..., Any]) -> Callable[[float], Any]:
    """Return a function that adds a ball and a fingertip keyframed to press it 20 mm within a quarter of a second."""

    def set_up(fps: int = 24) -> Any:
        scene.render.fps = fps
        obj = ball()
        bpy.ops.dimple.add_fingertip()
        tip = scene.dimple.finger_1
        top, deep = tip.location.z, tip.location.z - 20 / 165 * 2
        for time, height in ((0.0, top), (0.25, deep), (0.5, deep), (0.75, top)):
            tip.location.z = height
            tip.keyframe_insert("location", index=2, frame=1 + time * fps)
        for layer in tip.animation_data.action.layers:
            for curve in layer.strips[0].channelbag(tip.animation_data.action_slot).fcurves:
                for point in curve.keyframe_points:
                    point.interpolation = "LINEAR"
        return obj

    return set_up


RADIUS_PX = 200  # of the ball's outline, seen from above; the picture is 1000 px wide


class Context:
    """Blender's context, but for what needs a window."""

    def __init__(self, bpy: ModuleType) -> None:
        self.bpy, self.said = bpy, ""
        self.window_manager = SimpleNamespace(
            event_timer_add=lambda *_, **__: None, modal_handler_add=lambda _: None,
            progress_begin=lambda *_: None, progress_update=lambda *_: None, fileselect_add=lambda _: None,
            dimple=bpy.context.window_manager.dimple,
        )  # fmt: skip
        self.workspace = SimpleNamespace(status_text_set=self._say)

    def _say(self, text: str | None) -> None:
        self.said = text or ""

    def __getattr__(self, name: str) -> Any:
        return getattr(self.bpy.context, name)


def _plain(operator: type) -> dict[str, Any]:
    """Return the functions and words of an operator and of what it is made of, without Blender's part of it."""
    ours = [each for each in reversed(operator.__mro__) if each.__module__.startswith("bl_ext.")]
    named = [(name, value) for each in ours for name, value in vars(each).items() if not name.startswith("__")]
    return {name: value for name, value in named if isinstance(value, (FunctionType, str, float, NoneType))}


class Hand:
    """Start an operator and feed it events, as Blender's window would."""

    def __init__(self, name: str, operator: type, context: Context) -> None:
        self.context, self.reports, self.time = context, [], 0.0
        stub = type("Stub", (), _plain(operator))()
        stub.report = lambda level, text: self.reports.append((*level, text))
        properties = getattr(context.bpy.ops.dimple, name).get_rna_type().properties
        for name in (name for each in operator.__mro__ for name in getattr(each, "__annotations__", ())):
            if (prop := properties.get(name)) is None:
                continue
            setattr(stub, name, tuple(prop.default_array) if getattr(prop, "is_array", False) else prop.default)
        stub.properties = SimpleNamespace(is_property_set=lambda name: name in self.given)
        self.given: set[str] = set()
        self.operator = stub

    def invoke(self, kind: str = "LEFTMOUSE", value: str = "RELEASE", at: Any = None) -> set[str]:
        return self.operator.invoke(self.context, self.event(kind, value, at))

    def event(self, kind: str, value: str = "PRESS", at: Any = None, **more: Any) -> SimpleNamespace:
        plain = {"ctrl": False, "shift": False, "alt": False, "oskey": False, "is_tablet": False, "pressure": 1.0}
        return SimpleNamespace(type=kind, value=value, at=at, mouse_x=0, mouse_y=0, **{**plain, **more})

    def send(self, kind: str, value: str = "PRESS", at: Any = (500, 500), **more: Any) -> set[str]:
        return self.operator.modal(self.context, self.event(kind, value, at, **more))

    def ticks(self, count: int) -> set[str]:
        result: set[str] = set()
        for _ in range(count):
            self.time += 0.02
            result = self.send("TIMER", "NOTHING")
            if result & {"FINISHED", "CANCELLED"}:
                break
        return result


@pytest.fixture
def hand(bpy: ModuleType, empty_file: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Hand]]:
    """Return a function that takes an operator in hand: it looks from above, and time is its own."""
    from bl_ext.user_default.dimple.operators.animate import bake_operators
    from bl_ext.user_default.dimple.operators.calibrate import measure
    from bl_ext.user_default.dimple.operators.press import (
        live_step,
        modal_runs,
        play,
        poke,
        poke_input,
        progress,
        sessions,
    )

    hands: list[Hand] = []

    def view_under(_context: Any, event: Any) -> Any:
        return None if event.at is None else poke_input.View(None, None, event.at)  # type: ignore[arg-type]

    views = SimpleNamespace(
        region_2d_to_origin_3d=lambda _r, _v, at: ((at[0] - 500) / RADIUS_PX, (at[1] - 500) / RADIUS_PX, 10.0),
        region_2d_to_vector_3d=lambda _r, _v, _at: SimpleNamespace(normalized=lambda: (0.0, 0.0, -1.0)),
    )
    monkeypatch.setattr(poke_input, "view_under", view_under)
    monkeypatch.setattr(poke_input, "view3d_utils", views)
    clock = SimpleNamespace(perf_counter=lambda: max(each.time for each in hands))
    monkeypatch.setattr(play, "time", clock)
    # however slow this computer is, it keeps up
    monkeypatch.setattr(live_step, "ask", lambda _scene, _run, wall: (wall, None))

    def take(name: str) -> Hand:
        operators = {
            "poke": poke.DIMPLE_OT_poke, "play": play.DIMPLE_OT_play, "bake": bake_operators.DIMPLE_OT_bake,
            "measure": measure.DIMPLE_OT_measure,
            "start": progress.DIMPLE_OT_start,
        }  # fmt: skip
        hands.append(Hand(name, operators[name], Context(bpy)))
        return hands[-1]

    yield take
    left = (len(sessions.sessions), len(modal_runs.runs))
    sessions.stop_all()
    assert left == (0, 0)

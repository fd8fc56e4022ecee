"""What of a large body does not move is not stepped, and nobody can tell."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from core.base import TICK, Floats
from core.body.model import Model, build_model
from core.material import PRESETS, Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.reduction.active_regions import may_rest, share_awake
from core.session import Finger, Session
from tests.bodies import ball, sheet

RADIUS, SLACK = 0.01, 1e-4  # [m]
EVERY = ["native64", "native"]
FOAM = Material(K1=400, K2=1200, x0=0.01, k=500, mass=3.0, fill="none", spread=0.01)
AIR = replace(PRESETS[1].material, mass=3.0, spread=0.01)


def mattress(**options: object) -> Model:
    """Return a sheet of 0.8 m with edges of 10 mm, held at its rim."""
    mesh = mesh_from_triangles(*sheet(80, 0.8))
    x, y, _ = mesh.rest_positions.T
    return build_model(mesh, [FOAM], pinned=np.maximum(abs(x), abs(y)) > 0.395, **options)  # type: ignore[arg-type]


def balloon() -> Model:
    """Return a ball of 0.6 m full of air."""
    mesh = mesh_from_triangles(*ball(5, 0.3))
    return build_model(mesh, [AIR], pinned=base_vertices(mesh))


@dataclass
class Beside:
    """A body with regions that rest, and one that is stepped whole.

    Within two radii of the fingertip both tremble: their edges are as long as its radius.
    """

    model: Model
    slack: float = SLACK
    backend: str = "native"

    def __post_init__(self) -> None:
        self.pair = [Session(self.model, backend=self.backend, slack=slack) for slack in (self.slack, 0.0)]
        self.stepped: list[int] = []
        self.forces: list[list[float]] = []
        self.off = 0.0
        self._away = np.linalg.norm(self.model.mesh.rest_positions - top(self.model), axis=1) > 2 * RADIUS

    def step(self, finger: Finger | None = None, seconds: float = 1 / 120) -> None:
        for each in self.pair:
            each.set_fingers([finger])
            each.step(seconds)
        resting, whole = self.pair
        off = np.linalg.norm(resting.positions() - whole.positions(), axis=1)
        self.off = max(self.off, float(off[self._away].max()))
        self.stepped.append(resting._last.stepped)
        if finger:
            self.forces.append([float(each.frame.impulses[0][2] / each.frame.seconds) for each in self.pair])

    @property
    def share(self) -> float:
        return float(np.mean(self.stepped)) / len(self.model.mass)


def top(model: Model) -> Floats:
    rest = model.mesh.rest_positions
    flat = np.ptp(rest[:, 2]) == 0
    return rest[np.hypot(rest[:, 0] - 0.011, rest[:, 1] - 0.007).argmin() if flat else rest[:, 2].argmax()]


def tip(model: Model, depth: float, aside: float = 0.0) -> Finger:
    x, y, z = top(model)
    return Finger((x + aside, y, z + RADIUS - depth), RADIUS)


PRESSES: dict[str, Callable[[float], tuple[float, float]]] = {  # depth and way aside [m] by time [s]
    "at 40 mm/s": lambda t: (min(0.04 * t, 0.01), 0.0),
    "at 1 m/s": lambda t: (min(1.0 * t, 0.01), 0.0),
    "at 4 mm/s": lambda t: (0.004 * t, 0.0),
    "sliding": lambda t: (min(0.04 * t, 0.006), 0.1 * max(t - 0.2, 0.0)),
    "up and down": lambda t: (0.008 * np.sin(8 * t) ** 2, 0.0),
}


@pytest.mark.parametrize("make", [mattress, balloon])
@pytest.mark.parametrize("press", PRESSES)
def test_a_press_is_the_same_within_the_slack(press: str, make: Callable[[], Model]) -> None:
    both = Beside(make())
    for k in range(96):
        both.step(tip(both.model, *PRESSES[press](k / 120)))
    mine, whole = np.array(both.forces).T
    assert both.off < SLACK
    assert np.sqrt(((mine - whole) ** 2).mean()) < 0.01 * whole.max()
    assert both.share < 0.2


@pytest.mark.parametrize("make", [mattress, balloon])
def test_only_what_is_near_a_fingertip_is_stepped_and_at_rest_nothing(make: Callable[[], Model]) -> None:
    both = Beside(make())
    both.step()
    assert both.stepped == [0], "nothing touches it"
    both.step(tip(both.model, 0.0005))
    few = both.stepped[-1]
    assert 0 < few < 0.2 * len(both.model.mass)
    assert few < 4 * share_awake(both.model, RADIUS, SLACK) * len(both.model.mass)
    for _ in range(120):
        both.step(tip(both.model, 0.0005))
    assert both.stepped[-1] == 0 and not both.pair[0].moved, "the fingertip stands still"
    both.step()
    assert both.stepped[-1] > 0, "it is let go"


@pytest.mark.parametrize("backend", EVERY)
def test_what_falls_asleep_and_wakes_has_no_step(backend: str) -> None:
    """Tick by tick: what has no speed is where it was, and what is stopped was slow."""
    model = mattress()
    session = Session(model, backend=backend, slack=SLACK)
    x, v = session.body.positions(), session.body.velocities()
    roles = set()
    for k in range(500):
        session.set_fingers([tip(model, min(0.04 * k * TICK, 0.006))] if k < 350 else [])
        session.step(TICK)
        now, speed = session.body.positions(), session.body.velocities()
        still = (speed == 0).all(axis=0)
        assert np.abs(now - x)[:, still & (v == 0).all(axis=0)].max() < 1e-7
        stopped = still & (v != 0).any(axis=0)
        roles.add(bool(stopped.any()))
        assert np.linalg.norm(v[:, stopped], axis=0).max(initial=0) < 2 * SLACK / 0.1
        x, v = now, speed
    assert roles == {True, False}


CHANGES: dict[str, Callable[[Beside], None]] = {
    "a stiffer material": lambda both: changed(both, K1=3 * FOAM.K1, spread=0.03),
    "a softer one that glides": lambda both: changed(both, glide=True, K1=0.5 * FOAM.K1, spread=0.0),
    "gravity": lambda both: changed(both, gravity=(0.0, 0.0, -9.81)),
    "a state": lambda both: for_each(both, lambda body: body.body.set_state(1.01 * body.model.matching.rest)),
    "pins that are led": lambda both: for_each(both, lambda body: body.set_pins(moved(body))),
}


def for_each(both: Beside, act: Callable[[Session], None]) -> None:
    for each in both.pair:
        act(each)


def moved(session: Session) -> Floats:
    return session.model.mesh.rest_positions - [0.0, 0.0, 0.004]


def changed(both: Beside, *, glide: bool = False, gravity: tuple[float, ...] = (0.0, 0.0, 0.0), **law: float) -> None:
    for each in both.pair:
        model = each.model
        stiffer = [replace(material, **law) for material in model.materials]
        after = build_model(model.mesh, stiffer, pinned=model.pinned, gravity=gravity)
        each.change(after, glide=glide)


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_wakes_what_it_moves(change: str) -> None:
    both = Beside(mattress())
    for k in range(60):
        both.step(tip(both.model, min(0.04 * k / 120, 0.008)))
    CHANGES[change](both)
    before = both.pair[1].positions()
    for _ in range(120):
        both.step(tip(both.model, 0.008))
    assert np.abs(both.pair[1].positions() - before).max() > SLACK / 2, "the change moves it"
    assert both.off < SLACK


def test_regions_may_come_and_go_while_it_lives() -> None:
    both = Beside(mattress(), slack=0.0)
    for k in range(60):
        if k == 30:
            both.pair[0].set_slack(SLACK)
        if k == 50:
            both.pair[0].set_slack(0.0)
        both.step(tip(both.model, min(0.04 * k / 120, 0.008)))
    assert both.off < 2 * SLACK
    n = len(both.model.mass)
    assert both.stepped[29] >= n > both.stepped[45] and both.stepped[55] >= n


def test_what_moves_as_a_whole_has_nothing_that_rests() -> None:
    assert may_rest(mattress()) and may_rest(balloon())
    assert not may_rest(mattress(gravity=(0.0, 0.0, -9.81)))
    mesh = balloon().mesh
    liquid, swollen = replace(AIR, fill="liquid"), replace(AIR, pressure=1000.0)
    for material, pinned in ((AIR, None), (liquid, base_vertices(mesh)), (swollen, base_vertices(mesh))):
        assert not may_rest(build_model(mesh, [material], pinned=pinned))

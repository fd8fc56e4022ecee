"""The model itself in the loop of the servo, on an injected clock: what the hand gets, and what must end all force."""

import itertools
import math
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.haptics import touched_body
from core.haptics.body_host import BLEW_UP, TOO_FINE, BodyHost
from core.haptics.emulated_hand import EmulatedHand, Keyframe
from core.haptics.parcel import pack_changes, parcel_path, unpack_changes
from core.haptics.remote_body import Parcels, RemoteBody
from core.haptics.servo import Servo
from core.haptics.servo_messages import BodyState, Order, ServoReport
from core.haptics.spec import load_spec
from core.haptics.touched_body import TouchedBody
from core.haptics.wire import RAMP
from core.material import PRESETS, Material
from core.session import Finger, Session
from core.solver.motion import Frame, Motion
from studies.scripted_press import swing
from tests.haptics.model_rig import BEGIN, RADIUS, SIDES, WORKSPACE, ModelRig, holding, pressing, soft_cube

SLOW = pytest.mark.slow
POKES = (0.005, 0.010, -0.010, 0.012, -0.010)  # [m] below the top, one after the other


@pytest.fixture(autouse=True)
def the_clock_waits_for_the_body(monkeypatch: pytest.MonkeyPatch) -> None:
    """On an injected clock a busy computer makes no body too heavy."""
    monkeypatch.setattr(touched_body, "HEAVIEST", 100.0)


def material(k1: float, k2: float | None = None, x0: float = 0.01) -> Material:
    return replace(PRESETS[1].material, K1=k1, K2=k2 or k1, x0=x0)


def pressed(rig: ModelRig) -> ModelRig:
    """Return a rig whose fingertips press."""
    rig.run(2.0)
    assert rig.servo.report().arming.name == "ON" and max(map(np.linalg.norm, rig.emulator.forces)) > 0.5
    return rig


def strongest(rig: ModelRig) -> float:
    return float(max(map(np.linalg.norm, rig.emulator.forces)))


@pytest.mark.parametrize(("k1", "k2", "cells"), [(200.0, 200.0, 8), (610.0, 610.0, 8), (200.0, 900.0, 12)])
def test_a_hand_at_rest_gets_the_force_of_the_session(k1: float, k2: float, cells: int) -> None:
    """Within 2 % of a session whose fingertips are there, below a knee at 5 mm and beyond it; without friction, which
    depends on how they came."""
    bare = replace(material(k1, k2, 0.005), friction=0.0)
    rig = ModelRig(soft_cube(bare, cells), pressing(0.0035, 0.007, stiffness=None))
    rig.run(2.4)
    (time, _, forces, _), sensed = rig.trace(), rig.sensed()
    session = Session(rig.model)
    for number in range(2):
        during = holding(time, number)
        places = sensed[during].mean(axis=0)
        for share in np.linspace(0, 1, 30):
            above = places + [0, 0, (1 - share) * 0.005]
            session.set_fingers([Finger(WORKSPACE.to_session(tuple(place)), RADIUS) for place in above])
            session.step(0.01)
        wanted = session.step(0.3).finger_forces[:, 2]
        assert forces[during, :, 2].mean(axis=0) == pytest.approx(wanted, rel=0.02)


STIFF = [(1000, 1000, 0.01), pytest.param(4000, 4000, 0.01, marks=SLOW), (610, 9130, 0.003)]


@pytest.mark.parametrize(("k1", "k2", "x0"), STIFF)
def test_no_body_shakes_the_device_however_stiff(k1: float, k2: float, x0: float) -> None:
    """Beyond the cap, and beyond a knee of 9 N/mm."""
    rig = ModelRig(soft_cube(material(k1, k2, x0)), pressing(0.005, 0.010, 0.015))
    rig.run(3.0)
    time, tips, *_ = rig.trace()
    for number in range(3):
        assert np.ptp(tips[holding(time, number)], axis=0).max() < 2e-4
    assert rig.energy() > -2e-3


@pytest.mark.parametrize(("k", "cells", "hand"), [(1000, 20, (400.0, 4.0)), (1060, 8, (200.0, 2.0))])
def test_a_wall_up_to_the_cap_has_no_limit_cycle(k: float, cells: int, hand: tuple[float, float]) -> None:
    """A fingertip may creep sideways, freed from dry friction by the noise of its converters; it never swings."""
    stiffness, damping = hand
    rig = ModelRig(soft_cube(material(k), cells), pressing(0.005, 0.012, stiffness=stiffness, damping=damping))
    rig.run(2.5)
    time, tips, forces, _ = rig.trace()
    assert rig.servo.cap == pytest.approx(1067, rel=1e-3) and strongest(rig) > 1.0
    for number in range(2):
        assert swing(tips[holding(time, number)]) < 1e-4
    assert rig.energy() > -1e-3


@pytest.mark.parametrize("k", [610, 4000])
def test_a_device_that_let_go_of_a_pressed_fingertip_gets_no_energy_when_its_force_comes_back(k: float) -> None:
    """The servo does not run for 27 ms: the force is gone, the fingertips fall, the ramp begins anew."""
    rig = ModelRig(soft_cube(material(k)), pressing(0.005, 0.010, 0.015))
    rig.run(3.0)
    assert strongest(rig) > 2.0
    rig._sleeps = rig.now + 0.027
    rig.run(0.03)
    assert strongest(rig) < 1.0 and rig.servo.report().arming.name == "RAMP"
    rig.run(0.6)
    assert rig.servo.report().arming.name == "ON"
    assert rig.energy() > -1e-3 and rig.observed() < rig.energy() + 1e-4


@pytest.mark.parametrize("k", [610, 4000])
def test_a_line_that_was_silent_under_a_pressed_fingertip_gives_no_energy_when_the_force_comes_back(k: float) -> None:
    """After 5 ms without a STATE the servo takes the force away, and the device's ramp begins anew, the servo's not."""
    rig = ModelRig(soft_cube(material(k)), pressing(0.005, 0.015, -0.010), baud=0)
    rig.run(1.95)
    assert strongest(rig) > 2.0
    rig.deaf_until = rig.now + 0.006
    rig.run(0.02)
    assert rig.emulator.mode == RAMP and rig.servo.report().arming.name == "ON"
    rig.run(1.0)
    assert rig.energy() > -1e-3 and rig.observed() < rig.energy() + 1e-4


def test_a_busy_computer_gives_no_energy_and_the_observer_sees_what_there_is() -> None:
    """One tick in ten comes 2.5 ms late: the force that acted is the one the device acknowledged."""
    rig = ModelRig(soft_cube(material(610)), pressing(*POKES), stuck=0.1)
    rig.run(4.5)
    assert rig.servo.report().arming.name == "ON"
    assert rig.energy() > -1e-3
    assert rig.observed() < 0.4 * rig.energy() + 1e-4


def test_a_blender_that_stands_still_takes_nothing_away_until_the_key_lapses() -> None:
    """The contacts are those of a body that runs: none fades after 100 ms."""
    rig = pressed(ModelRig(soft_cube(material(400)), pressing(0.010, hold=3.0)))
    before = strongest(rig)
    rig.pinned = False
    rig.run(0.25)
    assert strongest(rig) == pytest.approx(before, rel=0.05)
    rig.run(0.2)
    assert strongest(rig) == 0.0


def test_a_body_that_blows_up_has_no_force_within_three_ticks() -> None:
    rig = pressed(ModelRig(soft_cube(material(400)), pressing(0.010, hold=3.0)))
    assert rig.host.touched
    x = rig.host.touched.body.positions()
    x[2, :40] += 1e9
    rig.host.touched.body.set_state(x)
    rig.run(0.003)
    assert strongest(rig) == 0.0
    assert rig.servo.report().arming.name == "OFF" and rig.servo.report().note == BLEW_UP
    rig.run(0.3)
    assert strongest(rig) == 0.0, "only a new request arms"


def test_forces_of_a_body_that_are_not_numbers_are_never_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = pressed(ModelRig(soft_cube(material(400)), pressing(0.010, hold=3.0)))
    assert rig.host.touched
    step = rig.host.touched.body.step

    def spoiled(motion: Motion) -> Frame:
        frame = step(motion)
        touches = tuple(touch._replace(impulse=(math.nan, 0.0, math.inf)) if touch else None for touch in frame.touches)
        return frame._replace(touches=touches)

    monkeypatch.setattr(rig.host.touched.body, "step", spoiled)
    rig.run(0.006)
    assert strongest(rig) == 0.0 and rig.servo.report().arming.name == "OFF"


def test_a_body_that_is_too_heavy_leaves_the_device_to_the_wall() -> None:
    rig = pressed(ModelRig(soft_cube(material(400)), pressing(0.010, hold=3.0)))
    assert rig.host.touched
    rig.host.touched._borrowed = 1e6
    rig.run(0.003)
    assert strongest(rig) == 0.0 and rig.host.state is BodyState.REFUSED
    assert rig.host.joined(rig.servo.report()).note == TOO_FINE
    assert rig.host.order(replace(rig.order, contacts=(None,)), rig.servo, rig.now).contacts == (None,)


def test_a_busy_second_of_others_makes_no_body_too_heavy_and_one_that_is_is_known_soon(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(touched_body, "HEAVIEST", 0.8)
    took, model = 0.0, soft_cube(cells=2)
    begun = itertools.count()
    monkeypatch.setattr(touched_body.time, "thread_time", lambda: (next(begun) % 2) * took * 1e-3)
    body = TouchedBody(model, model, 1e-3)

    def ticks(share: float, most: int) -> int:
        """Run ticks that take a share of one each; return how many until the body is too heavy."""
        nonlocal took
        took = share
        for i in range(most):
            body.advance([None] * 3, 1e3, 0.0)
            if body.is_too_heavy:
                return i + 1
        return most

    for _ in range(5):
        assert ticks(0.7, 4000) == 4000 and ticks(50.0, 5) == 5, "pauses of the machine"
        assert ticks(1.2, 1000) == 1000, "a busy second"
    assert ticks(0.7, 4000) == 4000 and ticks(3.0, 1000) < 420


def test_what_is_under_a_fingertip_never_changes_while_there_is_force() -> None:
    rig = pressed(ModelRig(soft_cube(material(400)), pressing(0.010, hold=3.0)))
    rig.send(("state", rig.model.matching.rest, None))
    rig.run(0.003)
    assert strongest(rig) == 0.0 and rig.servo.report().arming.name == "OFF"


def test_friction_and_stiffness_that_are_changed_are_rendered_at_once() -> None:
    """The fingertips go sideways all the while: friction resists that, and none is left where it is taken away."""
    rough = soft_cube(replace(material(400), friction=0.5))
    rig = ModelRig(rough, EmulatedHand(tips=tuple(map(sliding, SIDES)), stiffness=None))

    def forces() -> tuple[float, float]:
        """Return how strongly the motors resist the way, and push up, all together [N]."""
        along, _, up = rig.trace()[2][-50:].mean(axis=0).sum(axis=0)
        return -along, up

    pressed(rig)
    resists, pushes = forces()
    assert 0.5 * pushes < resists < 0.75 * pushes, "Coulomb's half, and the dent's slope"
    for model in (soft_cube(replace(material(400), friction=0.0)), soft_cube(replace(material(200), friction=0.0))):
        rig.send(("constants", model, model))
        rig.run(0.2)
        assert rig.servo.report().arming.name == "ON"
        assert abs(forces()[0]) < 0.1 * forces()[1]
    assert forces()[1] == pytest.approx(pushes / 2, rel=0.1)


def sliding(side: tuple[float, float]) -> tuple[Keyframe, ...]:
    """Return the way of a fingertip that goes 6 mm in at a side of the top and then along it, at 20 mm/s."""
    x, y = side
    ends = (BEGIN, x, y, 0.01), (BEGIN + 0.15, x, y, -0.006), (BEGIN + 0.3, x, y, -0.006)
    return (*ends, (BEGIN + 1.3, x + 0.02, y, -0.006))


def test_a_body_is_read_after_one_answer_built_after_the_next_and_runs_once_it_has_a_state(tmp_path: Path) -> None:
    """Each takes some milliseconds, for which a device keeps its force; notes of the model stay with Blender."""

    class Note(str):
        __slots__ = ()

    model, parcels = soft_cube(material(400), cells=20), Parcels()
    session = Session(replace(model, notes=(Note("of Blender's side"),)))
    remote = RemoteBody(session.body, session.model, parcels)
    servo, order = Servo(load_spec()), Order(parcel=1)
    host = BodyHost(tmp_path / "box")
    parcel_path(tmp_path / "box", 1).write_bytes(parcels.take(ServoReport()) or b"")
    host.order(order, servo, 0.0)
    assert host.state is BodyState.NONE and host.taken == 0, "it is not built yet"
    host.advance(servo, 0.0)
    assert host.state is BodyState.BUILT and host.touched and host.touched.frame is None, host.note
    remote.begin(session.model)
    parcel_path(tmp_path / "box", 2).write_bytes(parcels.take(ServoReport(parcel=1)) or b"")
    host.order(replace(order, parcel=2), servo, 0.0)
    host.advance(servo, 0.0)
    assert host.state is BodyState.RUNS and host.taken == 2
    host.close()
    remote.end()


def test_what_runs_a_body_is_loaded_without_what_makes_one() -> None:
    """trimesh and what it brings along take seconds, longer than a device waits."""
    words = "from core.haptics import body_host, servo_process; body_host.load(); import sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert {"numpy", "core.haptics.touched_body", "core.native", "core.solver.backend"} <= loaded
    assert not {"trimesh", "scipy", "networkx"} & loaded


def test_a_parcel_has_arrays_and_bodies_alone() -> None:
    """Nothing else can be made of one, and nothing run."""
    assert unpack_changes(pack_changes([("place", (0.0, 0.0, 0.0), 1.0)])) == [("place", (0.0, 0.0, 0.0), 1.0)]
    for parcel in (pack_changes([("state", Path("x"))]), pickle.dumps([print]), b"", b"\x80\x05no parcel"):
        with pytest.raises(DimpleError):
            unpack_changes(parcel)

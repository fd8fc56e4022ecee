"""The poke as data: events of mouse, tablet or script become the fingertips of a session.

The functions are pure: `on_event(state, event)` returns a new state. Nothing here needs Blender. Points are in the
session's space [m]:

    Hit (intersection of a ray) -> Aim (place and direction of a press) -> PokeTip (its progress) -> session.Finger
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, auto

from ..constants import MAX_FINGERTIPS
from ..session import Finger
from ..vectors import Vector, along, dot, length, scaled
from .fingertip_motion import Aim, PokeTip, leaving, led, stepped, unit


class Kind(Enum):
    """The kind of an event; the meaning of its `amount`, if it has one, is in brackets."""

    MOVE = auto()
    PRESS = auto()
    RELEASE = auto()
    FINGER = auto()  # [1, 2 or 3]
    TICK = auto()  # [s]
    # events that do not change the state
    PAUSE = auto()
    KEEP = auto()
    LEAVE = auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class Hit:
    """The intersection of a ray with a body: point [m], outward unit normal, and index of the body."""

    point: Vector
    normal: Vector
    body: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeEvent:
    """One event of a poke.

    kind: what happened.
    hit: where the pointer's ray meets a body, None if it meets none.
    view: unit direction of that ray.
    pressure: pressure of the pen, 0 to 1.
    amount: a number whose meaning depends on the kind.
    """

    kind: Kind
    hit: Hit | None = None
    view: Vector = (0.0, 0.0, -1.0)
    pressure: float = 1.0
    amount: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeState:
    """Settings and fingertips of a poke.

    radius, depth: radius and depth of the next press [m].
    force: force of the next press [N].
    by_force: press with the given force, from which the depth results.
    press_s, release_s: duration of going in and of coming out [s].
    along_normal: press along the normal of the surface, as a force always does, not along the view.
    active: index of the finger that the pointer moves.
    tips: fingertip of each finger, None if it is lifted.
    pressing: whether the active finger follows the pointer.
    """

    radius: float
    depth: float
    force: float = 5.0
    by_force: bool = False
    press_s: float = 0.25
    release_s: float = 0.25
    along_normal: bool = True
    active: int = 0
    tips: tuple[PokeTip | None, ...] = (None,) * MAX_FINGERTIPS
    pressing: bool = False


def on_event(state: PokeState, event: PokeEvent) -> PokeState:
    """Return the state after an event."""
    match event.kind:
        case Kind.MOVE:
            return _move(state, event)
        case Kind.PRESS:
            return _press(state, event)
        case Kind.RELEASE:
            return _release(state)
        case Kind.FINGER:
            return _choose(state, int(event.amount) - 1)
        case Kind.TICK:
            return _tick(state, event.amount)
    return state


def _tick(state: PokeState, dt: float) -> PokeState:
    times = {"press_s": state.press_s, "release_s": state.release_s}
    tips = tuple(tip and stepped(tip, dt, amount=_amount(state, tip.by_force), **times) for tip in state.tips)
    return replace(state, tips=tips)


def fingers(state: PokeState, body: int) -> tuple[Finger | None, ...]:
    """Return the fingertips for a session, None for each that does not press this body."""
    return tuple(tip.finger if tip and tip.body == body else None for tip in state.tips)


def with_settings(state: PokeState, **settings: float | bool) -> PokeState:
    """Return a state with changed settings; they apply to a press in progress too."""
    state = replace(state, **settings)  # type: ignore[arg-type]
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    return _with_tip(state, replace(tip, radius=state.radius, wanted=_amount(state, tip.by_force)))


def lifted(state: PokeState, body: int) -> PokeState:
    """Return a state without the fingertips on a body, for when its size changes and they would be misplaced."""
    tips = tuple(None if tip and tip.body == body else tip for tip in state.tips)
    return replace(state, tips=tips, pressing=state.pressing and tips[state.active] is not None)


def _move(state: PokeState, event: PokeEvent) -> PokeState:
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    on_body = event.hit and event.hit.body == tip.body
    goal = _aim(state, event.hit, event.view, by_force=tip.by_force) if event.hit and on_body else tip.goal
    if _leaps(along(goal.at, tip.goal.at, -1.0), event.view, tip.radius):
        tip = replace(tip, aim=goal, goal=goal, way=(), reached=0.0, depth=0.0)
    wanted = _amount(state, tip.by_force) * event.pressure
    return _pinched(_with_tip(state, replace(led(tip, goal), wanted=wanted)))


def _leaps(way: Vector, view: Vector, radius: float) -> bool:
    """Return whether a motion [m] is longer along the view than across it by more than the fingertip is wide: that is
    a jump over a silhouette, not a drag over the surface.
    """
    return abs(dot(way, view)) - length(along(way, view, -dot(way, view))) > 2 * radius


def _press(state: PokeState, event: PokeEvent) -> PokeState:
    if event.hit is None:
        return state
    aim = _aim(state, event.hit, event.view, by_force=state.by_force)
    wanted = _amount(state, state.by_force) * event.pressure
    tip = PokeTip(
        body=event.hit.body, aim=aim, goal=aim, radius=state.radius, wanted=wanted, by_force=state.by_force
    )  # fmt: skip
    return _pinched(replace(_with_tip(state, tip), pressing=True))


def _pinched(state: PokeState) -> PokeState:
    """Return a state in which two fingertips on opposite sides of one body press towards each other."""
    tip = state.tips[state.active]
    assert tip
    across = [
        (i, other) for i, other in enumerate(state.tips)
        if other and i != state.active and other.body == tip.body and not other.leaving
        and dot(other.goal.outward, tip.goal.outward) < 0
    ]  # fmt: skip
    if len(across) != 1:
        return state
    (index, other), = across
    way = along(other.goal.at, tip.goal.at, -1.0)
    there, back = unit(way, tip.goal.inward), unit(scaled(way, -1.0), other.goal.inward)
    tips = list(state.tips)
    aim = replace(tip.aim, inward=there) if tip.reached == 0 else tip.aim
    tips[state.active] = replace(tip, aim=aim, goal=replace(tip.goal, inward=there))
    tips[index] = replace(other, goal=replace(other.goal, inward=back))  # it turns gradually, without a jump
    return replace(state, tips=tuple(tips))


def _release(state: PokeState) -> PokeState:
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    return replace(_with_tip(state, leaving(tip)), pressing=False)


def _choose(state: PokeState, chosen: int) -> PokeState:
    """Choose a finger. The one that presses stays, so that a pinch can be set up; if chosen again, it leaves."""
    if not 0 <= chosen < MAX_FINGERTIPS:
        return state
    if chosen == state.active:
        tip = state.tips[chosen]
        if state.pressing or tip is None or tip.leaving:
            return state
        return _with_tip(state, leaving(tip))
    return replace(state, active=chosen, pressing=False)


def _amount(state: PokeState, by_force: bool) -> float:
    return state.force if by_force else state.depth


def _aim(state: PokeState, hit: Hit, view: Vector, *, by_force: bool) -> Aim:
    x, y, z = hit.normal
    # a fingertip pushed at an angle would jam: a drag fixes it sideways, where the surface could resist any force
    straight = state.along_normal or by_force
    return Aim(hit.point, hit.normal, (-x, -y, -z) if straight else view)


def _with_tip(state: PokeState, tip: PokeTip) -> PokeState:
    return replace(state, tips=tuple(tip if i == state.active else old for i, old in enumerate(state.tips)))


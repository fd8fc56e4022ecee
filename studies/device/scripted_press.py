"""A scripted press of three fingers, and what it came to by the device's own trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from core.base import DimpleError, Floats
from core.device.orders import ServoReport
from core.device.wire import RAMP
from core.device.workspace import Workspace
from studies.bench.hand import Keyframe
from studies.paper_objects import PRESETS

PRESET = PRESETS[1]  # vinyl and air: K1 = 610 N/m
RADIUS = 0.010  # [m] of the fingertips
APART = 0.040  # [m] of each from the middle of the top
CLEAR = 0.015  # [m] above the top, where a press begins
LEVELS = (0.005, 0.010, 0.015)  # [m] below the surface, where the hand wants its fingertips; they yield to the force
MOVE, HOLD, LIFT, SETTLE = 0.15, 0.40, 0.30, 0.10  # [s]
READY_AFTER = 1.3  # [s] from the beginning of the device's ramp until the servo's is over too
WORKSPACE = Workspace(origin=(0.0, 0.0, PRESET.size / 2 + RADIUS))
WRONG = 0.002  # [m] a position farther from the truth cannot be noise: its frame was wrong


@dataclass(frozen=True, slots=True)
class PressRecord:
    """The record of a scripted press.

    cycles: how often it pressed.
    levels: how deep the hand wanted each hold [m].
    report: the last of the servo.
    device: what the device measured.
    trace: of the device: time [s], mode, three positions [m], three forces [N].
    log: of the servo: time [us], then position [m] and force [N] of each tip.
    frames: of the session: time [s], stiffness cap then [N/m].
    """

    cycles: int
    levels: tuple[float, ...]
    report: ServoReport
    device: dict[str, float]
    trace: Floats
    log: Floats
    frames: Floats


def judge(record: PressRecord) -> dict[str, float]:
    """Return the figures of a press, by the device's own trace."""
    device, report = record.device, record.report
    time, places, forces = record.trace[:, 0], _tips(record.trace, 2), _tips(record.trace, 11)
    ramp = np.flatnonzero(record.trace[:, 1] == RAMP)
    begin = time[ramp[0] if len(ramp) else 0]  # Haply's service has no ramp: the hand begins with the connection
    times = holds(record.cycles, record.levels)
    held = [_holding(times, time - begin, places[:, i], forces[:, i], PRESET.material.law) for i in range(3)]
    slopes = np.array([slope for slope, _ in held])
    errors = np.concatenate([error for _, error in held])
    measured = record.log[:, 1:].reshape(-1, 3, 2, 3)[:, :, 0]
    row = np.searchsorted(time, record.log[:, 0] * 1e-6 - 1e-6)
    off = np.linalg.norm(measured - places[np.minimum(row, len(time) - 1)], axis=2)
    given = -np.cumsum((forces[:-1] * np.diff(places, axis=0)).sum(axis=2), axis=0)
    swung, crept = shake(times, time - begin, places)
    level = {}
    for depth, start in zip(record.levels, times, strict=False):
        during = (time - begin > start + SETTLE) & (time - begin < start + HOLD)
        law = np.array([PRESET.material.law(-z) for z in np.median(places[during, :, 2], axis=0)])
        level[f"law_at_{1e3 * depth:g}_mm"] = float(np.median(np.median(forces[during, :, 2], axis=0) / law))
    return {
        "real_time": device["real_time"],
        "rate_hz": report.rate,
        "rtt_p50_us": device["rtt_p50_us"],
        "rtt_p99_us": device["rtt_p99_us"],
        "wire_us": device["wire_us"],
        "late_share": device["late_share"],
        "longest_gap_ms": 1e-3 * float(np.diff(record.log[:, 0]).max()),  # beyond 5 ms the device lets go
        "ramps": int((np.diff(record.trace[:, 1] == RAMP, prepend=0) > 0).sum()),  # more than one: it let go meanwhile
        "lost_frames": report.lost + device["lost"],
        "unsent_frames": report.unsent,
        "wrong_frames": int((off > WRONG).any(axis=1).sum()),
        "refused_frames": report.wrong + device["bad"],
        "force_rms_error_n": float(np.sqrt((errors**2).mean())),
        "force_largest_n": float(np.abs(forces).max()),
        "shake_mm": 1e3 * swung,
        "creep_mm": 1e3 * crept,
        "stiffness_error": float(np.abs(slopes / PRESET.material.K1 - 1).max()),
        "stiffness_rendered_n_m": float(slopes.mean()),
        "stiffness_cap_n_m": float(np.median(record.frames[:, 1])),
        "longest_frame_ms": 1e3 * float(np.diff(record.frames[:, 0]).max()),
        "tip_rms_error_mm": 1e3 * float(np.sqrt((off**2).mean())),
        "energy_mj": 1e3 * float(given.min()),
        "observed_mj": 1e3 * min(tip.least_energy for tip in report.tips),
        **level,
    }


def _tips(rows: Floats, first: int) -> Floats:
    return rows[:, first : first + 9].reshape(-1, 3, 3)


def _holding(
    times: list[float], time: Floats, places: Floats, forces: Floats, law: Callable[[float], float]
) -> tuple[float, Floats]:
    """Return the stiffness [N/m] from hold to hold, and the errors of the force against the law while holding [N]."""
    depths, pushes, errors = [], [], []
    for begin in times:
        during = (time > begin + SETTLE) & (time < begin + HOLD)
        if not during.any():
            break  # the device was lost
        depths.append(-np.median(places[during, 2]))
        pushes.append(np.median(forces[during, 2]))
        errors.append(forces[during, 2] - np.array([law(-z) for z in places[during, 2]]))
    if len(depths) < 2:
        raise DimpleError("The device was lost before it had pressed: this computer is too busy.")
    return float(np.polyfit(depths, pushes, 1)[0]), np.concatenate(errors)


def shake(times: list[float], time: Floats, places: Floats) -> tuple[float, float]:
    """Return how far a fingertip swings, and how far it creeps, in the later half of a hold [m].

    One that only creeps, freed from dry friction by the noise of its converters, does not come back.
    """
    late = [places[(time > begin + HOLD / 2) & (time < begin + HOLD)] for begin in times]
    late = [x for x in late if len(x)]
    return max(map(swing, late), default=0.0), max((float(np.ptp(x, axis=0).max()) for x in late), default=0.0)


def swing(x: Floats) -> float:
    """Return how far places (t, ...) go and come back [m]."""
    up, down = (x - np.minimum.accumulate(x)).max(axis=0), (np.maximum.accumulate(x) - x).max(axis=0)
    return float(np.minimum(up, down).max())


def cycle(levels: tuple[float, ...] = LEVELS) -> float:
    """Return how long one press takes [s]."""
    return 2 * LIFT + len(levels) * (MOVE + HOLD)


def holds(cycles: int, levels: tuple[float, ...] = LEVELS) -> list[float]:
    """Return when the hand begins to hold [s]."""
    return [
        READY_AFTER + c * cycle(levels) + LIFT + i * (MOVE + HOLD) + MOVE
        for c in range(cycles)
        for i in range(len(levels))
    ]


def way(finger: int, cycles: int, levels: tuple[float, ...] = LEVELS) -> list[Keyframe]:
    """Return the keyframes of a fingertip: above the top, then from level to level, and up again."""
    angle = finger * 2 * np.pi / 3
    x, y = float(-APART * np.cos(angle)), float(-APART * np.sin(angle))  # on the side of its block
    keys = [(READY_AFTER, x, y, CLEAR)]
    for c in range(cycles):
        at = READY_AFTER + c * cycle(levels) + LIFT
        keys += [(at, x, y, CLEAR)]
        for level in levels:
            keys += [(at + MOVE, x, y, -level), (at + MOVE + HOLD, x, y, -level)]
            at += MOVE + HOLD
        keys += [(at + LIFT - 0.01, x, y, CLEAR)]
    return keys

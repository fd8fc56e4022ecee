"""The numbers of a haptic device, from its TOML file, and whether the device on the line is that one."""

from __future__ import annotations

import math
import struct
import tomllib
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ..errors import DimpleError
from ..messages import Message
from ..vectors import Vector
from . import wire
from .safety import (
    HARD_CEILING,
    QUIET_FORCE,
    QUIET_TIME,
    RAMP_TIME,
    RMS_TIME,
    SLEW,
    STATE_GAP,
    STATE_LOST,
    TOP_SPEED,
)

HAPTIC_MASTER: Final = Path(__file__).with_name("haptic_master.toml")
BITS_A_BYTE: Final = 10  # on a serial line: start, eight, stop
HAS_FORCE: Final = 1  # Info.capabilities
ZERO_TIME: Final = 0.025  # [s] by which a force is zero without commands, at the latest


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """The numbers of a device in SI units; haptic_master.toml explains each.

    Raises:
        DimpleError: the baud rate cannot carry a STATE each tick.
    """

    name: str
    block_names: tuple[str, ...]
    block_angles: Vector
    geometry: int
    l1: float
    l2: float
    centre_distance: float
    base_height: float
    workspace_radius: float
    stop_radius: float
    adc_bits: int
    adc_span: float
    adc_noise: float
    adc_centres: Vector
    dac_bits: int
    torque_limits: Vector
    peak_force: float
    continuous_force: float
    rms_window: float
    tip_mass: float
    viscous: float
    coulomb: float
    tick_hz: int
    baud: int
    hold: float
    zero: float
    latch: float
    slew: float
    tip_speed: float
    arm_force: float
    arm_time: float
    ramp_time: float
    brake: float

    def __post_init__(self) -> None:
        highest = self.baud // (BITS_A_BYTE * wire.size(wire.DeviceState))
        if self.tick_hz > highest:
            raise DimpleError(
                "{baud} baud cannot carry the {tick_hz} positions a second of the {name}, {highest} at most. Raise "
                "the baud rate, on the device too, or use a device that is made for a lower rate (tick_hz).",
                baud=self.baud, tick_hz=self.tick_hz, name=self.name, highest=highest
            )  # fmt: skip

    def left(self, age: float) -> float:
        """Return the share of a force that still acts when its command is so old [s]."""
        return min(max((self.zero - age) / (self.zero - self.hold), 0.0), 1.0)

    @property
    def tick(self) -> float:
        """Return the period of the device [s]."""
        return 1 / self.tick_hz


def load_spec(path: Path | None = None) -> Spec:
    """Return the device of a TOML file, None for the Haptic Master.

    Raises:
        DimpleError: the file cannot be read, lacks a number, or has one that is not safe.
    """
    path = path or HAPTIC_MASTER
    try:
        spec = _spec(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise DimpleError(
            "The device file {path} cannot be read: {error}.", path=path, error=error.strerror or error
        ) from None
    except KeyError as error:
        raise DimpleError(
            "The device file {path} has no {error}; see {example}.", path=path, error=error, example=HAPTIC_MASTER.name
        ) from None
    except DimpleError:
        raise
    except ValueError as error:  # TOMLDecodeError and UnicodeDecodeError are among them
        raise DimpleError("The device file {path} is not valid: {error}.", path=path, error=error) from None
    return spec


def _spec(file: dict[str, Any]) -> Spec:
    spec = Spec(
        name=_text("name", file["name"]),
        block_names=tuple(_text("names", name) for name in _list(file, "blocks", "names")),
        block_angles=_three(file, "blocks", "angles_deg", math.pi / 180),
        geometry=_whole(file, "geometry", "id"),
        l1=_number(file, "geometry", "l1_m"),
        l2=_number(file, "geometry", "l2_m"),
        centre_distance=_number(file, "geometry", "centre_distance_m"),
        base_height=_number(file, "geometry", "base_height_m"),
        workspace_radius=_number(file, "geometry", "workspace_diameter_m") / 2,
        stop_radius=_number(file, "geometry", "stop_diameter_m") / 2,
        adc_bits=_whole(file, "sensors", "adc_bits"),
        adc_span=math.radians(_number(file, "sensors", "span_deg")),
        adc_noise=_number(file, "sensors", "noise_steps"),
        adc_centres=_three(file, "sensors", "centres_deg", math.pi / 180),
        dac_bits=_whole(file, "motors", "dac_bits"),
        torque_limits=_three(file, "motors", "torque_limits_nm"),
        peak_force=_number(file, "motors", "peak_force_n"),
        continuous_force=_number(file, "motors", "continuous_force_n"),
        rms_window=_number(file, "motors", "rms_window_s"),
        tip_mass=_number(file, "tip", "mass_kg"),
        viscous=_number(file, "tip", "viscous_ns_m"),
        coulomb=_number(file, "tip", "coulomb_n"),
        tick_hz=_whole(file, "link", "tick_hz"),
        baud=_whole(file, "link", "baud"),
        hold=_number(file, "safety", "hold_s"),
        zero=_number(file, "safety", "zero_s"),
        latch=_number(file, "safety", "latch_s"),
        slew=_number(file, "safety", "slew_n_s"),
        tip_speed=_number(file, "safety", "tip_speed_m_s"),
        arm_force=_number(file, "safety", "arm_force_n"),
        arm_time=_number(file, "safety", "arm_s"),
        ramp_time=_number(file, "safety", "ramp_s"),
        brake=_number(file, "safety", "brake_ns_m"),
    )
    _check(spec, _number(file, "motors", "force_ceiling_n"))
    return spec


def _value(file: dict[str, Any], table: str, name: str) -> Any:
    if not isinstance(file[table], dict):
        raise ValueError(Message("[{table}] must be a table", table=table))
    return file[table][name]


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError(Message("{name} must be text, not {value}", name=name, value=repr(value)))
    return value


def _real(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(Message("{name} must be a number, not {value}", name=name, value=repr(value)))
    return float(value)


def _number(file: dict[str, Any], table: str, name: str) -> float:
    return _real(name, _value(file, table, name))


def _whole(file: dict[str, Any], table: str, name: str) -> int:
    number = _number(file, table, name)
    if number != round(number):
        raise ValueError(Message("{name} must be a whole number, not {value}", name=name, value=repr(number)))
    return round(number)


def _list(file: dict[str, Any], table: str, name: str) -> list[Any]:
    values = _value(file, table, name)
    if not isinstance(values, list) or len(values) != wire.FINGERS:
        raise ValueError(Message("{name} must be a list of three, not {value}", name=name, value=repr(values)))
    return values


def _three(file: dict[str, Any], table: str, name: str, factor: float = 1.0) -> Vector:
    a, b, c = (factor * _real(name, value) for value in _list(file, table, name))
    return a, b, c


def _check(spec: Spec, ceiling: float) -> None:
    for what, holds in (
        ("continuous_force_n, peak_force_n and force_ceiling_n must not fall in this order and be above 0",
         0 < spec.continuous_force <= spec.peak_force <= ceiling <= HARD_CEILING),
        (Message("hold_s, zero_s and latch_s must rise, to {state_gap}, {zero_time} and {state_lost} at most",
                 state_gap=STATE_GAP, zero_time=ZERO_TIME, state_lost=STATE_LOST),
         0 < spec.hold < spec.zero < spec.latch
         and spec.hold <= STATE_GAP and spec.zero <= ZERO_TIME and spec.latch <= STATE_LOST),
        (Message("slew_n_s must be above 0, {slew:g} at most", slew=SLEW), 0 < spec.slew <= SLEW),
        (Message("tip_speed_m_s must be above 0, {top_speed} at most", top_speed=TOP_SPEED),
         0 < spec.tip_speed <= TOP_SPEED),
        (Message("arm_force_n must be above 0, {quiet_force} at most", quiet_force=QUIET_FORCE),
         0 < spec.arm_force <= QUIET_FORCE),
        (Message("arm_s must be {quiet_time} at least and ramp_s {ramp_time} at least",
                 quiet_time=QUIET_TIME, ramp_time=RAMP_TIME),
         spec.arm_time >= QUIET_TIME and spec.ramp_time >= RAMP_TIME),
        ("l1_m and l2_m must be above 0, 2 at most", 0 < min(spec.l1, spec.l2) <= max(spec.l1, spec.l2) <= 2),
        ("mass_kg must be above 0, 10 at most", 0 < spec.tip_mass <= 10),
        # the stiffest wall follows from the friction, and a brake stronger than tip mass over ten ticks shakes
        ("viscous_ns_m must be from 0 to 20", 0 <= spec.viscous <= 20),
        ("coulomb_n must be from 0 to 5", 0 <= spec.coulomb <= 5),
        ("brake_ns_m must be from 0 to 12", 0 <= spec.brake <= 12),
        ("the workspace must be within reach", 0 < spec.workspace_radius <= spec.stop_radius < spec.centre_distance
         and math.hypot(spec.centre_distance + spec.stop_radius, spec.base_height) < spec.l1 + spec.l2
         and math.hypot(spec.centre_distance - spec.stop_radius, spec.base_height) > abs(spec.l1 - spec.l2)),
        ("adc_bits and dac_bits must be from 8 to 16", 8 <= spec.adc_bits <= 16 and 8 <= spec.dac_bits <= 16),
        ("span_deg must be above 0, 360 at most", 0 < spec.adc_span <= 2 * math.pi),
        ("angles_deg and centres_deg must be from -360 to 360",
         all(abs(angle) <= 2 * math.pi for angle in (*spec.block_angles, *spec.adc_centres))),
        ("noise_steps must be above 0 (a reading without noise counts as frozen), 100 at most",
         0 < spec.adc_noise <= 100),
        ("torque_limits_nm must be above 0, 60 at most", 0 < min(spec.torque_limits) and max(spec.torque_limits) <= 60),
        ("id must be from 0 to 255", 0 <= spec.geometry <= 255),
        # a force is held for 5 ms at most, on both ends: a slower device would drop it between two ticks
        ("tick_hz must be from 250 to 2000, and its period shorter than hold_s",
         250 <= spec.tick_hz <= 2000 and spec.tick < spec.hold),
        (Message("rms_window_s must be above 0, {rms_time:g} at most", rms_time=RMS_TIME),
         0 < spec.rms_window <= RMS_TIME),
    ):  # fmt: skip
        if not holds:
            raise ValueError(Message(what))


def geometry_crc(spec: Spec) -> int:
    """Return a number that differs for a linkage with other lengths, positions or converters."""
    numbers = (*spec.block_angles, spec.l1, spec.l2, spec.centre_distance, spec.base_height, *spec.adc_centres)
    return zlib.crc32(struct.pack(f"<I{len(numbers)}i", spec.geometry, *(round(1e6 * number) for number in numbers)))


def info(spec: Spec, nonce: int, session: int, protocol: tuple[int, int] = wire.PROTOCOL) -> wire.Info:
    """Return the INFO of a device."""
    return wire.Info(
        nonce=nonce,
        major=protocol[0],
        minor=protocol[1],
        session=session,
        blocks=len(spec.block_names),
        adc_bits=spec.adc_bits,
        dac_bits=spec.dac_bits,
        span_1e4rad=round(1e4 * spec.adc_span),
        torque_mnm=tuple(round(1e3 * limit) for limit in spec.torque_limits),  # type: ignore[arg-type]
        tick_hz=spec.tick_hz,
        hold_ms=round(1e3 * spec.hold),
        zero_ms=round(1e3 * spec.zero),
        latch_ms=round(1e3 * spec.latch),
        peak_cn=round(100 * spec.peak_force),
        continuous_cn=round(100 * spec.continuous_force),
        speed_dms=round(10 * spec.tip_speed),
        geometry=spec.geometry,
        geometry_crc=geometry_crc(spec),
        capabilities=HAS_FORCE,
    )


def check_info(spec: Spec, reported: wire.Info) -> None:
    """Refuse a device that is not the one of the file: forces and positions would be wrong.

    Raises:
        DimpleError: another protocol, linkage, converter, tick or limit.
    """
    if reported.major != wire.PROTOCOL[0]:
        raise DimpleError(
            "The device speaks protocol {major}.{minor}, this Dimple {own_major}.{own_minor}: they do not understand "
            "each other. Update the older of the two.",
            major=reported.major, minor=reported.minor, own_major=wire.PROTOCOL[0], own_minor=wire.PROTOCOL[1]
        )  # fmt: skip
    own = info(spec, reported.nonce, reported.session)
    free = {"nonce", "minor", "session", "capabilities"}
    other = [name for name, a, b in zip(own._fields, reported, own, strict=True) if a != b and name not in free]
    if other:
        differences = ", ".join(
            Message(
                "{name} {given} instead of {expected}",
                name=name,
                given=getattr(reported, name),
                expected=getattr(own, name),
            )
            for name in other
        )
        raise DimpleError(
            "The device is not the one of the device file ({name}): it reports {differences}. Choose the file of "
            "this device.",
            name=spec.name, differences=differences
        )  # fmt: skip

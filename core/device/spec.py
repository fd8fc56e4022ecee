"""The numbers of a haptic device, from its TOML file, and whether the device on the line is that one."""

from __future__ import annotations

import math
import struct
import tomllib
import zlib
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from ..errors import DimpleError
from ..messages import Message
from ..vectors import Vector
from . import wire
from .limits import HARD_CEILING, LOST_TIME, STATE_GAP, TOP_SPEED, ZERO_TIME

HAPTIC_MASTER: Final = Path(__file__).with_name("haptic_master.toml")
BITS_A_BYTE: Final = 10  # on a serial line: start, eight, stop
HAS_FORCE: Final = 1  # Info.capabilities
DEGREE: Final = math.pi / 180


def _at(table: str, key: str, factor: float | None = 1.0) -> Any:
    """Say where a value is in the file, and what it is multiplied by there; 0: it is whole; None: it is text."""
    return field(metadata={"at": (table, key, factor)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """The numbers of a device in SI units; haptic_master.toml explains each.

    Raises:
        DimpleError: the baud rate cannot carry a STATE each tick.
    """

    name: str = _at("", "name", None)
    block_names: tuple[str, ...] = _at("blocks", "names", None)
    block_angles: Vector = _at("blocks", "angles_deg", DEGREE)
    geometry: int = _at("geometry", "id", 0)
    l1: float = _at("geometry", "l1_m")
    l2: float = _at("geometry", "l2_m")
    centre_distance: float = _at("geometry", "centre_distance_m")
    base_height: float = _at("geometry", "base_height_m")
    workspace_radius: float = _at("geometry", "workspace_diameter_m", 0.5)
    adc_bits: int = _at("sensors", "adc_bits", 0)
    adc_span: float = _at("sensors", "span_deg", DEGREE)
    adc_centres: Vector = _at("sensors", "centres_deg", DEGREE)
    dac_bits: int = _at("motors", "dac_bits", 0)
    torque_limits: Vector = _at("motors", "torque_limits_nm")
    peak_force: float = _at("motors", "peak_force_n")
    continuous_force: float = _at("motors", "continuous_force_n")
    viscous: float = _at("tip", "viscous_ns_m")
    tick_hz: int = _at("link", "tick_hz", 0)
    baud: int = _at("link", "baud", 0)
    hold: float = _at("safety", "hold_s")
    zero: float = _at("safety", "zero_s")
    latch: float = _at("safety", "latch_s")
    tip_speed: float = _at("safety", "tip_speed_m_s")

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
        file = tomllib.loads(path.read_text(encoding="utf-8"))
        spec = Spec(**{each.name: _read(file, each) for each in fields(Spec)})
        _check(spec)
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


def _read(file: dict[str, Any], place: Field[Any]) -> Any:
    """Return the value of a field; all values of a list are read alike."""
    table, key, factor = place.metadata["at"]
    values = file[table] if table else file
    if not isinstance(values, dict):
        raise ValueError(Message("[{table}] must be a table", table=table))
    value = values[key]
    if place.type not in ("Vector", "tuple[str, ...]"):
        return _one(key, value, factor)
    if not isinstance(value, list) or len(value) != wire.FINGERS:
        raise ValueError(Message("{name} must be a list of three, not {value}", name=key, value=repr(value)))
    return tuple([_one(key, each, factor) for each in value])


def _one(name: str, value: Any, factor: float | None) -> Any:
    if factor is None:
        if not isinstance(value, str) or not value:
            raise ValueError(Message("{name} must be text, not {value}", name=name, value=repr(value)))
        return value
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(Message("{name} must be a number, not {value}", name=name, value=repr(value)))
    if not factor and value != round(value):
        raise ValueError(Message("{name} must be a whole number, not {value}", name=name, value=repr(value)))
    return factor * value if factor else round(value)


def _check(spec: Spec) -> None:
    far, near = spec.centre_distance + spec.workspace_radius, spec.centre_distance - spec.workspace_radius
    for what, holds in (
        (Message("continuous_force_n and peak_force_n must be above 0, {most:g} at most, and not fall in this order",
                 most=HARD_CEILING),
         0 < spec.continuous_force <= spec.peak_force <= HARD_CEILING),
        (Message("hold_s, zero_s and latch_s must rise, to {state_gap}, {zero_time} and {state_lost} at most",
                 state_gap=STATE_GAP, zero_time=ZERO_TIME, state_lost=LOST_TIME),
         0 < spec.hold < spec.zero < spec.latch
         and spec.hold <= STATE_GAP and spec.zero <= ZERO_TIME and spec.latch <= LOST_TIME),
        (Message("tip_speed_m_s must be above 0, {top_speed} at most", top_speed=TOP_SPEED),
         0 < spec.tip_speed <= TOP_SPEED),
        ("l1_m and l2_m must be above 0, 2 at most", 0 < min(spec.l1, spec.l2) <= max(spec.l1, spec.l2) <= 2),
        ("viscous_ns_m must be from 0 to 20", 0 <= spec.viscous <= 20),  # the stiffest wall follows from it
        ("the workspace must be within reach", 0 < spec.workspace_radius < spec.centre_distance
         and math.hypot(far, spec.base_height) < spec.l1 + spec.l2
         and math.hypot(near, spec.base_height) > abs(spec.l1 - spec.l2)),
        ("adc_bits and dac_bits must be from 8 to 16", 8 <= spec.adc_bits <= 16 and 8 <= spec.dac_bits <= 16),
        ("span_deg must be above 0, 360 at most", 0 < spec.adc_span <= 2 * math.pi),
        ("angles_deg and centres_deg must be from -360 to 360",
         all(abs(angle) <= 2 * math.pi for angle in (*spec.block_angles, *spec.adc_centres))),
        ("torque_limits_nm must be above 0, 60 at most", 0 < min(spec.torque_limits) and max(spec.torque_limits) <= 60),
        ("id must be from 0 to 255", 0 <= spec.geometry <= 255),
        # a force is held for 5 ms at most, on both ends: a slower device would drop it between two ticks
        ("tick_hz must be from 250 to 2000, and its period shorter than hold_s",
         250 <= spec.tick_hz <= 2000 and spec.tick < spec.hold),
    ):  # fmt: skip
        if not holds:
            raise ValueError(Message(what))


def geometry_crc(spec: Spec) -> int:
    """Return a number that differs for a linkage with other lengths, positions or converters."""
    numbers = (*spec.block_angles, spec.l1, spec.l2, spec.centre_distance, spec.base_height, *spec.adc_centres)
    return zlib.crc32(struct.pack(f"<I{len(numbers)}i", spec.geometry, *(round(1e6 * number) for number in numbers)))


def info(spec: Spec, nonce: int, session: int, protocol: tuple[int, int] = wire.PROTOCOL) -> wire.Info:
    """Return the INFO of a device."""
    a, b, c = (round(1e3 * limit) for limit in spec.torque_limits)
    return wire.Info(
        nonce=nonce, major=protocol[0], minor=protocol[1], session=session, blocks=len(spec.block_names),
        adc_bits=spec.adc_bits, dac_bits=spec.dac_bits, span_1e4rad=round(1e4 * spec.adc_span), torque_mnm=(a, b, c),
        tick_hz=spec.tick_hz, hold_ms=round(1e3 * spec.hold), zero_ms=round(1e3 * spec.zero),
        latch_ms=round(1e3 * spec.latch), peak_cn=round(100 * spec.peak_force),
        continuous_cn=round(100 * spec.continuous_force), speed_dms=round(10 * spec.tip_speed),
        geometry=spec.geometry, geometry_crc=geometry_crc(spec), capabilities=HAS_FORCE,
    )  # fmt: skip


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
    other = [(name, a, b) for name, a, b in zip(own._fields, reported, own, strict=True) if a != b and name not in free]
    if other:
        differences = ", ".join(
            Message("{name} {given} instead of {expected}", name=name, given=a, expected=b) for name, a, b in other
        )
        raise DimpleError(
            "The device is not the one of the device file ({name}): it reports {differences}. Choose the file of "
            "this device.",
            name=spec.name, differences=differences
        )  # fmt: skip

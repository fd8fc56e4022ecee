"""What a haptic device is: the numbers of its TOML file, and whether the device on the line is that one."""

from __future__ import annotations

import math
import struct
import tomllib
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ..errors import DimpleError
from . import wire
from .vectors import Vector

HAPTIC_MASTER: Final = Path(__file__).with_name("haptic_master.toml")
BITS_A_BYTE: Final = 10  # on a serial line: start, eight, stop
HAS_FORCE: Final = 1  # Info.capabilities


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """Hold the numbers of a device, SI; haptic_master.toml says what each is.

    Raises:
        DimpleError: the baud rate cannot carry a State each tick.
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
        most = self.baud // (BITS_A_BYTE * wire.size(wire.State))
        if self.tick_hz > most:
            raise DimpleError(
                f"{self.baud} baud cannot carry the {self.tick_hz} positions a second of the {self.name}, {most} at "
                "most. Raise the baud rate, on the device too, or use a device that is made for a lower rate (tick_hz)."
            )

    @property
    def tick(self) -> float:
        """Return the period of the device [s]."""
        return 1 / self.tick_hz


def load_spec(path: Path | None = None) -> Spec:
    """Return the device of a TOML file, None for the Haptic Master.

    Raises:
        DimpleError: the file is not to be read, lacks a number, or asks for what is not safe.
    """
    path = path or HAPTIC_MASTER
    try:
        spec = _spec(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise DimpleError(f"The device file {path} cannot be read: {error.strerror or error}.") from None
    except KeyError as error:
        raise DimpleError(f"The device file {path} has no {error}; see {HAPTIC_MASTER.name}.") from None
    except DimpleError:
        raise
    except (TypeError, ValueError) as error:  # TOMLDecodeError and UnicodeDecodeError are ValueErrors
        raise DimpleError(f"The device file {path} is not right: {error}.") from None
    return spec


def _spec(file: dict[str, Any]) -> Spec:
    blocks, geometry, sensors = file["blocks"], file["geometry"], file["sensors"]
    motors, tip, link, safety = file["motors"], file["tip"], file["link"], file["safety"]
    spec = Spec(
        name=str(file["name"]),
        block_names=tuple(map(str, blocks["names"])),
        block_angles=_three(blocks["angles_deg"], math.pi / 180),
        geometry=int(geometry["id"]),
        l1=float(geometry["l1_m"]),
        l2=float(geometry["l2_m"]),
        centre_distance=float(geometry["centre_distance_m"]),
        base_height=float(geometry["base_height_m"]),
        workspace_radius=geometry["workspace_diameter_m"] / 2,
        stop_radius=geometry["stop_diameter_m"] / 2,
        adc_bits=int(sensors["adc_bits"]),
        adc_span=math.radians(sensors["span_deg"]),
        adc_noise=float(sensors["noise_steps"]),
        adc_centres=_three(sensors["centres_deg"], math.pi / 180),
        dac_bits=int(motors["dac_bits"]),
        torque_limits=_three(motors["torque_limits_nm"]),
        peak_force=float(motors["peak_force_n"]),
        continuous_force=float(motors["continuous_force_n"]),
        rms_window=float(motors["rms_window_s"]),
        tip_mass=float(tip["mass_kg"]),
        viscous=float(tip["viscous_ns_m"]),
        coulomb=float(tip["coulomb_n"]),
        tick_hz=int(link["tick_hz"]),
        baud=int(link["baud"]),
        hold=float(safety["hold_s"]),
        zero=float(safety["zero_s"]),
        latch=float(safety["latch_s"]),
        slew=float(safety["slew_n_s"]),
        tip_speed=float(safety["tip_speed_m_s"]),
        arm_force=float(safety["arm_force_n"]),
        arm_time=float(safety["arm_s"]),
        ramp_time=float(safety["ramp_s"]),
        brake=float(safety["brake_ns_m"]),
    )
    _check(spec, float(motors["force_ceiling_n"]))
    return spec


def _three(numbers: list[float], factor: float = 1.0) -> Vector:
    a, b, c = numbers
    return a * factor, b * factor, c * factor


def _check(spec: Spec, ceiling: float) -> None:
    for what, holds in (
        ("continuous_force_n, peak_force_n and force_ceiling_n must not fall in this order and be above 0",
         0 < spec.continuous_force <= spec.peak_force <= ceiling <= 20),
        ("hold_s, zero_s and latch_s must rise, to 0.005, 0.025 and 0.1 at most",
         0 < spec.hold < spec.zero < spec.latch and spec.hold <= 5e-3 and spec.zero <= 25e-3 and spec.latch <= 0.1),
        ("slew_n_s must be above 0, 1000 at most", 0 < spec.slew <= 1000),
        ("tip_speed_m_s must be above 0, 1.5 at most", 0 < spec.tip_speed <= 1.5),
        ("arm_force_n must be above 0, 0.2 at most", 0 < spec.arm_force <= 0.2),
        ("arm_s must be 0.05 at least and ramp_s 0.5 at least", spec.arm_time >= 0.05 and spec.ramp_time >= 0.5),
        ("l1_m, l2_m and mass_kg must be above 0", min(spec.l1, spec.l2, spec.tip_mass) > 0),
        ("viscous_ns_m, coulomb_n, brake_ns_m must not be below 0", min(spec.viscous, spec.coulomb, spec.brake) >= 0),
        ("the workspace must be within reach", 0 < spec.workspace_radius <= spec.stop_radius < spec.centre_distance
         and math.hypot(spec.centre_distance + spec.stop_radius, spec.base_height) < spec.l1 + spec.l2),
        ("adc_bits and dac_bits must be from 8 to 16", 8 <= spec.adc_bits <= 16 and 8 <= spec.dac_bits <= 16),
        ("span_deg and torque_limits_nm must be above 0", min(spec.adc_span, *spec.torque_limits) > 0),
        ("three blocks have three names", len(spec.block_names) == wire.FINGERS),
        ("tick_hz must be from 50 to 2000, rms_window_s above 0", 50 <= spec.tick_hz <= 2000 and spec.rms_window > 0),
    ):  # fmt: skip
        if not holds:
            raise ValueError(what)


def geometry_crc(spec: Spec) -> int:
    """Return a number that is another for a linkage with other lengths, places or converters."""
    numbers = (*spec.block_angles, spec.l1, spec.l2, spec.centre_distance, spec.base_height, *spec.adc_centres)
    return zlib.crc32(struct.pack(f"<I{len(numbers)}i", spec.geometry, *(round(1e6 * number) for number in numbers)))


def info(spec: Spec, nonce: int, session: int, protocol: tuple[int, int] = wire.PROTOCOL) -> wire.Info:
    """Return what a device says of itself."""
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


def check_info(spec: Spec, said: wire.Info) -> None:
    """Refuse a device that is not the one of the file: forces and places would be wrong.

    Raises:
        DimpleError: another protocol, linkage, converter, tick or limit.
    """
    if said.major != wire.PROTOCOL[0]:
        raise DimpleError(
            f"The device speaks protocol {said.major}.{said.minor}, this Dimple {wire.PROTOCOL[0]}.{wire.PROTOCOL[1]}: "
            "they do not understand each other. Update the older of the two."
        )
    own = info(spec, said.nonce, said.session)
    free = {"nonce", "minor", "session", "capabilities"}
    other = [name for name, a, b in zip(own._fields, said, own, strict=True) if a != b and name not in free]
    if other:
        differences = ", ".join(f"{name} {getattr(said, name)} instead of {getattr(own, name)}" for name in other)
        raise DimpleError(
            f"The device is not the one of the device file ({spec.name}): it says {differences}. "
            "Choose the file of this device."
        )

"""The numbers of an emulated device: those of a device file, and those that only its mechanics and firmware know."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from core.device import wire
from core.device.limits import QUIET_FORCE, QUIET_TIME, RAMP_TIME, RMS_TIME, SLEW
from core.device.spec import Spec, spec_of
from core.errors import DimpleError
from core.vectors import Vector

HAPTIC_MASTER: Final = Path(__file__).with_name("haptic_master.toml")
BITS_A_BYTE: Final = 10  # on a serial line: start, eight, stop
DEGREE: Final = math.pi / 180


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedSpec(Spec):
    """The numbers of an emulated device; haptic_master.toml explains those without a value, the others are assumed.

    adc_noise: of a reading, root mean square [steps]; a reading without any counts as frozen.
    tip_mass: of the linkage, as it acts at the tip [kg].
    coulomb: dry friction at the tip [N].
    stop_radius: where the linkage meets its mechanical stops [m].
    brake: of the viscous brake [N s/m].
    arm_force, arm_time: the quiet that arming waits for [N], [s].
    ramp_time: in which the force grows from nothing [s].
    rms_window: of the continuous force [s].
    slew: of the force [N/s].
    """

    name: str
    block_names: tuple[str, ...]
    block_angles: Vector
    l1: float
    l2: float
    centre_distance: float
    base_height: float
    workspace_radius: float
    adc_bits: int
    adc_span: float
    adc_centres: Vector
    dac_bits: int
    torque_limits: Vector
    baud: int
    adc_noise: float = 0.1
    tip_mass: float = 0.12
    coulomb: float = 0.2
    stop_radius: float = 0.21
    brake: float = 5.0
    arm_force: float = QUIET_FORCE
    arm_time: float = QUIET_TIME
    ramp_time: float = RAMP_TIME
    rms_window: float = RMS_TIME
    slew: float = SLEW


def load_emulated(path: Path | None = None) -> EmulatedSpec:
    """Return an emulated device of a TOML file, None for the Haptic Master.

    Raises:
        DimpleError: the file cannot be read, lacks a number, or has one that is not safe.
    """
    path = path or HAPTIC_MASTER
    try:
        spec = _spec(tomllib.loads(path.read_text(encoding="utf-8")))
        spec_of(info(spec, 0, 0))
    except OSError as error:
        raise DimpleError(f"The device file {path} cannot be read: {error.strerror}.") from None
    except (KeyError, TypeError, ValueError) as error:
        raise DimpleError(f"The device file {path} is not valid: {error!r}.") from None
    return spec


def _spec(file: dict[str, Any]) -> EmulatedSpec:
    blocks, geometry, sensors, motors = (file[name] for name in ("blocks", "geometry", "sensors", "motors"))
    link, safety = file["link"], file["safety"]
    return EmulatedSpec(
        name=file["name"], block_names=tuple(blocks["names"]), block_angles=_radians(blocks["angles_deg"]),
        l1=geometry["l1_m"], l2=geometry["l2_m"], centre_distance=geometry["centre_distance_m"],
        base_height=geometry["base_height_m"], workspace_radius=geometry["workspace_diameter_m"] / 2,
        adc_bits=sensors["adc_bits"], adc_span=sensors["span_deg"] * DEGREE,
        adc_centres=_radians(sensors["centres_deg"]), dac_bits=motors["dac_bits"],
        torque_limits=tuple(motors["torque_limits_nm"]), peak_force=motors["peak_force_n"],
        continuous_force=motors["continuous_force_n"], viscous=file["tip"]["viscous_ns_m"], tick_hz=link["tick_hz"],
        baud=link["baud"], hold=safety["hold_s"], zero=safety["zero_s"], latch=safety["latch_s"],
        tip_speed=safety["tip_speed_m_s"],
    )  # fmt: skip


def _radians(degrees: list[float]) -> Vector:
    a, b, c = (angle * DEGREE for angle in degrees)
    return a, b, c


def info(spec: Spec, nonce: int, session: int, protocol: tuple[int, int] = wire.PROTOCOL) -> wire.Info:
    """Return the INFO of a device."""
    return spec.info(nonce, session)._replace(major=protocol[0], minor=protocol[1])

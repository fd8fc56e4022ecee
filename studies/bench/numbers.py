"""The numbers of an emulated device: those of a device file, and those that only its mechanics and firmware know."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

from core.device.limits import QUIET_FORCE, QUIET_TIME, RAMP_TIME, RMS_TIME, SLEW
from core.device.spec import Spec, load_spec


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedSpec(Spec):
    """The numbers of an emulated device; those added here are assumed.

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
        DimpleError: as `load_spec`.
    """
    spec = load_spec(path)
    return EmulatedSpec(**{field.name: getattr(spec, field.name) for field in fields(Spec)})

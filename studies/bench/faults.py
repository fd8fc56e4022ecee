"""The faults that can be injected between a device and its host."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from core.errors import DimpleError

FOREVER: Final = math.inf
# name: default value, what the value is
FAULTS: Final = {
    "flip": (1e-4, "share of bits that flip"),
    "garbage": (0.01, "share of frames with noise before them"),
    "truncate": (0.01, "share of frames cut short"),
    "drop": (0.01, "share of frames that never come"),
    "duplicate": (0.01, "share of frames that come twice"),
    "reorder": (0.01, "share of frames that come after the next one"),
    "delay": (0.003, "seconds every frame comes late"),
    "stale": (1.0, "1: frames wait until the fault ends, then come all at once (give +LENGTH)"),
    "wrong-baud": (1.0, "1: every byte is another one"),
    "unplug": (1.0, "1: the line is gone"),
    "stall": (1.0, "1: the device stands still"),
    "version": (3.0, "major protocol version of the device"),
    "adc-range": (0.0, "finger whose sensor reads its end (0, 1, 2)"),
    "adc-frozen": (0.0, "finger whose sensor repeats one reading"),
    "adc-jump": (0.0, "finger whose sensor is suddenly 0.3 rad off"),
}
ON_THE_LINE: Final = frozenset("flip garbage truncate drop duplicate reorder delay stale wrong-baud".split())


@dataclass(frozen=True, slots=True)
class InjectedFault:
    """One fault.

    name, value: as in FAULTS.
    start, stop: when it begins and ends [s].
    way: "in" to the device, "out" of it, "" both.
    """

    name: str
    value: float
    start: float = 0.0
    stop: float = FOREVER
    way: str = ""

    def acts(self, now: float) -> bool:
        """Tell whether it acts at a time [s]."""
        return self.start <= now < self.stop


def parse_fault(text: str) -> InjectedFault:
    """Return the fault of NAME[-in|-out][=VALUE][@START[+LENGTH]], times in seconds; slow-host is delay-in.

    Raises:
        DimpleError: there is no such fault, or a number is not one.
    """
    left, _, when = text.partition("@")
    name, _, value = left.partition("=")
    name = "delay-in" if name == "slow-host" else name
    way = next((way for way in ("in", "out") if name.endswith(f"-{way}") and name[: -len(way) - 1] in ON_THE_LINE), "")
    name = name.removesuffix(f"-{way}") if way else name
    if name not in FAULTS:
        raise DimpleError(f"There is no fault {name!r}. There are: slow-host, {', '.join(FAULTS)}.")
    begin, _, length = when.partition("+")
    try:
        number = float(value) if value else FAULTS[name][0]
        start = float(begin) if begin else 0.0
        stop = start + float(length) if length else FOREVER
    except ValueError:
        raise DimpleError(f"A number of the fault {text!r} is not one: NAME[=VALUE][@START[+LENGTH]].") from None
    if not (0 <= number < FOREVER and 0 <= start < stop):
        raise DimpleError(f"The fault {text!r} needs a value and a start of at least 0, and a length above 0.")
    return InjectedFault(name, number, start, stop, way)

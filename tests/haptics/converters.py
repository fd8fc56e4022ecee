"""The converters of a device, as the tests need them: from joint angles to readings of 16 bits."""

import math

from core.vectors import Vector
from studies.bench.numbers import EmulatedSpec


def adc_words(spec: EmulatedSpec, q: Vector) -> tuple[int, int, int]:
    """Return the readings of joint angles [rad]: rounded down, clamped at the ends, left-justified."""
    steps, shift = 1 << spec.adc_bits, 16 - spec.adc_bits
    a, b, c = (
        min(max(math.floor((angle - centre) / spec.adc_span * steps) + steps // 2, 0), steps - 1) << shift
        for angle, centre in zip(q, spec.adc_centres, strict=True)
    )
    return a, b, c

"""The constants of a material, as measured on a real object (Tables 1 and 2 of the paper)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .errors import LARGEST, DimpleError  # not from base: the servo process has no numpy
from .fills import FILLS
from .message import Message

_PER_UNIT = {"N/mm": 1e-3, "mm": 1e3, "kPa": 1e-3}  # in one SI unit
LEAST_PRESSURE, MOST_PRESSURE = -1e5, 1e6  # [Pa] nearly a vacuum, and more than any skin holds
TIPS = ("point", "punch", "sphere")
HERTZ = 1.5  # exponent of the depth in the force of a sphere on an elastic solid
NOTICEABLE_FORCE = (0.06, 0.08)  # lower and upper just-noticeable difference of a force, as a share of the force
STANDARD_GRAVITY = 9.80665  # [m/s2] of the kilogram-force, by definition
POUND = 0.45359237  # [kg] by definition


@dataclass(frozen=True, slots=True, kw_only=True)
class Indenter:
    """The tip that presses: shape "point" (a small flat punch), "punch" (flat) or "sphere", and radius [m]."""

    shape: str = "point"
    radius: float = 0.002

    def __post_init__(self) -> None:
        if self.shape not in TIPS:
            raise DimpleError("The tip must be one of {tips} (it is {shape}).", tips=tuple(TIPS), shape=self.shape)
        if not 0 < self.radius < math.inf:
            raise DimpleError(
                "The radius of the tip must be greater than 0 mm (it is {radius:g}).", radius=1e3 * self.radius
            )


POINT = Indenter()  # the paper: the sensor "touches at a point"
FINGERTIP = Indenter(shape="sphere", radius=0.010)


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Constants of one material.

    Args:
        K1: slope of the force over the depth up to the knee [N/m], Eq. (1). The force of a sphere on a solid follows a
            power law with the same constants.
        K2: slope beyond the knee [N/m].
        x0: depth of the knee [m].
        k: surface spring constant [N/m], Eq. (4).
        spread: how far a dent reaches beyond the fingertip [m]. 0: not at all, as on a bed of springs. None: as far as
            springs of constant k spread it.
        indenter: the tip that measured K1, K2 and x0.
        mass: of a body made of this material alone [kg]; or
        density: [kg/m3]; a sheet, which has no volume, counts as a twentieth of its size thick. Give exactly one of
            the two.
        damping_ratio: of springs and shape matching; 0 is undamped, 1 critically damped.
        friction: Coulomb coefficient of the skin against a fingertip and the ground.
        fill: a key of `fills.FILLS`.
        pressure: gauge pressure of the fill in the shape at rest [Pa]; K1, K2 and x0 hold without it.

    Raises:
        DimpleError: a constant is out of its range.
    """

    K1: float
    K2: float
    x0: float
    k: float
    spread: float | None = None
    indenter: Indenter = POINT
    mass: float | None = None
    density: float | None = None
    damping_ratio: float = 0.2
    friction: float = 0.5
    fill: str = "air"
    pressure: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("K1", "N/mm"), ("K2", "N/mm"), ("x0", "mm"), ("k", "N/mm")):
            _require(getattr(self, name) > 0, name, "{name} must be greater than 0 {unit}", getattr(self, name), unit)
        _require((self.spread or 0.0) >= 0, "The spread", "{name} must not be negative", self.spread or 0.0, "mm")
        if (self.mass is None) == (self.density is None):
            given = Message("both" if self.mass else "neither")
            raise DimpleError(
                "Set either a mass or a density (set now: {given}). Change it in Material > Dimple.", given=given
            )
        if self.mass is not None:
            _require(self.mass > 0, "The mass", "{name} must be greater than 0 {unit}", self.mass, "kg")
        if self.density is not None:
            _require(self.density > 0, "The density", "{name} must be greater than 0 {unit}", self.density, "kg/m³")
        _require(
            0 <= self.damping_ratio <= 2, "The damping ratio", "{name} must lie between 0 and 2", self.damping_ratio
        )
        _require(self.friction >= 0, "The friction", "{name} must not be negative", self.friction)
        if self.fill not in FILLS:
            raise DimpleError(
                "The fill must be one of {fills} (it is {fill}). Change it in Material > Dimple.",
                fills=tuple(map(Message, FILLS)), fill=self.fill
            )  # fmt: skip
        in_range = LEAST_PRESSURE <= self.pressure <= MOST_PRESSURE
        _require(
            in_range, "The pressure", "{name} must lie between -100 kPa and 1000 kPa", self.pressure, "kPa"
        )

    @property
    def power(self) -> float:
        """Return the exponent of the depth at the beginning of the law; see `law_power`."""
        return law_power(self.K1, self.K2, self.fill, self.indenter.shape)

    def law(self, depth: float) -> float:
        """Return the force [N] at a depth [m]."""
        return law_force(depth, self.K1, self.K2, self.x0, self.power)

    def slope(self, depth: float) -> float:
        """Return the slope of the law [N/m] at a depth [m]; at the knee, the slope before it."""
        return law_slope(depth, self.K1, self.K2, self.x0, self.power)


def law_power(K1: float, K2: float, fill: str, tip: str) -> float:
    """Return the exponent of the depth at the beginning of a law: 1, or up to Hertz's 1.5 for a sphere on a solid.

    It follows from K2 / K1 = p^2: two slopes with this ratio store as much energy as c x^p and its tangent.
    """
    bent = FILLS[fill].elastic and tip == "sphere" and K2 > K1 > 0
    return min(math.sqrt(K2 / K1), HERTZ) if bent else 1.0


def law_force(depth: float, K1: float, K2: float, x0: float, power: float = 1.0) -> float:
    """Return the force [N] of a law at a depth [m]: K(x), two-piece linear. Source: Eq. (1).

    With an exponent p above 1 the force is c x^p up to (1 + 1/p) x0 and goes on along the tangent there, whose slope is
    p^2 K1. If K2 is larger than that, the difference is added from x0 on, as a knee.
    """
    x = max(depth, 0.0)
    if power == 1:
        return K1 * min(x, x0) + K2 * max(x - x0, 0.0)
    straight, slope, beyond = (1 + 1 / power) * x0, power**2 * K1, max(x - x0, 0.0)
    more = (K2 - slope) * beyond
    if x < straight:
        return power * K1 * straight * (x / straight) ** power + more
    return K1 * x0 + slope * beyond + more


def law_slope(depth: float, K1: float, K2: float, x0: float, power: float = 1.0) -> float:
    """Return the slope of a law [N/m] at a depth [m]; at the knee, the slope before it.

    Source: the derivative of `law_force`.
    """
    if power == 1:
        return K1 if depth <= x0 else K2
    steepest, straight = power**2 * K1, (1 + 1 / power) * x0
    begun = min(max(depth / straight, 0.0), 1.0) ** (power - 1)
    return steepest * begun + (K2 - steepest if depth > x0 else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset:
    """An object with known constants.

    name: identifier.
    label: what the interface shows.
    material: its constants.
    size: length of its edge [m].
    provenance: the source of the numbers.
    sway, sway_hz: amount of sway, 0 to 1, and frequency of its first mode [Hz]; 0: follows from the constants.
    """

    name: str
    label: str
    material: Material
    size: float
    provenance: str
    sway: float = 0.0
    sway_hz: float = 0.0


def _require(holds: bool, name: str, rule: str, value: float, unit: str = "") -> None:
    """Raise an error if a rule does not hold; it shows the value, given in SI units, in the unit of the panel."""
    given = f"{value * _PER_UNIT.get(unit, 1):.6g} {unit}".rstrip()
    if abs(value) > LARGEST:
        raise DimpleError(
            "{name} is out of range (it is {given}). Change it in Material > Dimple.", name=Message(name), given=given
        )
    if not holds:
        said = Message(rule, name=Message(name), unit=unit)
        raise DimpleError("{rule} (it is {given}). Change it in Material > Dimple.", rule=said, given=given)


# for a body without a material, and for a new one in the panel: the law of the vinyl cube, as heavy as foam. The spread
# is not measured: little wider than a fingertip of 10 mm, for a body of 165 mm; Make Soft fits it to other sizes
DEFAULT_MATERIAL = Material(K1=610, K2=7230, x0=0.0163, k=9_200, spread=0.012, density=100, indenter=FINGERTIP)

"""Everyday objects as presets: from rules of sport, data sheets, trade standards and papers; some are made up.

Each states the source and the range of its numbers; we measured none of them. A plate flattens a ball full of air over
a circle of radius sqrt(2 R x), on which the gauge pressure p acts: F = 2 pi R p x. For incompressible matter such as
rubber and flesh the force of a flat punch of radius a is F = 2 a E x / (1 - 1/4), that of a ball of radius R is
F = 4/3 E R^(1/2) x^(3/2) / (1 - 1/4).
"""

from __future__ import annotations

import math
from dataclasses import replace

from .material import FINGERTIP, HERTZ, POUND, PRESETS, STANDARD_GRAVITY, Indenter, Material, Preset
from .other_tip import softness

MADE_UP = "Made up: no measurement stands behind it, only the feel of such an object in the hand"
_KGF_PER_CM2 = 1e4 * STANDARD_GRAVITY  # [Pa]
_POUND_FORCE = POUND * STANDARD_GRAVITY  # [N]
_PSI = _POUND_FORCE / 0.0254**2  # [Pa]
_PUNCH = 0.005  # [m] radius of the flat punch on rubber
_IFD = 0.1013  # [m] radius of the plate of 50 square inches in the foam standard
_WOBBLE = 4.0  # [Hz] made up to look like flesh: the modulus alone gives a far slower swing
_PLUNGER = 0.00635  # [m] radius of the plunger in the Bloom test


def _short(value: float) -> float:
    """Return a constant rounded to the digits that the panel shows."""
    return float(f"{value:.4g}")


def _ball(name: str, label: str, rule: str, radius: float, pressure: tuple[float, float], mass: float) -> Preset:
    """Return an inflated ball with a radius [m] and a range of gauge pressure [Pa]."""
    low, high = (2 * math.pi * radius * p for p in pressure)
    knee = 0.1 * radius
    material = Material(
        K1=_short((low + high) / 2), K2=_short((low + high) / 2), x0=_short(knee), k=20_000,
        spread=_short(0.3 * radius), mass=mass,
        indenter=Indenter(shape="punch", radius=round(math.sqrt(2 * radius * knee), 4)),
    )  # fmt: skip
    source = f"{rule}; K = 2 pi R p, from {low / 1e3:.3g} to {high / 1e3:.3g} N/mm, pressed by a plate"
    return Preset(name=name, label=label, material=material, size=2 * radius, provenance=source)


def _rubber(name: str, label: str, brand: str, psi: float, density: float) -> Preset:
    """Return a block of silicone of 50 mm, from its stress at 100 % strain [psi] and its density [kg/m3]."""
    stiffness = _short(2 * _PUNCH * psi * _PSI / 0.75)
    material = Material(
        K1=stiffness, K2=stiffness, x0=0.01, k=2_000, spread=0.01, density=density, fill="solid", damping_ratio=0.3,
        indenter=Indenter(shape="punch", radius=_PUNCH),
    )  # fmt: skip
    source = (
        f"Data sheet of Smooth-On, {brand}: stress at 100 % strain {psi:g} psi; K = 8 a E / 3 for a flat punch of 5 "
        f"mm, {0.8 * stiffness / 1e3:.2g} to {1.2 * stiffness / 1e3:.2g} N/mm if E may be 20 % off (our guess)"
    )
    return Preset(name=name, label=label, material=material, size=0.05, provenance=source, sway=1.0)


def _foam(name: str, label: str, pounds: tuple[float, float], kind: str) -> Preset:
    """Return a block of foam 100 mm thick, from the force [lbf] that compresses it by a quarter."""
    low, high = (force * _POUND_FORCE / 0.025 for force in pounds)
    stiffness = _short((low + high) / 2)
    material = Material(
        K1=stiffness, K2=_short(stiffness * 25 / 40), x0=0.025, k=3_000, spread=0.02, density=29, fill="none",
        damping_ratio=0.6, indenter=Indenter(shape="punch", radius=_IFD),
    )  # fmt: skip
    source = (
        f"Indentation force deflection of {kind} (ASTM D3574, plate of 50 square inches): {pounds[0]:g} to "
        f"{pounds[1]:g} lbf at 25 % of 100 mm, so {low / 1e3:.3g} to {high / 1e3:.3g} N/mm; support factor taken as 2"
    )
    return Preset(name=name, label=label, material=material, size=0.38, provenance=source)


def _flesh(name: str, label: str, kpa: tuple[float, float], what: str, density: float) -> Preset:
    """Return a tissue with the law that a fingertip would measure, from Young's modulus and its deviation [kPa]."""
    knee = 0.015
    share = math.sqrt(FINGERTIP.radius * (1 + 1 / HERTZ) * knee) / HERTZ * 4e3 / 3 / 0.75
    material = Material(
        K1=_short(share * kpa[0]), K2=_short(HERTZ**2 * _short(share * kpa[0])), x0=knee, k=1_000, spread=0.015,
        density=density, fill="solid", damping_ratio=0.6, indenter=FINGERTIP,
    )  # fmt: skip
    source = (
        f"Isogai and others 2022, J. Phys. Ther. Sci. 34, 777: {what}, {kpa[0]:g} ± {kpa[1]:g} kPa; "
        f"Hertz with a ball of 10 mm, so {share * (kpa[0] - kpa[1]) / 1e3:.2g} to "
        f"{share * (kpa[0] + kpa[1]) / 1e3:.2g} N/mm up to the knee; its sway of {_WOBBLE:g} Hz is made up"
    )
    return Preset(name=name, label=label, material=material, size=0.15, provenance=source, sway=1.0, sway_hz=_WOBBLE)


def _jelly(name: str, label: str, bloom: tuple[float, float]) -> Preset:
    """Return a block of gelatin of 100 mm, from the range of its Bloom strength [g]."""
    low, high = (grams * 1e-3 * STANDARD_GRAVITY / 0.004 for grams in bloom)
    stiffness = _short((low + high) / 2)
    material = Material(
        K1=stiffness, K2=stiffness, x0=0.01, k=300, spread=0.012, density=1020, fill="solid", damping_ratio=0.1,
        friction=0.2, indenter=Indenter(shape="punch", radius=_PLUNGER),
    )  # fmt: skip
    source = (
        f"Bloom test of gelatin (6.67 % in water, 10 °C, a flat plunger of 12.7 mm, 4 mm deep): {bloom[0]:g} to "
        f"{bloom[1]:g} g, so {low / 1e3:.3g} to {high / 1e3:.3g} N/mm; a dessert takes less gelatin"
    )
    return Preset(name=name, label=label, material=material, size=0.1, provenance=source, sway=1.0)


def _made_up(name: str, label: str, material: Material, size: float) -> Preset:
    return Preset(name=name, label=label, material=material, size=size, provenance=MADE_UP)


EVERYDAY = (
    Preset(
        name="tennis_ball", label="Tennis ball",
        material=Material(
            K1=12_300, K2=12_300, x0=0.0065, k=20_000, spread=0.01, mass=0.0577,
            indenter=Indenter(shape="punch", radius=0.0146),
        ),
        size=0.067,
        provenance="ITF Rules of Tennis, Appendix I, type 2: 5.6 to 7.4 mm under 80.07 N between plates, so 10.8 to "
        "14.3 N/mm; 56.0 to 59.4 g",
    ),
    Preset(
        name="squash_ball", label="Squash ball",
        material=Material(
            K1=3_200, K2=3_200, x0=0.008, k=5_000, spread=0.008, mass=0.024, damping_ratio=0.5,
            indenter=Indenter(shape="punch", radius=0.0126),
        ),
        size=0.04,
        provenance=f"{MADE_UP}; but the rules for a double-yellow-dot ball say 39.5 to 40.5 mm across and 23 to 25 g",
    ),
    _ball(
        "volleyball", "Volleyball", "FIVB rule 3: 65 to 67 cm round, 0.30 to 0.325 kgf/cm2, 260 to 280 g",
        0.105, (0.30 * _KGF_PER_CM2, 0.325 * _KGF_PER_CM2), 0.27,
    ),
    _ball(
        "beach_volleyball", "Beach volleyball", "FIVB rules: 66 to 68 cm round, 0.175 to 0.225 kgf/cm2, 260 to 280 g",
        0.1066, (0.175 * _KGF_PER_CM2, 0.225 * _KGF_PER_CM2), 0.27,
    ),
    _ball(
        "football", "Football", "Laws of the Game, law 2: 68 to 70 cm round, 0.6 to 1.1 atmospheres, 410 to 450 g",
        0.11, (0.6 * 101_325, 1.1 * 101_325), 0.43,
    ),
    _rubber("ecoflex_00_10", "Silicone 00-10", "Ecoflex 00-10", 8, 1040),
    _rubber("ecoflex_00_30", "Silicone 00-30", "Ecoflex 00-30", 10, 1070),
    _rubber("dragon_skin_10", "Silicone 10 A", "Dragon Skin 10", 22, 1070),
    _foam("sofa_foam", "Sofa foam", (25, 30), "sofa seats"),
    _foam(
        "chair_foam", "Chair foam", (35, 45), "medium firm to very firm foam, assumed here for chairs"
    ),
    _flesh("skin", "Skin and fat", (26.1, 19.0), "subcutaneous tissue of the buttocks under 1 N", 1000),
    _flesh("flesh", "Flesh", (62.2, 10.3), "relaxed muscle of the buttocks under 5 N", 1060),
    _jelly("jelly", "Jelly", (175, 225)),
    _made_up(
        "dough", "Bread dough",
        Material(
            K1=220, K2=330, x0=0.015, k=300, spread=0.012, density=1150, fill="solid", indenter=FINGERTIP,
            damping_ratio=2.0, friction=0.9,
        ), 0.2,
    ),
    _made_up(
        "party_balloon", "Party balloon",
        Material(K1=300, K2=900, x0=0.06, k=500, spread=0.05, mass=0.003, indenter=FINGERTIP, damping_ratio=0.4), 0.28,
    ),
    _made_up(
        "kitchen_sponge", "Kitchen sponge",
        Material(K1=250, K2=2_000, x0=0.018, k=500, spread=0.008, density=30, fill="none", indenter=FINGERTIP), 0.11,
    ),
    _made_up(
        "pillow", "Pillow",
        Material(
            K1=120, K2=600, x0=0.07, k=500, spread=0.06, density=25, fill="none", indenter=FINGERTIP, damping_ratio=0.8
        ), 0.6,
    ),
    _made_up(
        "marshmallow", "Marshmallow",
        Material(
            K1=400, K2=2_500, x0=0.012, k=300, spread=0.005, density=350, fill="none", indenter=FINGERTIP,
            damping_ratio=1.0,
        ), 0.03,
    ),
    _made_up(
        "hot_water_bottle", "Hot-water bottle",
        Material(K1=350, K2=3_000, x0=0.025, k=4_000, spread=0.03, density=1000, fill="liquid", indenter=FINGERTIP),
        0.3,
    ),
    _made_up(
        "stress_ball", "Stress ball",
        Material(
            K1=900, K2=5_000, x0=0.02, k=1_500, spread=0.012, density=250, fill="none", indenter=FINGERTIP,
            damping_ratio=0.6,
        ), 0.065,
    ),
)  # fmt: skip

# all presets, the softest first
OBJECTS = tuple(sorted((*PRESETS, *EVERYDAY), key=lambda preset: -softness(preset.material)))


def found(material: Material) -> Preset | None:
    """Return the preset with the constants of a material, whatever its mass and spread; None if there is none."""
    mass, density, spread = material.mass, material.density, material.spread
    for each in OBJECTS:
        if replace(each.material, mass=mass, density=density, spread=spread) == material:
            return each
    return None

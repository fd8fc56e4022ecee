"""Known objects as presets: the cubes of the paper, whose names begin with object_, and everyday objects.

Everyday objects follow from rules of sport, data sheets, trade standards and papers, and some are made up; each states
the source and the range of its numbers, and we measured none of them. Of the cubes we chose the masses: a nylon pouch
and a vinyl bag weigh little, and the water in a 165 mm cube weighs 4.5 kg. A plate flattens a ball full of air over
a circle of radius sqrt(2 R x), on which the gauge pressure p acts: F = 2 pi R p x. For incompressible matter such as
rubber and flesh the force of a flat punch of radius a is F = 2 a E x / (1 - 1/4), that of a ball of radius R is
F = 4/3 E R^(1/2) x^(3/2) / (1 - 1/4). tests/unit/test_everyday_presets.py repeats these calculations.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from .material import Indenter, Material, Preset
from .other_tip import softness


def _preset(material: dict[str, Any], **others: Any) -> Preset:
    """Return a preset from its entry in the file, in SI units."""
    return Preset(material=Material(**material | {"indenter": Indenter(**material["indenter"])}), **others)


_ENTRIES = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
# the softest first
OBJECTS = tuple(sorted((_preset(**each) for each in _ENTRIES), key=lambda preset: -softness(preset.material)))


def found(material: Material) -> Preset | None:
    """Return the preset with the constants of a material, whatever its mass and spread; None if there is none."""
    mass, density, spread = material.mass, material.density, material.spread
    for each in OBJECTS:
        if replace(each.material, mass=mass, density=density, spread=spread) == material:
            return each
    return None

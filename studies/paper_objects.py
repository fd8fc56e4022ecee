"""The presets of the three objects of the paper, in its order."""

from __future__ import annotations

from core.everyday_presets import OBJECTS

PRESETS = tuple(sorted((each for each in OBJECTS if each.name.startswith("object_")), key=lambda each: each.name))

"""Measured curves of the paper's objects, made again from the constants in Table 2: the points were not published."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from core.base import Floats
from core.calibration.virtual_press import write_press
from core.material import PRESETS, Preset

NOISE = 0.01  # of full scale: of a strain gauge on a cantilever, as the paper's
ROWS = 300
# how deep [m] each object is pressed; the paper does not say. Object 1 to nine tenths of its height.
DEEPEST = {"object_1_nylon_air": 0.045, "object_2_vinyl_air": 0.022, "object_3_vinyl_water": 0.020}


def reconstruct(preset: Preset, *, rows: int = ROWS, noise: float = NOISE, seed: int = 0) -> tuple[Floats, Floats]:
    """Return depth (n,) [m] and force (n,) [N] of a press of one of Table 2's objects.

    Args:
        noise: standard deviation as a share of full scale.
    """
    depth = np.linspace(0, DEEPEST[preset.name], rows)
    force = np.array([preset.material.law(x) for x in depth])
    return depth, force + noise * force.max() * np.random.default_rng(seed).normal(size=rows)


def write_samples(folder: str | Path) -> list[Path]:
    """Write the three curves into a folder and return their paths."""
    paths = []
    for number, preset in enumerate(PRESETS, 1):
        path = Path(folder) / f"{preset.name}.csv"
        depth, force = reconstruct(preset, seed=number)
        about = (
            f"Object {number} of Table 1: {preset.label}",
            "RECONSTRUCTED from Table 2, not measured: K(x) of Eq. (1) with 1 % of full scale of noise added",
            "Source of the constants: Sakama, Tanaka and Araki, Haptic Rendering for Virtual Object in Cyber Space",
        )
        write_press(path, depth, force, about=about)
        paths.append(path)
    return paths

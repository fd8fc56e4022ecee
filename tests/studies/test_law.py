"""`law`: a mesh is pressed where its tip can reach, and dragged over."""

import json
from pathlib import Path

import numpy as np
import pytest

from core.body.model import build_model
from core.mesh.surface import base_vertices
from studies.__main__ import main
from studies.law.press_and_drag import REACH, SHARES, SPEEDS, Surface, places
from studies.meshes.primitives import joined, moved
from studies.meshes.simple import box, sized
from studies.paper_objects import PRESETS


def test_places_are_reached_by_the_tip_and_clear_of_pins() -> None:
    """Of two cubes with a gap of 20 mm between them, a fingertip of 12 mm reaches no side in the gap."""
    mesh, tip = sized(*joined(moved(box(2), -1.1, 0, 0), moved(box(2), 1.1, 0, 0))), 0.012
    model = build_model(mesh, [PRESETS[1].material], pinned=base_vertices(mesh))
    found, surface = list(places(model, tip, 60, np.random.default_rng(0))), Surface(mesh)
    assert len(found) == 60
    base = mesh.rest_positions[:, 2].min()
    for place in found:
        centre = place.at + tip * place.outward
        assert np.linalg.norm(surface.nearest(centre, tip) - centre) >= tip - REACH
        assert place.at[2] > base + tip or place.outward[2] > 0.9
        assert place.thickness == pytest.approx(mesh.rest_positions[:, 2].max() - base, abs=1e-5)
        assert not (abs(place.at[0]) < 0.01 and abs(place.outward[0]) > 0.9), "it is in the gap"


def test_it_goes_into_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "law.json"
    words = ["--places", "1", "--tips", "5,10", "--drag", "1", "--json", str(out)]
    assert main(["law", "--mesh", "ico-sphere-3", *words]) == 0
    found = json.loads(out.read_text())
    assert found["vertices"] == 162 and found["measured_tip_mm"] == 10 and found["substeps"] > 0
    assert len(found["rows"]) == 2 * 2 * len(SHARES) and len(found["drags"]) == 2 * 2 * len(SPEEDS)
    assert {row["count"] for row in found["rows"]} == {1}
    assert "over the surface, 33 mm/s" in capsys.readouterr().out
    assert main(["law", "--mesh", "no-such-thing"]) == 2

"""Draw the charts of the studies. The numbers come from studies; drawing and the independent solver stay here."""

from pathlib import Path

KEPT = Path(__file__).resolve().parents[2] / "tests" / "studies" / "charts"  # the charts that the documentation shows

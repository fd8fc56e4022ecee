"""What does precision cost, and where do time-stepping methods fail? The charts that docs/accuracy.md shows."""

from pathlib import Path

KEPT = Path(__file__).resolve().parents[2] / "tests" / "studies" / "charts"  # their tables and pictures

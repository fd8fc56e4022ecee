"""Rows copied from a spreadsheet are read with or without units; what cannot be read is said."""

import pytest

from core.calibration.reader import pairs
from core.errors import DimpleError

ROWS = [(0.0, 0.0), (1.0, 20.0), (2.0, 43.0)]


@pytest.mark.parametrize(
    "text",
    [
        "depth\tgrams\n0\t0\n1\t20\n2\t43", "0 mm\t0 g\n1 mm\t20 g\n2 mm\t43 g", "0;0\n1;20\n2;43",
        "0,0;0\n1,0;20\n2,0;43",
    ],
)  # fmt: skip
def test_copied_rows_are_read(text: str) -> None:
    assert pairs(text) == ROWS


@pytest.mark.parametrize("text", ["", "soft\tcushion\nred\tblue\nold\tnew", "1.000\t20\n2.000\t30\n3.000\t44"])
def test_what_is_no_table_or_ambiguous_is_refused_with_a_sentence(text: str) -> None:
    with pytest.raises(DimpleError):
        pairs(text)

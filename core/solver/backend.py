"""Which code steps a body: the native core where there is one, else numpy, its twin."""

from __future__ import annotations

from typing import Protocol

from .. import native
from ..base import DimpleError, Floats
from ..body.model import Model, State
from . import semi_implicit
from .path import FingerPath


class Run(Protocol):
    """Advance a state in place along a path and return the impulses (k, 3) [N s] on the fingertips."""

    def __call__(self, model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats: ...


def choose_backend(wanted: str = "auto") -> tuple[str, str, Run]:
    """Return the name of what steps, why it is not the native core, and its stepper.

    Args:
        wanted: "auto", "native" (single precision), "native64" or "numpy".

    Raises:
        DimpleError: it does not exist, or cannot run here and was asked for by name.
    """
    if wanted not in ("auto", "native", "native64", "numpy"):
        raise DimpleError(f"There is no backend {wanted}: take auto, native, native64 or numpy.")
    note = "" if wanted == "numpy" else native.why_not()
    if note and wanted != "auto":
        raise DimpleError(note)
    if wanted == "numpy" or note:
        return "numpy", note, semi_implicit.run
    return ("native64", "", native.run64) if wanted == "native64" else ("native", "", native.run)

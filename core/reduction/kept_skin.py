"""A fine surface for the eye: carried again only where its proxy has moved by what can be seen.

Of each vertex of the proxy the motion is kept that last carried what follows it, until it is off by more than SLACK.
The surface is where the kept motions carry it: as smooth as ever, with no step between what is carried again and what
is not, and never farther off than SLACK allows, however long the motion lasts.

Vertices whose motion is slow take turns of 2, 4, 8 or 16 calls together: what follows a dozen of them would else be
carried at nearly every call.
"""

from __future__ import annotations

import numpy as np

from .. import native
from ..base import Floats, Singles, sums_at
from ..native.carry import Binding

SLACK = 2e-3  # of the edges of the proxy: a slope is off by 0.1 degrees, less than one of 256 greys
TURN = 16  # calls; what has not moved for so many is put where it is to the bit


class KeptSkin:
    """A fine surface that a proxy carries, to be looked at.

    positions: (n, 3) where it is [m].
    exact: it was carried to the bit at the last call.
    """

    def __init__(self, binding: Binding) -> None:
        m = len(binding.coarse_rest)
        self.positions: Singles = np.ascontiguousarray(binding.rest)
        self.exact = True
        self._binding, self._calls, self._quiet = binding, 0, 0
        self._lengths = edge_lengths(binding)
        self._motions, self._before = np.zeros((m, 12), np.float32), np.zeros((m, 12), np.float32)

    def follow(self, coarse: Floats, *, exact: bool = False) -> int:
        """Go where coarse positions (3, m) [m] carry it; return how many eights of vertices were carried again.

        Args:
            exact: to the bit, not only as near as can be seen.
        """
        self._calls += 1
        self._quiet += 1
        self.exact = exact or self._quiet == TURN
        slack, ahead = 0.0 if self.exact else SLACK, min(self._calls & -self._calls, TURN)
        carried = native.carry_moved(
            native.library(), self._binding, coarse, self._lengths, slack, ahead, self._motions, self._before,
            self.positions,
        )  # fmt: skip
        if carried and not self.exact:
            self._quiet = 0
        return carried


def edge_lengths(binding: Binding) -> Floats:
    """Return the mean length (m,) [m] of the edges round each vertex of a coarse mesh."""
    (i, j), x, m = binding.arms.T, binding.coarse_rest, len(binding.coarse_rest)
    lengths = np.sqrt(((x[j] - x[i]) ** 2).sum(axis=1))
    return sums_at(i, lengths, m) / np.maximum(np.bincount(i, minlength=m), 1)

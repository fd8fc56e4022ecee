"""Colours: what shares a colour shares nothing else, so it may be moved at once whatever the order."""

from __future__ import annotations

import numpy as np

from core.base import Ints


def colours(items: Ints, uses: Ints) -> list[Ints]:
    """Split items so that no two of one colour use the same thing.

    A colour takes what it can of the items left: again and again each item that drew a higher number than all others
    that want one of its things (Luby). Edges use their two vertices; vertices use their edges.

    Args:
        items, uses: (r,) item items[r] uses thing uses[r].  Items are counted from 0; one that uses nothing has no row.

    Returns:
        the items of each colour, sorted; every item that has a row, once.
    """
    count = int(items.max(initial=-1)) + 1
    draw = np.random.default_rng(0).permutation(count)  # the same at every start
    left, found = np.bincount(items, minlength=count) > 0, []
    while left.any():
        candidate, chosen = left.copy(), np.zeros(count, bool)
        while candidate.any():
            rows = candidate[items]
            at, what = items[rows], uses[rows]
            highest = np.full(int(uses.max()) + 1, -1)
            np.maximum.at(highest, what, draw[at])
            beaten = np.bincount(at[draw[at] < highest[what]], minlength=count) > 0
            winners = candidate & ~beaten
            chosen |= winners
            taken = np.zeros(len(highest), bool)
            taken[what[winners[at]]] = True
            blocked = np.bincount(at[taken[what]], minlength=count) > 0
            candidate &= ~blocked
        found.append(np.flatnonzero(chosen))
        left &= ~chosen
    return found

"""Graph colouring: items of one colour share nothing, so they may be moved at once, in any order."""

from __future__ import annotations

import numpy as np

from core.base import Ints


def colours(items: Ints, uses: Ints) -> list[Ints]:
    """Split items into colours so that no two items of a colour use the same resource.

    Springs use their two vertices; vertices use their springs. Each colour is a maximal independent set of the items
    left: again and again it takes every item whose random number is higher than those of all items that share a
    resource with it.

    Args:
        items: (r,) item of each use, counted from 0; an item that uses nothing has no row.
        uses: (r,) the resource it uses.

    Returns:
        the items of each colour, sorted; every item that has a row, once.

    Source: Luby 1986.
    """
    count = int(items.max(initial=-1)) + 1
    number = np.random.default_rng(0).permutation(count)  # the same in every run
    left, found = np.bincount(items, minlength=count) > 0, []
    while left.any():
        candidate, chosen = left.copy(), np.zeros(count, bool)
        while candidate.any():
            rows = candidate[items]
            item, resource = items[rows], uses[rows]
            highest = np.full(int(uses.max()) + 1, -1)
            np.maximum.at(highest, resource, number[item])
            beaten = np.bincount(item[number[item] < highest[resource]], minlength=count) > 0
            winners = candidate & ~beaten
            chosen |= winners
            taken = np.zeros(len(highest), bool)
            taken[resource[winners[item]]] = True
            blocked = np.bincount(item[taken[resource]], minlength=count) > 0
            candidate &= ~blocked
        found.append(np.flatnonzero(chosen))
        left &= ~chosen
    return found

"""Presses as machines record them where the press is not simple: preloads, adhesion, dead travel, tears and pages.

Every kind makes a file of a random two-slope object by seed, in mm and N, with the constants that are behind it.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

HEAD = "Depth (mm),Force (N)"


class Specimen(NamedTuple):
    """A file and the truth behind it, K1 and K2 [N/mm], x0 [mm]; `touch` [mm] in the file's own depth."""

    content: bytes
    K1: float
    K2: float
    x0: float
    touch: float = 0.0


class Press(NamedTuple):
    """A press to be written down: depth from the touch [mm], force [N], and what is behind it."""

    depth: np.ndarray
    force: np.ndarray
    K1: float
    K2: float
    x0: float

    @property
    def full(self) -> float:
        return float(self.law(self.depth).max())

    def law(self, depth) -> np.ndarray:
        inside = np.maximum(depth, 0)
        return self.K1 * np.minimum(inside, self.x0) + self.K2 * np.maximum(inside - self.x0, 0)


def press(rng: random.Random, *, approach=0.0, start=0.0, rows=None, stiff=None, noise=None) -> Press:
    """Return a press from `approach` before the touch, or from `start` below it, as shares of the depth."""
    stiff = rng.random() < 0.3 if stiff is None else stiff
    K1 = 10 ** (rng.uniform(2.7, 3.9) if stiff else rng.uniform(-0.7, 0.7))
    x0 = rng.uniform(0.1, 1.0) if stiff else rng.uniform(4.0, 25.0)
    K2, deepest = K1 * rng.uniform(1.8, 12.0), x0 * rng.uniform(1.3, 1.7)
    rows = rows or rng.choice([80, 150, 300, 900])
    depth = np.linspace((start - approach) * deepest, deepest, rows)
    bare = Press(depth, depth, K1, K2, x0)
    noise = rng.choice([0.0005, 0.002, 0.005, 0.01]) if noise is None else noise
    wobble = noise * bare.full * np.random.default_rng(rng.randrange(10**6)).normal(size=rows)
    return bare._replace(force=bare.law(depth) + wobble)


def number(value: float) -> str:
    return f"{value:.6g}"


def table(depth, force) -> str:
    return "".join(f"{d:.6f},{f:.6f}\n" for d, f in zip(depth, force, strict=True))


def written(p: Press, depth=None, force=None, *, head=HEAD, touch=0.0) -> Specimen:
    text = f"{head}\n" + table(p.depth if depth is None else depth, p.force if force is None else force)
    return Specimen(text.encode(), p.K1, p.K2, p.x0, touch)


# the beginning of the press


def preload(rng: random.Random) -> Specimen:
    """Zero the depth at the preload, as a tensile machine does; the force is true."""
    p = press(rng, start=rng.uniform(0.05, 0.3))
    return written(p, p.depth - p.depth[0], touch=-p.depth[0])


def slight_preload(rng: random.Random) -> Specimen:
    """Zero the depth at a preload that is hardly a press yet."""
    p = press(rng, start=rng.uniform(0.002, 0.05))
    return written(p, p.depth - p.depth[0], touch=-p.depth[0])


def begun(rng: random.Random) -> Specimen:
    """Begin in the middle of the press, at a depth the machine counts from elsewhere; some of a bent curve."""
    p = press(rng, start=rng.uniform(0.3, 0.85), noise=0.005)
    zero, power = rng.choice([0.0, 20.0, -7.0]), rng.choice([None, None, 1.5, 0.6])
    if power is None:
        return written(p, p.depth - p.depth[0] + zero, touch=zero - p.depth[0])
    bent = p.full * (p.depth / p.depth[-1]) ** power + p.force - p.law(p.depth)
    return Specimen(written(p, p.depth - p.depth[0] + zero, bent).content, *[np.nan] * 3, zero - p.depth[0])


def preload_doubled(rng: random.Random) -> Specimen:
    """Record the preload in several rows before the crosshead moves."""
    p, times = press(rng, start=rng.uniform(0.05, 0.3)), rng.choice([2, 3, 6, 20])
    wobble = 0.002 * p.full * np.random.default_rng(rng.randrange(10**6)).normal(size=times)
    depth = np.concatenate([np.zeros(times), p.depth - p.depth[0]])
    return written(p, depth, np.concatenate([p.law(p.depth[:1]) + wobble, p.force]), touch=-p.depth[0])


def preload_rising(rng: random.Random) -> Specimen:
    """Record the force rising to the preload while the depth stays at zero."""
    p = press(rng, start=rng.uniform(0.05, 0.3))
    rise = np.linspace(0, 1, rng.choice([4, 10, 30]), endpoint=False) * float(p.law(p.depth[:1])[0])
    depth = np.concatenate([np.zeros(len(rise)), p.depth - p.depth[0]])
    return written(p, depth, np.concatenate([rise, p.force]), touch=-p.depth[0])


def preload_of_a_bent_curve(rng: random.Random) -> Specimen:
    """Zero the depth at the preload of an object whose curve bends all the way: no two slopes are true."""
    p = press(rng)
    bent = p.full * (p.depth / p.depth[-1]) ** rng.choice([1.5, 2.0, 3.0])
    at = int(rng.uniform(0.3, 0.45) * len(bent))
    return Specimen(written(p, p.depth[at:] - p.depth[at], bent[at:]).content, *[np.nan] * 3, -p.depth[at])


def dead_travel(rng: random.Random) -> Specimen:
    """Begin a little before the touch and call that zero."""
    p = press(rng, approach=10 ** rng.uniform(-2.3, -0.9), stiff=rng.random() < 0.8)
    return written(p, p.depth - p.depth[0], touch=-p.depth[0])


def adhesion(rng: random.Random) -> Specimen:
    """Let the object jump to the tip before they touch."""
    p = press(rng, approach=rng.uniform(0.1, 0.4))
    width = rng.uniform(0.02, 0.08) * p.depth[-1]
    pull = rng.uniform(0.03, 0.3) * p.full * np.exp(-((p.depth + 1.5 * width) ** 2) / width**2) * (p.depth < 0)
    zero = rng.choice([0.0, 30.0])
    return written(p, p.depth + zero, p.force - pull, touch=zero)


def approach(rng: random.Random) -> Specimen:
    """Travel before the touch, and leave the load cell untared or not."""
    p = press(rng, approach=rng.uniform(0.1, 0.5))
    zero, tare = rng.choice([0.0, 12.0]), rng.choice([0.0, 0.05, -0.05]) * p.full
    return written(p, p.depth + zero, p.force + tare, touch=zero)


def short_travel(rng: random.Random) -> Specimen:
    """Press a body of a smooth curve by 3.9 mm."""
    p = press(rng, approach=rng.uniform(0.0, 0.2))
    depth = p.depth * 3.9 / np.ptp(p.depth)
    wobble = 0.005 * p.full * np.random.default_rng(rng.randrange(10**6)).normal(size=len(depth))
    bent = p.full * (np.maximum(depth, 0) / 3.9) ** rng.choice([1.0, 1.3, 1.5, 2.0]) + wobble
    return Specimen(written(p, depth - depth[0], bent).content, *[np.nan] * 3, -depth[0])


def few_rows(rng: random.Random) -> Specimen:
    """Read eight to ten points by hand, the 0, 0 not among them."""
    p = press(rng, rows=1000, noise=0.0)
    at = np.linspace(0, 999, rng.choice([8, 9, 10]) + 1).astype(int)[1:]
    return written(p, p.depth[at], p.force[at])


# its end, its order and its sign


def torn(rng: random.Random) -> Specimen:
    """Tear the specimen at the end, and go on."""
    p = press(rng, approach=rng.choice([0.0, 0.1]))
    rest, rows = rng.uniform(0.0, 0.3) * p.full, int(rng.uniform(0.05, 0.6) * len(p.depth))
    wobble = 0.003 * p.full * np.random.default_rng(rng.randrange(10**6)).normal(size=rows)
    further = p.depth[-1] + (p.depth[1] - p.depth[0]) * np.arange(1, rows + 1)
    depth, force = np.concatenate([p.depth, further]), np.concatenate([p.force, rest + wobble])
    signs = rng.choice([1, -1]), rng.choice([1, -1])
    zero = rng.choice([0.0, 0.0, 40.0])
    return written(p, signs[0] * depth + zero, signs[1] * force, touch=zero)


def torn_at_last(rng: random.Random) -> Specimen:
    """Press twice, and tear the specimen the second time."""
    p = press(rng, rows=300)
    rest = int(rng.uniform(0.05, 0.4) * len(p.depth))
    further = p.depth[-1] + (p.depth[1] - p.depth[0]) * np.arange(1, rest + 1)
    depth = np.concatenate([p.depth, p.depth[::-1], p.depth, further])
    return written(p, depth, np.concatenate([p.force, p.force[::-1], p.force, 0.1 * p.full * np.ones(rest)]))


def going_negative(rng: random.Random) -> Specimen:
    """Write compression negative, with the way back."""
    p = press(rng, approach=rng.choice([0.0, 0.2]))
    back = rng.random() < 0.5
    depth = np.concatenate([p.depth, p.depth[::-1]]) if back else p.depth
    force = np.concatenate([p.force, 0.8 * p.force[::-1]]) if back else p.force
    return written(p, -depth, rng.choice([1, -1]) * force)


def reversed_rows(rng: random.Random) -> Specimen:
    """Write the last row first, with a clock or a number beside it or without."""
    p = press(rng, approach=rng.choice([0.0, 0.1]))
    head, first = rng.choice([(HEAD, None), (f"Time (s),{HEAD}", 0.1), (f"No.,{HEAD}", 1)])
    rows = [
        (f"{first * i:.4g}," if first else "") + f"{d:.6f},{f:.6f}"
        for i, (d, f) in enumerate(zip(p.depth, p.force, strict=True), 1)
    ]
    return Specimen("\n".join([head, *rows[::-1]]).encode() + b"\n", p.K1, p.K2, p.x0)


def quick_touch(rng: random.Random) -> Specimen:
    """Touch quickly in a dozen rows, come back, then press slowly."""
    p = press(rng, rows=900)
    deep, quick = p.depth[-1] * rng.uniform(0.55, 1.0), rng.choice([9, 11, 15])
    there = np.linspace(0, deep, quick)
    depth = np.concatenate([there, there[::-1][1:], p.depth])
    wobble = 0.02 * p.full * np.random.default_rng(rng.randrange(10**6)).normal(size=2 * quick - 1)
    first = p.law(depth[: 2 * quick - 1]) * rng.choice([1.0, 1.0, 0.85]) + wobble
    return written(p, depth, np.concatenate([first, p.force]))


# how it is written down


def pages(rng: random.Random) -> Specimen:
    """Print it in pages, each with the header."""
    p, long = press(rng), rng.choice([20, 50, 64])
    units = rng.choice(["", "mm,N\n"])
    head = f"{HEAD}\n" if not units else "Weg,Kraft\n" + units
    text = ""
    for page, at in enumerate(range(0, len(p.depth), long), 1):
        title = f"Page {page}\n" if rng.random() < 0.5 else ""
        text += title + head + table(p.depth[at : at + long], p.force[at : at + long]) + rng.choice(["", "\n"])
    return Specimen(text.encode(), p.K1, p.K2, p.x0)


def side_by_side(rng: random.Random) -> Specimen:
    """Write a second test, shorter or longer, of another object beside the first; either answer to it is right."""
    p, q = press(rng, rows=300, stiff=False), press(rng, rows=rng.choice([40, 90, 140, 900]), stiff=False)
    padded = rng.random() < 0.7
    rows = []
    for i in range(max(len(p.depth), len(q.depth))):
        cells = [f"{x:.5f}" if i < len(each.depth) else "" for each in (p, q)
                 for x in ((each.depth[i], each.force[i]) if i < len(each.depth) else (0, 0))]  # fmt: skip
        line = ",".join(cells)
        rows.append(line if padded else line.rstrip(","))
    return Specimen("\n".join([f"{HEAD},{HEAD}", *rows]).encode() + b"\n", p.K1, p.K2, p.x0)


def sparse(rng: random.Random) -> Specimen:
    """Record the force in every third row only."""
    p, every = press(rng), rng.choice([2, 3, 4])
    rows = [f"{d:.6f},{f'{f:.6f}' if i % every == 0 else ''}"
            for i, (d, f) in enumerate(zip(p.depth, p.force, strict=True))]  # fmt: skip
    return Specimen("\n".join([f"Time (s),{HEAD}", *(f"{i / 10},{row}" for i, row in enumerate(rows))]).encode(),
                    p.K1, p.K2, p.x0)  # fmt: skip


def japanese_dates(rng: random.Random) -> Specimen:
    """Write a date above or beside the rows as Japanese programs do."""
    p, delimiter = press(rng), rng.choice([",", "\t"])
    above = rng.choice(["日付,2024/12/26\n", "日付,2024年12月26日\n試験者,佐藤\n", "試験日時,令和6年12月26日\n", ""])
    beside = rng.choice([("", ""), ("日付,", "2024年12月26日,"), ("日時,", "2024/12/26 10:30:15,")])
    if not above and not beside[0]:
        above = "日付,2024/12/26\n"
    names = rng.choice(["変位(mm),荷重(N)", "ストローク[mm],試験力[N]", "変位,力\nmm,N"])
    first, *units = names.split("\n")
    head = f"{beside[0]}{first}\n" + "".join(f"{',' if beside[0] else ''}{unit}\n" for unit in units)
    rows = "".join(f"{beside[1]}{d:.6f},{f:.6f}\n" for d, f in zip(p.depth, p.force, strict=True))
    text = (above + head + rows).replace(",", delimiter)
    return Specimen(text.encode(rng.choice(["cp932", "shift_jis"])), p.K1, p.K2, p.x0)


def german_dates(rng: random.Random) -> Specimen:
    """Write the words of a German program in its code page."""
    p = press(rng)
    above = rng.choice(["Prüfdatum;26.12.2024\nPrüfer;Jäger\n", "Datum;26.12.2024\nMaß;Ø 50 mm\n", "Gerät;„Z010“\n"])
    rows = "".join(f"{d:.6f};{f:.6f}\n" for d, f in zip(p.depth, p.force, strict=True)).replace(".", ",")
    return Specimen(f"{above}Weg;Kraft\nmm;N\n{rows}".encode("cp1252"), p.K1, p.K2, p.x0)


def unknown_unit(rng: random.Random) -> Specimen:
    """Give a third column a unit that nobody knows."""
    p, unit = press(rng), rng.choice(["zz", "Ω·m", "a.u.", "L/min"])
    head = rng.choice(["Weg,Kraft,Kanal 3\nmm,N,{}", "Depth,Force,Aux\n(mm),(N),({})", "変位,荷重,外部\nmm,N,{}"])
    rows = "".join(f"{d:.6f},{f:.6f},{rng.random():.3f}\n" for d, f in zip(p.depth, p.force, strict=True))
    return Specimen(f"{head.format(unit)}\n{rows}".encode(), p.K1, p.K2, p.x0)


def unit_unknown(rng: random.Random) -> Specimen:
    """Give the force a unit that nobody knows: nothing but asking is right."""
    p, unit = press(rng), rng.choice(["zz", "a.u.", "div", "N*"])
    head = rng.choice(["Depth (mm),Force ({})", "Weg,Kraft\nmm,{}", "Depth [mm],Load [{}]"])
    return written(p, force=p.force * 7.3, head=head.format(unit))


def stray_cells(rng: random.Random) -> Specimen:
    """Leave notes in the cells beside the header."""
    p = press(rng)
    stray = rng.choice([",,K. Sato", ",Operator: K. Sato", ",,,checked,2", ",,", ",comment", ",remark,A"])
    return written(p, head=HEAD + stray)


def mixed(rng: random.Random) -> Specimen:
    """Combine what may happen: beginning, end, way back, signs, zeros, steps, digits, order, columns and pages."""
    begin = rng.choice(["touch", "approach", "preload", "adhesion"])
    before = rng.uniform(0.08, 0.4) if begin in ("approach", "adhesion") else 0.0
    p = press(rng, approach=before, start=rng.uniform(0.03, 0.3) if begin == "preload" else 0.0)
    dice, depth, force = np.random.default_rng(rng.randrange(10**6)), p.depth, p.force
    if begin == "adhesion":
        width = before * depth[-1] / rng.uniform(4, 10)
        force = force - rng.uniform(0.03, 0.2) * p.full * np.exp(-((depth + 1.8 * width) ** 2) / width**2) * (depth < 0)
    if rng.random() < 0.3:  # uneven steps
        keep = dice.random(len(depth)) > rng.uniform(0.1, 0.5)
        depth, force = depth[keep], force[keep]
    end = rng.choice(["stop", "stop", "back", "torn", "hold"])
    if end == "back":
        depth, force = np.concatenate([depth, depth[::-1]]), np.concatenate([force, 0.85 * force[::-1]])
    elif end == "torn":
        more = depth[-1] + np.arange(1, 40) * np.ptp(depth) / len(depth)
        depth, force = np.concatenate([depth, more]), np.concatenate([force, 0.1 * p.full * np.ones(39)])
    elif end == "hold":
        depth, force = np.append(depth, np.full(60, depth[-1])), np.append(force, force[-1] * np.linspace(1, 0.8, 60))
    if begin == "preload":
        depth = depth - depth[0]
    signs = rng.choice([1, 1, -1]), rng.choice([1, 1, -1])
    zero, tare = (rng.choice([0.0, 15.0]), rng.choice([0.0, 0.03]) * p.full) if before else (0.0, 0.0)
    depth, force = signs[0] * depth + zero, signs[1] * (force + tare)
    digits = 5 if np.ptp(p.depth) < 2 else rng.choice([2, 3, 5])
    rows = [f"{d:.{digits}f},{f:.{rng.choice([4])}f}" for d, f in zip(depth, force, strict=True)]
    head, clock = HEAD, rng.random() < 0.5
    if clock:
        head, rows = f"Time (s),{HEAD}", [f"{i / 50:.2f},{row}" for i, row in enumerate(rows)]
    if rng.random() < 0.15 and (clock or end != "torn"):  # the reverse of a tear without a clock is refused
        rows = rows[::-1]
    if rng.random() < 0.2:
        long = rng.choice([30, 50])
        rows = [row for i in range(0, len(rows), long) for row in ([head] if i else []) + rows[i : i + long]]
    return Specimen("\n".join([head, *rows]).encode() + b"\n", p.K1, p.K2, p.x0)


KINDS: tuple[Callable[[random.Random], Specimen], ...] = (
    preload, slight_preload, begun, preload_doubled, preload_rising, preload_of_a_bent_curve, dead_travel, adhesion,
    approach, short_travel, few_rows, torn, torn_at_last, going_negative, reversed_rows, quick_touch, pages,
    side_by_side, sparse, japanese_dates, german_dates, unknown_unit, unit_unknown, stray_cells, mixed,
)  # fmt: skip


def specimen(kind: Callable[[random.Random], Specimen], seed: int) -> Specimen:
    return kind(random.Random(f"{kind.__name__} {seed}"))

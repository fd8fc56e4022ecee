"""What a graphics processor, or many machines, would bring: computed from what is measured on this one.

Measured here: a step of the native core, the memory's rate, and how long a message to another process and back takes.
From its structures: how many bytes a vertex must move in a step. Not measured, for there is none here: a graphics
processor, taken by its data sheet (`Processor`), and a network, taken to be as quick as this machine's own.

A step needs all of the one before: volume and pose are sums over the body. So whatever works on one body together must
meet once a step, and that meeting, not the arithmetic, is what limits a body of few vertices.
"""

from __future__ import annotations

import argparse
import socket
import time
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median

import numpy as np

from .cost import NATIVE, costs

VALENCE = 6  # neighbours of a vertex, nearly everywhere
# bytes a vertex moves in a step, each once, in single precision (core/native/body.h): slots of its springs, state in
# and out, constants, the velocity that waits for the pressure in and out, and its record out and in
BYTES = VALENCE * 16 + 2 * 24 + 52 + 2 * 24 + 2 * 32
FLOPS = 317 + 6 * VALENCE  # counted for the step without a tension; a tension adds a multiply-add
HALO = 32  # bytes of a vertex on a cut that the other machine needs
SUBDIVISIONS = (4, 5, 6)  # of the ball: 2,562, 10,242 and 40,962 vertices
MILLION = 1_000_000
WIRE = 1.25e9  # bytes a second of a network of ten gigabits
ROUNDS = 400  # messages
COPIED = 64 << 20  # bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Processor:
    """A graphics processor by its data sheet.

    name: of its kind.
    rate: of its memory [B/s].
    flops: [1/s].
    meeting: all of it waiting for one another once [s].
    """

    name: str
    rate: float
    flops: float
    meeting: float = 5e-6

    def step(self, vertices: float) -> float:
        """Return the least time [s] of a step."""
        return self.meeting + vertices * max(BYTES / self.rate, FLOPS / self.flops)


PROCESSORS = (
    Processor(name="laptop, 200 GB/s, 5 TFLOP/s", rate=2e11, flops=5e12),
    Processor(name="desktop, 1000 GB/s, 40 TFLOP/s", rate=1e12, flops=4e13),
)


def memory_rate() -> float:
    """Return how many bytes a second one core reads and writes, beyond its caches."""
    a, b = (np.zeros(COPIED // 8) for _ in range(2))
    times = []
    for _ in range(9):
        started = time.process_time()
        np.copyto(b, a)
        times.append(time.process_time() - started)
    return 2 * COPIED / median(times)


def round_trip() -> float:
    """Return how long a short message takes to a socket and back [s]: a network has this and its own way on top."""
    kind = socket.AF_INET, socket.SOCK_DGRAM
    with socket.socket(*kind) as one, socket.socket(*kind) as two:
        for each in (one, two):
            each.bind(("127.0.0.1", 0))
        times = []
        for _ in range(ROUNDS):
            started = time.perf_counter()
            for sender, receiver in ((one, two), (two, one)):
                sender.sendto(bytes(64), receiver.getsockname())
                receiver.recv(64)
            times.append(time.perf_counter() - started)
    return median(times)


def split_step(vertices: float, machines: int, *, each: float, meeting: float, wire: float) -> float:
    """Return the time [s] of a step of one body on several machines.

    Args:
        each: time of a vertex on one of them [s].
        meeting: a message there and back [s].
        wire: bytes a second between two of them.
    """
    if machines == 1:
        return vertices * each
    cut = np.sqrt(vertices)  # a compact part of n vertices has a border of about root n
    return float(vertices / machines * each + meeting + HALO * cut / wire)


def pays_from(gain: float, meeting: float) -> float:
    """Return from how many vertices a meeting [s] a step is worth it, where a vertex saves `gain` [s] by it."""
    return meeting / gain if gain > 0 else float("inf")


def report() -> Iterator[str]:
    """Yield the lines of the study."""
    found = list(costs([NATIVE], SUBDIVISIONS))
    each = {cost.vertices: cost.seconds / cost.vertices for cost in found}
    rate, trip = memory_rate(), round_trip()
    yield f"A vertex moves {BYTES} B and takes {FLOPS} flop a step."
    for vertices, seconds in each.items():
        yield f"one core, {vertices:,} vertices: {1e9 * seconds:.1f} ns a vertex-step, {BYTES / seconds / 1e9:.0f} GB/s"
    yield f"memory of one core: {rate / 1e9:.1f} GB/s; a message to a process and back: {1e6 * trip:.0f} us"
    seconds = each[max(each)]
    for processor in PROCESSORS:
        own = processor.step(MILLION) - processor.meeting
        yield f"{processor.name}: pays from {pays_from(seconds - own / MILLION, processor.meeting):,.0f} vertices up"
        for vertices in (*each, MILLION):
            ratio = vertices * each.get(vertices, seconds) / processor.step(vertices)
            yield f"  {vertices:,} vertices: {1e6 * processor.step(vertices):.0f} us a step, {ratio:.0f} times one core"
    yield f"two machines on one body: pay from {pays_from(seconds / 2, trip):,.0f} vertices up; times one machine:"
    for machines in (2, 4, 8, 16):
        sizes = 2562, 40962, MILLION
        ratios = [n * seconds / split_step(n, machines, each=seconds, meeting=trip, wire=WIRE) for n in sizes]
        yield f"  {machines} machines: " + ", ".join(f"{n:,} {r:.1f}" for n, r in zip(sizes, ratios, strict=True))
    yield "Bodies that do not meet, shots and frames of a clip share nothing: a farm runs them as many times as fast as"
    yield "it has machines, by the command that bakes one body (README, Flamenco), and no step waits for another."


def add_machines(parser: argparse.ArgumentParser) -> None:
    """Add the command."""
    parser.set_defaults(run=_run)


def _run(_options: argparse.Namespace) -> int:
    for line in report():
        print(line, flush=True)
    return 0

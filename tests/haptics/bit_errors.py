"""Send frames through a line that flips bits; count those lost and those that came out other than they went in.

`python -m tests.haptics.bit_errors --frames 10000000`
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from core.device import wire

RATES = {1e-6: 0.4, 1e-5: 0.2, 1e-4: 0.2, 1e-3: 0.2}  # more where few are lost
BATCH = 20_000  # frames; fewer than sequence numbers, so that each is known by its own
CHUNK = 4096  # bytes a read


def lost_share(rate: float, kind: type = wire.DeviceState) -> float:
    """Return the expected share of frames hit by one error or more: 1 - (1 - rate)^288 of States."""
    return float(-np.expm1(8 * wire.size(kind) * np.log1p(-rate)))


def frames_of(kind: type, dice: np.random.Generator) -> list[wire.Frame]:
    """Return a batch of States or Commands, seq 0, 1, 2..., all else random."""
    words, times = dice.integers(-0x8000, 0x8000, (BATCH, 9)).tolist(), dice.integers(0, 1 << 32, BATCH).tolist()
    if kind is wire.DeviceState:
        return [wire.DeviceState(7, i, i - 1 & 0xFFFF, times[i], tuple(words[i]), 0, 3) for i in range(BATCH)]
    return [wire.Command(7, i, i, tuple(words[i]), 3, 5) for i in range(BATCH)]


def survey(rate: float, frames: int, seed: int, kind: type = wire.DeviceState) -> tuple[int, int, int]:
    """Return how many frames were sent, how many came out unaltered, and how many of what came out is wrong."""
    dice = np.random.default_rng(seed)
    batch = frames_of(kind, dice)
    clean = np.frombuffer(b"".join(map(wire.encode, batch)), np.uint8)
    decoder, sent, found, wrong = wire.Decoder(), 0, 0, 0
    while sent < frames:
        line = clean.copy()
        bits = np.unique(dice.integers(0, 8 * line.size, dice.binomial(8 * line.size, rate)))
        np.bitwise_xor.at(line, bits // 8, np.left_shift(1, bits % 8).astype(np.uint8))
        data, last = line.tobytes(), -1
        for at in range(0, len(data), CHUNK):
            for frame in decoder.feed(data[at : at + CHUNK]):
                seq = frame.seq if isinstance(frame, (wire.DeviceState, wire.Command)) else -1
                right = type(frame) is kind and last < seq < BATCH and frame == batch[seq]
                found, wrong, last = found + right, wrong + (not right), max(last, seq)
        decoder.feed(b"\0")
        sent += BATCH
    return sent, found, wrong


def main() -> None:
    """Print a line for each rate, and the number of wrong frames in all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=10_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    begin, everything, mistakes = time.process_time(), 0, 0
    print("frame,bit error rate,sent,lost,lost share,1-(1-p)^bits,ratio,wrong")
    for rate, share in RATES.items():
        for kind in (wire.DeviceState, wire.Command):
            sent, found, wrong = survey(rate, round(share * options.frames / 2), options.seed, kind)
            lost, expected = 1 - found / sent, lost_share(rate, kind)
            figures = f"{rate:.0e},{sent},{sent - found},{lost:.4e},{expected:.4e},{lost / expected:.3f},{wrong}"
            print(f"{kind.__name__},{figures}", flush=True)
            everything, mistakes = everything + sent, mistakes + wrong
    seconds = time.process_time() - begin
    print(
        f"{mistakes} wrong frames accepted of {everything}; {seconds:.0f} s, {1e6 * seconds / everything:.1f} us each"
    )


if __name__ == "__main__":
    main()

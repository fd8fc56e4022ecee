"""COBS: bytes coded so that 0x00 appears nowhere but at their end.

Each run up to a 0x00 is preceded by one more than its length, which takes the place of the 0x00.
Source: Cheshire and Baker, Consistent Overhead Byte Stuffing.
"""

from __future__ import annotations

from typing import Final

_CODES: Final = [bytes((n,)) for n in range(256)]


def stuff(block: bytes) -> bytes:
    """Return the COBS code of at most 253 bytes, with the closing 0x00."""
    return b"".join([_CODES[len(run) + 1] + run for run in block.split(b"\0")]) + b"\0"


def unstuff(code: bytes) -> bytes | None:
    """Return the bytes of a COBS code without its closing 0x00, None where it is none."""
    runs, at, end = [], 0, len(code)
    while at < end:
        if not code[at]:
            return None
        after = at + code[at]
        runs.append(code[at + 1 : after])
        at = after
    return b"\0".join(runs) if at == end else None

"""How late this machine wakes a process that only waits, a thousand times a second, with the priority of a servo's.

What device and servo are late by is to be read beside it. It runs as a process of its own, for priority is a process's.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Final

from core.device import priority
from studies.bench.round_trips import percentiles

TICK: Final = 1e-3  # [s]


def machine_lateness(seconds: float = 2.0) -> dict[str, float]:
    """Return `machine_p99_us`, and as `machine_late_share` the share of ticks that began more than a tick late."""
    words = [sys.executable, "-m", __spec__.name, str(seconds)]
    done = subprocess.run(words, capture_output=True, check=True)
    measured: dict[str, float] = json.loads(done.stdout)
    return measured


def _wait(seconds: float) -> dict[str, float]:
    priority.request_priority()
    priority.keep_processors_awake()
    late, due = [], time.perf_counter()
    for _ in range(round(seconds / TICK)):
        due += TICK
        time.sleep(max(due - time.perf_counter(), 0.0))
        late.append(time.perf_counter() - due)
    return {"machine_p99_us": 1e6 * percentiles(late)[1], "machine_late_share": sum(t > TICK for t in late) / len(late)}


if __name__ == "__main__":
    print(json.dumps(_wait(float(sys.argv[1]))))

"""Start emulator or servo with their instruments, isolated as core/device/start.py starts those of the product."""

import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    sys.path += [str(Path(__file__).resolve().parents[2]), sys.argv[1]]
    sys.exit(import_module("studies.bench.processes").main(sys.argv[2:]))

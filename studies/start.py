"""Start emulator or servo with their instruments, isolated as core/haptics/start.py starts those of the product."""

import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    sys.path += [str(Path(__file__).resolve().parents[1]), sys.argv[1]]
    sys.exit(import_module("studies.processes").main(sys.argv[2:]))

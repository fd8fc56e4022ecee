"""Start the servo process with the standard library and pyserial alone: `python -I -S start.py FOLDER OPTIONS`.

FOLDER contains pyserial. Environment variables and site-packages are ignored, so that no other package interferes.
"""

import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    sys.path += [str(Path(__file__).resolve().parents[2]), sys.argv[1]]
    sys.exit(import_module("core.device.servo_process").main(sys.argv[2:]))

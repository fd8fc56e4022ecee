"""Start with the standard library and pyserial alone: `python -I -S start.py FOLDER OPTIONS`.

Isolated from the environment and from site-packages, so that no package installed on this computer interferes.
"""

import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    sys.path += [str(Path(__file__).resolve().parents[2]), sys.argv[1]]
    sys.exit(import_module("core.device.servo_process").main(sys.argv[2:]))

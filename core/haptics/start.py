"""Start with the standard library, pyserial and numpy alone: `python -I -S start.py FOLDERS servo PORT ...`.

Isolated from the environment and from site-packages, so that no package installed on this computer interferes.
"""

import os
import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    sys.path += [str(Path(__file__).resolve().parents[2]), *sys.argv[1].split(os.pathsep)]
    sys.exit(import_module("core.haptics.command").main(sys.argv[2:]))

"""Run a command without Blender: `python3 dev.py core COMMAND`."""

from __future__ import annotations

import sys
from importlib import import_module

from core.base import DimpleError

from .commands import COMMANDS, parser

UNUSABLE, STOPPED = 2, 130  # exit codes; those of a command itself are 0 and from 3 on


def main(words: list[str] | None = None) -> int:
    """Run a command and return its exit code."""
    words = sys.argv[1:] if words is None else words
    whole, parts = parser()
    if words and words[0] in COMMANDS:  # no other command's module is imported
        _, module, add = COMMANDS[words[0]]
        getattr(import_module(module, __package__), add)(parts[words[0]])
    options = whole.parse_args(words)
    try:
        return int(options.run(options))
    except DimpleError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    except OSError as error:
        if error.filename is None:
            raise
        print(f"{error.filename} cannot be written: {error.strerror or error}.", file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        print("Stopped.", file=sys.stderr)
        return STOPPED


if __name__ == "__main__":
    sys.exit(main())

"""The rooms of the haptic device: nothing of the laboratory in core, and no circle of imports."""

import ast
import json
import subprocess
import sys
from pathlib import Path

from tools.environment import ROOT

WATCHED = [
    *sorted((ROOT / "core" / "device").glob("*.py")),
    *(ROOT / "operators" / f"{name}.py" for name in ("haptic", "device", "sessions", "live")),
]
NAMES = {path: ".".join(path.relative_to(ROOT).with_suffix("").parts) for path in WATCHED}


def imported(path: Path) -> set[str]:
    """Return the watched modules that a file imports, wherever in it, for its types too."""
    package, found = path.relative_to(ROOT).parent.parts, set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = [*package[: len(package) + 1 - node.level], *(node.module or "").split(".")]
            base = [part for part in base if part]
            found |= {".".join(base), *(".".join([*base, alias.name]) for alias in node.names)}
    return found & set(NAMES.values()) - {NAMES[path]}


def test_no_module_of_the_device_imports_itself_through_another() -> None:
    above = {NAMES[path]: imported(path) for path in WATCHED}
    assert "core.device.servo" in above["core.device.servo_process"]
    assert "operators.press.sessions" in above["operators.press.haptic_fingertips"]
    while bottom := [name for name, needs in above.items() if not needs]:
        for name in bottom:
            del above[name]
        above = {name: needs - set(bottom) for name, needs in above.items()}
    assert above == {}, "these import each other"


def test_what_blender_starts_needs_the_standard_library_alone() -> None:
    """The servo runs `python -I -S`: no site-packages, and no time to load numpy; nothing of the studies."""
    code = (
        f"import sys, json; sys.path.insert(0, {str(ROOT)!r}); import core.device.servo_process; "
        "print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules} - set(sys.stdlib_module_names))))"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True)
    assert [name for name in json.loads(done.stdout) if not name.startswith("_")] == ["core"]

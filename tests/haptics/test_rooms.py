"""The rooms of the haptic device: nothing of the laboratory in the servo's process."""

import json
import subprocess
import sys

from tools.environment import ROOT


def test_what_blender_starts_needs_the_standard_library_alone() -> None:
    """The servo runs `python -I -S`: no site-packages, and no time to load numpy; nothing of the studies."""
    code = (
        f"import sys, json; sys.path.insert(0, {str(ROOT)!r}); import core.device.servo_process; "
        "print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules} - set(sys.stdlib_module_names))))"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True)
    assert [name for name in json.loads(done.stdout) if not name.startswith("_")] == ["core"]

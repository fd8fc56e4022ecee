"""The command line of a real Blender in the window test: `blender --command dimple bake`, also as Flamenco calls it.

It needs no window; this is where there is a Blender that is no Python module.
"""

from __future__ import annotations

import json
from pathlib import Path

import debian

LIMIT_S = 600
INSTALL = "blender --command extension install-file -r user_default -e /tmp/dimple.zip"
BAKE = "--command dimple bake /mnt/blend"
# what is checked: the words of Blender's command line, and its exit code
CALLS = {
    "bakes": (f"{BAKE} --frames 1-6 --format pc2,glb --out /mnt/out/baked", 0),
    "bakes a part, as a Flamenco worker calls it": (
        f"-b -y {BAKE} --object=Suzanne --frames=3-6 --format=pc2 --out=/mnt/out/part", 0
    ),
    "refuses to replace files": (f"{BAKE} --frames 1-6 --format pc2 --out /mnt/out/baked", 1),
    "says that an object is not there": (f"{BAKE} --object Nobody --format pc2 --out /mnt/out/none", 1),
    "takes no unknown format": (f"{BAKE} --format doc --out /mnt/out/none", 2),
}  # fmt: skip


def run(root: Path, zip_path: Path, out: Path) -> list[dict]:
    """Call Blender and return the checks: exit codes, one line of JSON each, and the files."""
    folder = out / "command"
    folder.mkdir(exist_ok=True)
    lines = ["cp /mnt/zip /tmp/dimple.zip", INSTALL]
    for number, (words, _) in enumerate(CALLS.values()):
        lines.append(f"blender {words} > /mnt/out/{number}.txt 2>&1; echo $? > /mnt/out/{number}.code")
    environment = {"BLENDER_USER_RESOURCES": "/tmp/blender", "PYTHONUNBUFFERED": "1"}
    blend = Path(__file__).parent.parent.parent / "blend_samples" / "suzanne.blend"
    files = {"zip": zip_path, "out": folder, "blend": blend}
    debian.run_inside(
        root, "\n".join(lines), files=files, environment=environment, log=folder / "log.txt", limit_s=LIMIT_S
    )
    return [
        _check(f"the command line {name}", folder / f"{number}.txt", folder / f"{number}.code", code)
        for number, (name, (_, code)) in enumerate(CALLS.items())
    ]


def _check(name: str, output: Path, code: Path, wanted: int) -> dict:
    ended = code.read_text().strip() if code.is_file() else "none"
    printed = output.read_text() if output.is_file() else ""
    summaries = [json.loads(line) for line in printed.splitlines() if line.startswith('{"ok"')]
    ok = ended == str(wanted) and len(summaries) == (wanted < 2)
    for summary in summaries:
        written = [output.parent / Path(path).relative_to("/mnt/out") for path in summary["written"]]
        ok = ok and summary["ok"] == bool(written) == (wanted == 0) and all(path.is_file() for path in written)
    return {"name": name, "ok": ok, "detail": f"exit code {ended}; {[each['error'] for each in summaries]}"}

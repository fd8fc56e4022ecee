"""Press a mesh in a real Blender window: python tests/window/run.py --zip ZIP --out DIR [SCENE...]

Builds a chroot with Debian's Blender once (`debian.py`), starts it under Xvfb with `drive.py` inside, and
judges what that wrote. Writes DIR/*.png, DIR/window.json and DIR/blender.log. Exits with 0 when everything
holds or when this machine cannot show a window (and says why), with 1 otherwise.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

import command
import debian
from PIL import Image

LIMIT_S = 6600  # less than dev.py gives, so that what was seen until then is reported
VIEWPORT, LOOP_WIDTH, LOOP_MS = (0, 80, 1050, 720), 720, 90  # [px], [px], [ms] a picture
INSIDE = """
Xvfb :99 -screen 0 1280x800x24 -nolisten tcp > /tmp/xvfb.log 2>&1 &
for i in $(seq 100); do test -e /tmp/.X11-unix/X99 && break; sleep 0.1; done
blender --factory-startup --gpu-backend opengl --enable-event-simulate --window-geometry 0 0 1280 800 \
    --python-exit-code 3 --python /mnt/window/drive.py
code=$?
cp /tmp/*.crash.txt /mnt/out/ 2> /dev/null
exit $code
"""
ENVIRONMENT = {
    "DISPLAY": ":99",
    "LIBGL_ALWAYS_SOFTWARE": "1",
    "BLENDER_USER_RESOURCES": "/tmp/blender",
    "PYTHONUNBUFFERED": "1",
    "PYTHONDONTWRITEBYTECODE": "1",
}
BAD_WORDS = ("Traceback (most recent", "Segmentation fault", "Not freed memory", "Error:")


def bad_lines(log: str) -> list[str]:
    """Return the lines of Blender's output that no good run has."""
    return [line for line in log.splitlines() if any(word in line for word in BAD_WORDS)]


def press(zip_path: Path, out: Path, scenes: list[str]) -> dict:
    """Run Blender in its window, all of its scenes or some, and return the report with its checks."""
    root = debian.chroot_folder()
    for old in [*out.glob("*.png"), out / "window.json"]:
        old.unlink(missing_ok=True)
    shutil.rmtree(out / "command", ignore_errors=True)
    log = out / "blender.log"
    here = Path(__file__).resolve().parent
    project = here.parent.parent
    files = {"zip": zip_path, "out": out, "window": here, "samples": project / "blend_samples"}
    files |= {"studies": project / "studies", "core": project / "core"}  # of the emulated device
    started = time.monotonic()
    print("window: Blender opens its window and is pressed (software rendering, some minutes)", flush=True)
    environment = {**ENVIRONMENT, "DIMPLE_SCENES": " ".join(scenes)}
    code = debian.run_inside(root, INSIDE, files=files, log=log, limit_s=LIMIT_S, environment=environment)
    written = out / "window.json"
    report = json.loads(written.read_text()) if written.exists() else {"checks": []}
    ended = f"killed after {LIMIT_S} s" if code in (137, -9) else f"exit code {code}"
    bad = bad_lines(log.read_text(errors="replace"))
    report["checks"] += [
        {"name": "the run wrote its report", "ok": written.exists(), "detail": str(written)},
        {"name": "Blender closes in good order", "ok": code == 0, "detail": ended},
        {"name": "Blender printed no error", "ok": not bad, "detail": "; ".join(bad)},
    ]
    if not scenes:
        report["checks"] += command.run(root, zip_path, out)
    report["seconds_in_all"] = round(time.monotonic() - started, 1)
    written.write_text(json.dumps(report, indent=1) + "\n")
    return report


def looping(out: Path) -> None:
    """Make one looping picture of the pictures of a press that swells, for the README."""
    shots = [Image.open(path).convert("RGB").crop(VIEWPORT) for path in sorted(out.glob("loop-*.png"))]
    if not shots:
        return
    small = [shot.resize((LOOP_WIDTH, round(LOOP_WIDTH * shot.height / shot.width))) for shot in shots]
    small[0].save(
        out / "loop.webp", save_all=True, append_images=small[1:], duration=LOOP_MS, loop=0, quality=70, method=6
    )


def tell(report: dict, out: Path) -> int:
    """Print each check and the sum; return the exit code."""
    checks = report["checks"]
    failed = sum(not check["ok"] for check in checks)
    for check in checks:
        print(f"  {'ok  ' if check['ok'] else 'FAIL'} {check['name']}", end="")
        print(f": {check['detail']}" if check["detail"] else "")
    if rate := report.get("measured", {}).get("frames_per_second"):
        print(f"window: {rate} frames drawn a second, on average")
    print(f"window: {len(checks) - failed} passed, {failed} failed in {report['seconds_in_all']:.0f} s")
    print(f"window: pictures and window.json in {out}")
    return 1 if failed else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures and window.json")
    parser.add_argument("scenes", nargs="*", help="names of scenes to play, those of drive.py; all without")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    try:
        report = press(arguments.zip.resolve(strict=True), arguments.out.resolve(), arguments.scenes)
    except debian.Unavailable as reason:
        print(f"window: skipped: {reason}")
        return 0
    looping(arguments.out)
    return tell(report, arguments.out)


if __name__ == "__main__":
    sys.exit(main())

"""What is shipped: the zip, the manifest and the pins behind them."""

import re
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from tools import extension, native
from tools.environment import BLENDERS, DEV_PINS, PEER_PINS, ROOT, WHEEL_PINS, Stop

# what is read at run time beside Python
DATA = {"LICENSE", "blender_manifest.toml", "core/haptics/haptic_master.toml"}
EXACT = re.compile(r"[a-z][a-z0-9_.-]*==\d[\w.]*")


@pytest.fixture(scope="module")
def names(extension_zip: Path) -> list[str]:
    with zipfile.ZipFile(extension_zip) as archive:
        return archive.namelist()


def pins(path: Path) -> list[str]:
    lines = (line.partition("#")[0].strip() for line in path.read_text().splitlines())
    return [line for line in lines if line]


def test_the_zip_holds_the_extension_and_nothing_else(names: list[str]) -> None:
    paths = [
        path
        for folder in ("addon", "operators", "core")
        for ending in ("py", "c", "h")  # the licence: the sources of what is compiled go with it
        for path in (ROOT / folder).rglob(f"*.{ending}")
    ]
    sources = {path.relative_to(ROOT).as_posix() for path in paths}
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    wheels = {wheel.removeprefix("./") for wheel in manifest["wheels"]}
    assert set(names) == sources | {"__init__.py"} | DATA | wheels


def test_the_zip_is_under_two_megabytes(extension_zip: Path) -> None:
    assert extension_zip.stat().st_size < 2_000_000


def test_the_manifest_names_the_wheels_that_are_pinned() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    named = [Path(wheel).name for wheel in manifest["wheels"] if native.PACKAGE not in wheel]
    assert sorted(named) == [wheel.name for wheel in extension.shipped_wheels(sys.executable)]
    pinned = [pin.split()[0] for pin in pins(WHEEL_PINS)]
    assert ["==".join(name.split("-")[:2]) for name in named] == pinned


def test_the_manifest_names_a_native_core_for_each_platform_it_is_compiled_for() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    named = {Path(wheel).name for wheel in manifest["wheels"] if native.PACKAGE in wheel}
    assert named == {f"{native.PACKAGE}-{manifest['version']}-py3-none-{p.tag}.whl" for p in native.PLATFORMS.values()}
    assert set(native.PLATFORMS) <= set(manifest["platforms"])


def test_every_pin_is_exact() -> None:
    for pin in [*pins(DEV_PINS), *pins(native.PINS), *pins(PEER_PINS)]:
        assert EXACT.fullmatch(pin.partition(";")[0].strip()), pin
    for pin in pins(WHEEL_PINS):
        exact, _, rest = pin.partition(" ")
        assert EXACT.fullmatch(exact) and re.fullmatch(r"--hash=sha256:[0-9a-f]{64}", rest), pin
    for version in BLENDERS:
        assert re.fullmatch(r"\d+\.\d+\.\d+", version)


def test_a_refused_manifest_stops_the_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blender's strict validator is really asked."""
    broken = tmp_path / "source"
    broken.mkdir()
    manifest = (ROOT / "blender_manifest.toml").read_text()
    manifest = re.sub('tagline = ".*"', 'tagline = "Ends with a stop."', manifest)
    (broken / "blender_manifest.toml").write_text(manifest)
    (broken / "__init__.py").touch()
    monkeypatch.setattr(extension, "ROOT", broken)
    with pytest.raises(Stop, match="tagline"):
        extension.build_zip(sys.executable, tmp_path)

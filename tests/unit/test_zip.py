"""What is shipped: the zip, the manifest and the pins behind them."""

import re
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from core.everyday_presets import OBJECTS
from tools import extension, native
from tools.environment import BLENDERS, DEV_PINS, PEER_PINS, READER_PINS, ROOT, WHEEL_PINS, Stop

# what is read at run time beside Python
DATA = {
    "LICENSE", "blender_manifest.toml", "core/everyday_presets.json", "core/native/sources.tar.bz2",
    "addon/locale/ja_JP.json", "addon/poke_tool.dat",
}  # fmt: skip
# said here and not read from the manifest or the folders, so that a change of either has to be meant
TOP = {"LICENSE", "__init__.py", "addon", "blender_manifest.toml", "core", "operators", "wheels"}
FOLDERS = {
    "addon", "addon/locale", "addon/pictures", "core", "core/body", "core/calibration", "core/device",
    "core/experiment", "core/mesh", "core/native", "core/poke", "core/recording", "core/reduction", "core/session",
    "core/world", "operators", "operators/animate", "operators/bridge", "operators/calibrate", "operators/device",
    "operators/experiment", "operators/export", "operators/press", "wheels",
}  # fmt: skip
ENDINGS = {"", ".dat", ".json", ".py", ".toml", ".webp", ".whl", ".bz2"}  # no library, object, cache, table or scene
WHEELS = {
    "pyserial": "any", "trimesh": "any",
    "dimple_native": "macosx_11_0_arm64 macosx_11_0_x86_64 manylinux_2_17_x86_64 win_amd64 win_arm64",
}  # fmt: skip
EXACT = re.compile(r"[a-z][a-z0-9_.-]*==\d[\w.]*")


@pytest.fixture(scope="module")
def names(extension_zip: Path) -> list[str]:
    with zipfile.ZipFile(extension_zip) as archive:
        return archive.namelist()


def pins(path: Path) -> list[str]:
    lines = (line.partition("#")[0].strip() for line in path.read_text().splitlines())
    return [line for line in lines if line]


def test_the_zip_holds_the_extension_and_nothing_else(names: list[str]) -> None:
    paths = [path for folder in ("addon", "operators", "core") for path in (ROOT / folder).rglob("*.py")]
    sources = {path.relative_to(ROOT).as_posix() for path in paths}
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    wheels = {wheel.removeprefix("./") for wheel in manifest["wheels"]}
    pictures = {f"addon/pictures/{preset.name}.webp" for preset in OBJECTS}
    assert set(names) == sources | {"__init__.py"} | DATA | wheels | pictures


def test_the_sources_of_what_is_compiled_go_with_it(extension_zip: Path) -> None:
    with zipfile.ZipFile(extension_zip) as outer, outer.open("core/native/sources.tar.bz2") as packed:
        with tarfile.open(fileobj=packed, mode="r:bz2") as archive:
            found = {name: archive.extractfile(name).read() for name in archive.getnames()}
    sources = [Path(native.__file__), *native.SOURCES.glob("*.[ch]")]
    assert found == {path.name: path.read_bytes() for path in sources}


def test_the_zip_holds_these_folders_and_kinds_of_file_alone(names: list[str]) -> None:
    """No laboratory, no tests, no tools, no samples, nothing compiled outside the wheels."""
    assert {name.partition("/")[0] for name in names} == TOP
    assert {Path(name).parent.as_posix() for name in names} - {"."} == FOLDERS
    assert {Path(name).suffix for name in names} == ENDINGS


def test_the_zip_holds_the_wheels_of_two_packages_and_of_the_native_core(names: list[str]) -> None:
    wheels = [Path(name).stem.split("-") for name in names if name.endswith(".whl")]
    found = {(package, platform) for package, _, _, _, platform in wheels}
    assert found == {(package, platform) for package, platforms in WHEELS.items() for platform in platforms.split()}
    assert len(wheels) == len(found)


def test_every_file_in_the_zip_is_that_of_the_repository(extension_zip: Path) -> None:
    with zipfile.ZipFile(extension_zip) as archive:
        assert [name for name in archive.namelist() if archive.read(name) != (ROOT / name).read_bytes()] == []


@pytest.mark.parametrize("platform", WHEELS["dimple_native"].split())
def test_what_a_platform_installs_is_over_one_megabyte_and_under_two(extension_zip: Path, platform: str) -> None:
    """trimesh alone is 0.7 MB. `dev.py wheels` makes these zips; the one that serves all holds five native cores."""
    with zipfile.ZipFile(extension_zip) as archive:
        others = [i for i in archive.infolist() if "dimple_native" in i.filename and platform not in i.filename]
    assert len(others) == 4
    size = extension_zip.stat().st_size - sum(entry.compress_size for entry in others)
    assert 1_000_000 < size < 2_000_000


def test_the_manifest_names_the_wheels_that_are_pinned() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    named = [Path(wheel).name for wheel in manifest["wheels"] if native.PACKAGE not in wheel]
    assert sorted(named) == [wheel.name for wheel in extension.shipped_wheels(sys.executable)]
    pinned = [pin.split()[0] for pin in pins(WHEEL_PINS)]
    assert ["==".join(name.split("-")[:2]) for name in named] == pinned


def test_the_manifest_names_a_native_core_for_each_platform_it_is_compiled_for() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    named = {Path(wheel).name for wheel in manifest["wheels"] if native.PACKAGE in wheel}
    assert named == {f"{native.PACKAGE}-{native.version()}-py3-none-{p.tag}.whl" for p in native.PLATFORMS.values()}
    assert set(native.PLATFORMS) == set(manifest["platforms"])


def test_every_pin_is_exact() -> None:
    for pin in [*pins(DEV_PINS), *pins(native.PINS), *pins(PEER_PINS), *pins(READER_PINS)]:
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

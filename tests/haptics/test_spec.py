"""Device files with wrong and missing values: each is refused by name, none weakens a limit."""

import re
from pathlib import Path

import pytest

from core.device import wire
from core.device.spec import HAPTIC_MASTER, info, load_spec
from core.errors import DimpleError

LINES = HAPTIC_MASTER.read_text(encoding="utf-8").splitlines()
KEYS = {match[1]: i for i, line in enumerate(LINES) if (match := re.match(r"(\w+) *=", line))}
NONSENSE = ("nan", "inf", "-1", "1e9", "true", '"x"', "[]", "{}", "[1.0]", "[nan, nan, nan]", "[1e9, 1e9, 1e9]")
NO_HARM = {("name", '"x"'), ("baud", "1e9")}  # names
WEAKER = {"hold_s": 0.006, "zero_s": 0.026, "latch_s": 0.11, "tip_speed_m_s": 1.6, "peak_force_n": 20.1,
          "continuous_force_n": 10.1, "viscous_ns_m": 21}  # fmt: skip


def changed(folder: Path, name: str, value: str | None) -> Path:
    """Write the device file with one value another, None for none."""
    lines = LINES.copy()
    lines[KEYS[name]] = "" if value is None else f"{name} = {value}"
    path = folder / "device.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize("name", KEYS)
def test_a_value_that_is_none_is_refused_and_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(DimpleError, match=f"has no '{name}'"):
        load_spec(changed(tmp_path, name, None))
    for value in NONSENSE:
        path = changed(tmp_path, name, value)
        if (name, value) in NO_HARM:
            assert wire.encode(info(load_spec(path), 1, 1))
            continue
        with pytest.raises(DimpleError) as refused:
            load_spec(path)
        assert any(word in str(refused.value) for word in (name, "workspace", "baud")), (value, refused.value)


@pytest.mark.parametrize("name", WEAKER)
def test_no_device_file_weakens_a_limit(tmp_path: Path, name: str) -> None:
    with pytest.raises(DimpleError, match=name):
        load_spec(changed(tmp_path, name, str(WEAKER[name])))


def test_a_device_that_would_let_go_between_two_ticks_is_refused(tmp_path: Path) -> None:
    for hz in (50, 100, 200, 249):
        with pytest.raises(DimpleError, match="tick_hz must be from 250"):
            load_spec(changed(tmp_path, "tick_hz", str(hz)))
    with pytest.raises(DimpleError, match="shorter than hold_s"):
        load_spec(changed(tmp_path, "hold_s", "0.001"))


def test_a_table_that_is_none_and_a_file_that_is_no_toml_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "device.toml"
    for text, reason in (("tip = 3", "no 'name'"), ("[", "not valid"), ("\x00", "not valid"), ("", "has no")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(DimpleError, match=reason):
            load_spec(path)
    path.write_text("\n".join(["tip = 3"] + [line for line in LINES if not re.match(r"\[tip\]|visc", line)]))
    with pytest.raises(DimpleError, match=r"\[tip\] must be a table"):
        load_spec(path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(DimpleError, match="not valid"):
        load_spec(path)
    with pytest.raises(DimpleError, match="cannot be read"):
        load_spec(tmp_path)

"""The words and units in the files of instruments, in English, German and Japanese."""

from __future__ import annotations

import re
import unicodedata

from ..material import POUND, STANDARD_GRAVITY

# unit: (kind, factor to SI); looked up as written first, then in lower case
UNITS: dict[str, tuple[str, float]] = {
    **dict.fromkeys(("N", "Newton", "Newtons", "ニュートン"), ("force", 1.0)),
    "mN": ("force", 1e-3), "cN": ("force", 1e-2), "daN": ("force", 10.0), "kN": ("force", 1e3),
    "uN": ("force", 1e-6), "μN": ("force", 1e-6), "dyn": ("force", 1e-5),
    **dict.fromkeys(("gf", "g", "grams", "gram", "gr", "グラム", "p", "pond"), ("force", 1e-3 * STANDARD_GRAVITY)),
    **dict.fromkeys(("kgf", "kg", "kp", "kilopond", "キログラム"), ("force", STANDARD_GRAVITY)),
    **dict.fromkeys(("lbf", "lb", "lbs", "pound", "pounds"), ("force", POUND * STANDARD_GRAVITY)),
    **dict.fromkeys(("ozf", "oz"), ("force", POUND / 16 * STANDARD_GRAVITY)),
    **dict.fromkeys(("mm", "millimeter", "millimetre", "millimeters", "ミリ"), ("length", 1e-3)),
    **dict.fromkeys(("um", "μm", "micron", "microns"), ("length", 1e-6)),
    "nm": ("length", 1e-9), "cm": ("length", 1e-2), "m": ("length", 1.0), "mil": ("length", 25.4e-6),
    **dict.fromkeys(("in", "inch", "inches", '"', "zoll"), ("length", 25.4e-3)),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "sek", "秒"), ("time", 1.0)),
    **dict.fromkeys(("ms", "msec", "millis"), ("time", 1e-3)),
    **dict.fromkeys(("min", "分"), ("time", 60.0)),
    **dict.fromkeys(("%", "-", "mm/mm", "Pa", "kPa", "MPa", "GPa", "psi", "N/mm2", "N/mm²", "N/mm", "mm/min", "mm/s",
                     "V", "mV", "mV/V", "Hz", "°C", "℃", "deg", "°", "Nm", "Nmm", "mJ", "J", "bit", "counts"),
                    ("other", 1.0)),
}  # fmt: skip
_LOWER = {name.lower(): unit for name, unit in UNITS.items() if name not in ("mN", "MPa", "mJ", "p")}
_AMBIGUOUS = {"M", "MN", "NM", "P", "G", "MS"}  # in capitals, each may mean two units

KIND = {"force": "force", "depth": "length", "time": "time"}  # role of a column: kind of its unit

# role: words in headers that name it; "other" has priority over the rest
_ROLES = {
    "force": "force load kraft standardkraft prüfkraft last druckkraft fz fx fy fn scale weight gewicht f "
    "荷重 試験力 力 圧縮力 押込力 フォース ロード",
    "depth": "displacement disp extension compression travel stroke position crosshead extensometer deflection "
    "indentation depth penetration distance deformation weg standardweg traverse traversenweg eindringtiefe "
    "eindringweg verformung hub x z d 変位 変位量 ストローク 伸び 押込み 押し込み 押込量 押し込み量 距離 深さ 移動量 "
    "位置 たわみ 圧縮量",
    "time": "time zeit prüfzeit millis seconds sec elapsed t 時間 時刻 経過時間",
    "other": "stress strain spannung dehnung stauchung torque moment drehmoment energy energie temperature temperatur "
    "speed velocity geschwindigkeit rate raw counts steps judge no nr number index sample cycle zyklus unit einheit "
    "rohwert status sequence error date datum tx ty tz 応力 ひずみ 歪 歪み トルク エネルギー 温度 速度 番号 単位 "
    "判定 回数 サイクル 日付 日時 年月日",
}
_WORDS = {word: role for role, words in _ROLES.items() for word in words.split()}
# a header that scales its numbers ("Force (x10 N)", "10^-3 N"): multiply or divide is unclear, so it has no unit
_SCALED = re.compile(r"(?<![a-z])[x×*·/]\s*10|\b10\s*(\^|\*\*|[⁻⁺]|[-+]\d)", re.IGNORECASE)
_ENDINGS = ("kraft", "weg", "zeit", "spannung", "dehnung")  # German compounds


def unit_of(text: str) -> tuple[str, float] | None:
    """Return the kind ("force", "length", "time", "other") and the factor to SI of a unit, None if it is unknown."""
    name = unicodedata.normalize("NFKC", text).strip().strip("()[]{}<>").strip()
    if name in UNITS:
        return UNITS[name]
    if not name or name in _AMBIGUOUS:
        return None
    return _LOWER.get(name.lower().rstrip("."))


def split_unit(header: str) -> tuple[str, str]:
    """Split a header such as "Load (N)", "Weg/mm", "Force_N" or "変位[mm]" into name and unit ("" if it has none)."""
    text = unicodedata.normalize("NFKC", header).strip()
    if _SCALED.search(header):
        return text, ""
    for pattern in (
        r"^(.*?)\s*[(\[<{]\s*([^()\[\]{}<>]+?)\s*[)\]>}]\s*$",
        r"^(.+?)\s*/\s*(\S+)$",
        r"^(.+?)\s+in\s+(\S+)$",
        r"^(.+?)[_,\s]\s*(\S+)$",
    ):
        found = re.match(pattern, text)
        if found and unit_of(found[2]):
            return found[1].strip(), found[2]
        if found and text[-1] in ")]>}":  # text in brackets is the unit, known or not
            break
    return text, ""


def role_of(name: str) -> str | None:
    """Return the role of a column by its name: "force", "depth", "time", "other", or None."""
    text = unicodedata.normalize("NFKC", name).lower()
    found = {_WORDS[token] for token in _tokens(text) if token in _WORDS}
    found |= {_WORDS[ending] for token in _tokens(text) for ending in _ENDINGS if token.endswith(ending)}
    # Japanese is written without spaces: search for the longest known words inside the text
    found |= {_WORDS[word] for word in _inside(text)}
    for role in ("other", "force", "depth", "time"):
        if role in found:
            return role
    return None


def is_known(text: str) -> bool:
    """Return whether a cell is a unit or names a role."""
    name, unit = split_unit(text)
    return bool(unit) or unit_of(text) is not None or role_of(name) is not None


def _tokens(text: str) -> list[str]:
    return [token for token in re.split(r"[^a-zäöüß]+", text) if token]


def _inside(text: str) -> list[str]:
    if text.isascii():
        return []
    found = [word for word in _WORDS if not word.isascii() and ord(word[0]) > 0x2FFF and word in text]
    return [word for word in found if not any(word != longer and word in longer for longer in found)]

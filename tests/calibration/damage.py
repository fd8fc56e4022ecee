"""Files of six instruments, and what may happen to them, by seed: a press of Object 2 in all of them."""

import io
import random
import re
import zipfile
from collections.abc import Callable

import numpy as np

TRUTH = {"K1": 610.0, "K2": 7230.0, "x0": 0.0163}


# whole files, as (text, encoding)


def plain(depth, force) -> tuple[str, str]:
    rows = "\n".join(f"{d:.5f},{f:.5f}" for d, f in zip(depth, force, strict=True))
    return f"Depth (mm),Force (N)\n{rows}\n", "utf-8"


def imada(depth, force) -> tuple[str, str]:
    head = "Maximum,5219.3,@,No.1124,\nAverage,48.56,\nData Quantity,200,\nNumber of NG,0,\n"
    head += "No.,Force,Unit,Displacement,Unit,Judge,Position,Time,Date,\n"
    rows = (
        f"{i},{f / 9.80665e-3:.2f},gf,{d:.4f},mm,OK,--,10:30:52 AM,12/26/2024,"
        for i, (d, f) in enumerate(zip(depth, force, strict=True), 1)
    )
    return head + "\n".join(rows) + "\n", "utf-8"


def high_resolution(depth, force) -> tuple[str, str]:
    head = "MAX FORCE = 5219.3,22.000\nUNIT = gf,mm\nDATA COUNT = 200,\nRECORDING RATE = 0.0005,\nCOMMENT = ,\n"
    return head + "\n".join(f"{f / 9.80665e-3:.2f},{d:.4f}" for d, f in zip(depth, force, strict=True)) + "\n", "utf-8"


def zwick(depth, force) -> tuple[str, str]:
    head = "Prüfer;Müller\nWerkstoff;Schaum\n\nPrüfzeit;Standardweg;Standardkraft\ns;mm;N\n"
    rows = (f"{i / 10:.1f};{d:.5f};{f:.5f}" for i, (d, f) in enumerate(zip(depth, force, strict=True)))
    return head + "\n".join(rows).replace(".", ",") + "\n", "cp1252"


def japanese(depth, force) -> tuple[str, str]:
    rows = (f"{i / 10:.1f}\t{f:.5f}\t{d:.5f}" for i, (d, f) in enumerate(zip(depth, force, strict=True)))
    return "時間\t試験力\tストローク\n秒\tN\tmm\n" + "\n".join(rows) + "\n", "cp932"


def bluehill(depth, force) -> tuple[str, str]:
    head = '"Specimen 1"\n\n"Time","Compressive extension","Compressive load"\n"(s)","(mm)","(kN)"\n'
    rows = (f'"{i / 10:.3f}","{d:.5f}","{f / 1e3:.8f}"' for i, (d, f) in enumerate(zip(depth, force, strict=True)))
    return head + "\n".join(rows) + "\n", "utf-8-sig"


WRITERS = (plain, imada, high_resolution, zwick, japanese, bluehill)


def press(rng: random.Random) -> tuple[np.ndarray, np.ndarray]:
    """Return depth [mm] and force [N]; some presses have a way there, some a way back."""
    depth = np.linspace(-rng.choice([0, 0, 3, 8]), 22, rng.choice([150, 300]))
    if rng.random() < 0.3:
        depth = np.concatenate([depth, depth[::-1]])
    inside = np.maximum(depth, 0)
    force = 0.61 * np.minimum(inside, 16.3) + 7.23 * np.maximum(inside - 16.3, 0)
    return depth, force + 0.01 * 51 * np.random.default_rng(rng.randrange(10**6)).normal(size=len(depth))


# damage: text, encoding, chance -> bytes


def parts(text: str) -> tuple[list[str], list[str], str]:
    """Return the lines above the table, its rows, and its delimiter."""
    lines = text.rstrip("\n").split("\n")
    first = next(i for i, line in enumerate(lines) if re.match(r'^"?-?\d', line) and re.match(r'^"?-?\d', lines[i + 1]))
    return lines[:first], lines[first:], next(d for d in ";\t," if d in lines[first])


def truncated(text, encoding, rng):
    data = text.encode(encoding)
    return data[: rng.randrange(len(data))]


def columns_shuffled(text, encoding, rng):
    return shuffle(text, encoding, rng, headers_too=True)


def columns_shuffled_under_their_headers(text, encoding, rng):
    """The force moves: depth and time of an evenly driven press are the same but for the unit, whoever reads them."""
    return shuffle(text, encoding, rng, headers_too=False)


def shuffle(text, encoding, rng, *, headers_too):
    above, rows, delimiter = parts(text)
    width = len(rows[0].split(delimiter))
    header = next((line for line in reversed(above) if re.search("force|kraft|試験力|load", line.lower())), "force")
    force_at = next(
        i for i, cell in enumerate(header.split(delimiter)) if re.search("force|kraft|試験力|load", cell.lower())
    )
    order = list(range(width))
    rng.shuffle(order)
    while not headers_too and order[force_at] == force_at:
        rng.shuffle(order)

    def turned(line):
        cells = line.split(delimiter)
        return delimiter.join(cells[i] for i in order) if len(cells) == width else line

    above = [turned(line) for line in above] if headers_too else above
    return "\n".join([*above, *map(turned, rows)]).encode(encoding) + b"\n"


def another_encoding(text, encoding, rng):
    other = rng.choice(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp932", "cp1252"])
    return text.encode(other, errors="replace")


def a_wrong_mark(text, encoding, rng):
    return rng.choice([b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"]) + text.encode(encoding)


def read_and_written_wrongly(text, encoding, rng):
    wrong = rng.choice(["latin-1", "cp1252", "cp932"])
    return text.encode("utf-8").decode(wrong, errors="replace").encode("utf-8")


def binary_in_the_middle(text, encoding, rng):
    data = text.encode(encoding)
    at = rng.randrange(len(data))
    return data[:at] + rng.randbytes(rng.choice([5, 500, 50_000])) + data[at:]


def all_binary(text, encoding, rng):
    return rng.randbytes(rng.choice([10, 1000, 100_000]))


def bytes_flipped(text, encoding, rng):
    data = bytearray(text.encode(encoding))
    for _ in range(rng.choice([1, 5, 50])):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def lines_lost(text, encoding, rng):
    share = rng.choice([0.02, 0.3])
    return "\n".join(line for line in text.split("\n") if rng.random() > share).encode(encoding)


def lines_doubled(text, encoding, rng):
    return "\n".join(line + "\n" + line if rng.random() < 0.2 else line for line in text.split("\n")).encode(encoding)


def blank_lines_and_other_line_ends(text, encoding, rng):
    return text.replace("\n", rng.choice(["\n\n", "\r\n", "\r", "\r\r\n", "  \n"])).encode(encoding)


def another_delimiter(text, encoding, rng):
    above, rows, delimiter = parts(text)
    return "\n".join([*above, *rows]).replace(delimiter, rng.choice(";\t| ,")).encode(encoding)


def decimal_marks_mixed(text, encoding, rng):
    above, rows, _ = parts(text)
    swap = str.maketrans(".,", ",.")
    share = rng.choice([0.02, 0.5, 1.0])
    rows = [row.translate(swap) if rng.random() < share else row for row in rows]
    return "\n".join([*above, *rows]).encode(encoding)


def numbers_ten_times(text, encoding, rng):
    above, rows, _ = parts(text)
    for _ in range(rng.choice([1, 4])):
        at = rng.randrange(len(rows))
        rows[at] = re.sub(r"(\d)([.,]\d{3})", r"\g<1>7\2", rows[at], count=2)
    return "\n".join([*above, *rows]).encode(encoding)


def words_for_numbers(text, encoding, rng):
    above, rows, delimiter = parts(text)
    for _ in range(rng.choice([1, 10])):
        at = rng.randrange(len(rows))
        cells = rows[at].split(delimiter)
        cells[rng.randrange(len(cells))] = rng.choice(
            ["", "nan", "inf", "1e999", "OL", "-----", "=1+1", "#REF!", "1_0"]
        )
        rows[at] = delimiter.join(cells)
    return "\n".join([*above, *rows]).encode(encoding)


def header_lost(text, encoding, rng):
    return "\n".join(parts(text)[1]).encode(encoding)


def header_garbled(text, encoding, rng):
    above, rows, _ = parts(text)
    above = ["".join(rng.choice("qwxyz ") if c.isalpha() and rng.random() < 0.5 else c for c in line) for line in above]
    return "\n".join([*above, *rows]).encode(encoding, errors="replace")


def another_unit(text, encoding, rng):
    """Files that say another unit are right in that unit: only nonsense may be wrong, and it is asked."""
    return re.sub(r"\b(mm|kN|gf|N)\b", "xx", text).encode(encoding)


def signs_and_zeros_moved(text, encoding, rng):
    depth, force = press(rng)
    depth, force = rng.choice([1, -1]) * depth + rng.choice([0, 7, -30]), rng.choice([1, -1]) * force
    return rng.choice(WRITERS)(depth, force)[0].encode("utf-8")


def text_before_and_after(text, encoding, rng):
    noise = "\n".join(rng.choice(["Report of 3 tests", "a,b;c", "12 mm at 4 N", "", "#"]) for _ in range(30))
    return f"{noise}\n{text}\nmean;{rng.random()};\nEnd of report\n".encode(encoding)


def two_files_in_one(text, encoding, rng):
    return (text + "\n" + text).encode(encoding)


def rows_shuffled(text, encoding, rng):
    above, rows, _ = parts(text)
    rng.shuffle(rows)
    return "\n".join([*above, *rows]).encode(encoding)


def cells_lost(text, encoding, rng):
    above, rows, delimiter = parts(text)
    rows = [row.rsplit(delimiter, 1)[0] if rng.random() < rng.choice([0.02, 0.4]) else row for row in rows]
    return "\n".join([*above, *rows]).encode(encoding)


def without_line_ends(text, encoding, rng):
    return text.replace("\n", rng.choice([" ", ""])).encode(encoding)


def one_endless_line(text, encoding, rng):
    return text.encode(encoding) + b"1,2," * rng.choice([10_000, 1_000_000])


def a_zip_bomb(text, encoding, rng):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("press.csv", bytes(20_000_000))
    return buffer.getvalue()


def an_unclosed_quote(text, encoding, rng):
    at = rng.randrange(len(text))
    return (text[:at] + '"' + text[at:]).encode(encoding, errors="replace")


DAMAGE: tuple[Callable[..., bytes], ...] = (
    truncated, columns_shuffled, columns_shuffled_under_their_headers, another_encoding, a_wrong_mark,
    read_and_written_wrongly, binary_in_the_middle, all_binary, bytes_flipped, lines_lost, lines_doubled,
    blank_lines_and_other_line_ends, another_delimiter, decimal_marks_mixed, numbers_ten_times, words_for_numbers,
    header_lost, header_garbled, another_unit, signs_and_zeros_moved, text_before_and_after, two_files_in_one,
    rows_shuffled, cells_lost, without_line_ends, one_endless_line, a_zip_bomb, an_unclosed_quote,
)  # fmt: skip


def damaged(seed: int) -> tuple[bytes, str]:
    """Return a damaged file, and what was done to what."""
    rng = random.Random(seed)
    writer, damage = WRITERS[seed // len(DAMAGE) % len(WRITERS)], DAMAGE[seed % len(DAMAGE)]
    text, encoding = writer(*press(rng))
    return damage(text, encoding, rng), f"{seed}: {writer.__name__}, {damage.__name__}"

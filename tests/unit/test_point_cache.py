"""The point cache: what is written is read back, whatever happens to the file in between."""

import resource
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.recording import PointCache, open_point_cache
from tests.point_cache import read_point_cache
from tools.environment import ROOT

HEADER = 32  # bytes
SAMPLES = np.random.default_rng(0).normal(size=(4, 3, 3)).astype(np.float32)
SIZE = SAMPLES[0].nbytes


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a file of four samples of three vertices."""
    with PointCache(tmp_path / "press.pc2", 3, start_frame=10.0) as cache:
        for sample in SAMPLES:
            cache.append(sample)
    return cache.path


def test_what_is_recorded_is_read_back(path: Path) -> None:
    start, samples = open_point_cache(path)
    assert start == 10.0 and samples.dtype == np.float32
    np.testing.assert_array_equal(samples, SAMPLES)


def test_the_file_is_a_pc2_file_byte_by_byte(path: Path) -> None:
    data = path.read_bytes()
    assert data[:HEADER] == b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 3, 10.0, 1.0, 4)
    assert data[HEADER:] == SAMPLES.astype("<f4").tobytes()


def test_a_file_cut_anywhere_gives_its_whole_samples_or_a_message(path: Path) -> None:
    data = path.read_bytes()
    for length in range(len(data)):
        path.write_bytes(data[:length])
        with pytest.raises(DimpleError, match="PC2"):
            open_point_cache(path)
        if length < HEADER:
            with pytest.raises(ValueError, match="not a PC2"):
                read_point_cache(path)
        else:
            samples = read_point_cache(path)[2]
            assert len(samples) == (length - HEADER) // SIZE
            np.testing.assert_array_equal(samples, SAMPLES[: len(samples)])


@pytest.mark.parametrize("shape", [(2, 3), (4, 3), (3, 2), (9,), (), (1, 3, 3), (0, 3)])
def test_a_sample_of_another_mesh_is_refused_and_harms_nothing(path: Path, shape: tuple[int, ...]) -> None:
    with PointCache(path, 3) as cache:
        cache.append(SAMPLES[0])
        with pytest.raises(DimpleError, match="3 vertices"):
            cache.append(np.zeros(shape))
        cache.append(SAMPLES[1])
    np.testing.assert_array_equal(read_point_cache(path)[2], SAMPLES[:2])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e39])
@pytest.mark.filterwarnings("ignore:overflow")
def test_coordinates_that_are_not_numbers_are_not_recorded(path: Path, value: float) -> None:
    with PointCache(path, 3) as cache:
        sample = SAMPLES[0].astype(float)
        sample[1, 2] = value
        with pytest.raises(DimpleError, match="Sample 1 "):
            cache.append(sample)
        cache.append(SAMPLES[0])
    np.testing.assert_array_equal(read_point_cache(path)[2], SAMPLES[:1])


@pytest.mark.parametrize(
    ("at", "value"),
    [(0, b"pointcache2\0"), (12, struct.pack("<i", 2)), (16, struct.pack("<i", -1)), (28, struct.pack("<i", -1)),
     (20, struct.pack("<f", np.nan)), (24, struct.pack("<f", np.inf)), (24, struct.pack("<f", 0.0))],
)  # fmt: skip
def test_a_damaged_header_is_refused(path: Path, at: int, value: bytes) -> None:
    data = bytearray(path.read_bytes())
    data[at : at + len(value)] = value
    path.write_bytes(data)
    with pytest.raises(DimpleError, match="PC2|not one a frame"):
        open_point_cache(path)


@pytest.mark.parametrize(("at", "value"), [(16, 2**31 - 1), (28, 2**31 - 1), (16, 0)])
def test_counts_other_than_those_of_the_file_are_refused(path: Path, at: int, value: int) -> None:
    data = bytearray(path.read_bytes())
    data[at : at + 4] = struct.pack("<i", value)
    path.write_bytes(data)
    with pytest.raises(DimpleError, match="cut short"):
        open_point_cache(path)


def test_a_random_file_never_raises_anything_but_a_message(path: Path) -> None:
    rng, data = np.random.default_rng(1), path.read_bytes()
    for _ in range(200):
        changed = bytearray(data)
        for at in rng.integers(0, len(data), 4):
            changed[at] = rng.integers(256)
        path.write_bytes(changed)
        try:
            assert open_point_cache(path)[1].size <= SAMPLES.size
        except DimpleError:
            pass


def test_a_missing_folder_is_said_by_name(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        PointCache(tmp_path / "nowhere" / "press.pc2", 3)


@pytest.mark.parametrize("size", [0, 16, HEADER, HEADER + SIZE - 1, HEADER + SIZE, HEADER + 2 * SIZE + 7])
def test_a_disk_that_fills_keeps_the_samples_before(tmp_path: Path, size: int) -> None:
    path, before = tmp_path / "press.pc2", resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        with pytest.raises(OSError), PointCache(path, 3) as cache:
            for sample in SAMPLES:
                cache.append(sample)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    if size >= HEADER:
        np.testing.assert_array_equal(read_point_cache(path)[2], SAMPLES[: (size - HEADER) // SIZE])


RECORDS_UNTIL_KILLED = """
import sys
import numpy as np
from core.recording import PointCache
cache = PointCache(sys.argv[1], 5000)
for number in range(100000):
    cache.append(np.full((5000, 3), number, np.float32))
    print(number, flush=True)
"""


def test_a_program_that_is_killed_while_it_records_leaves_whole_samples(tmp_path: Path) -> None:
    path = tmp_path / "press.pc2"
    run = subprocess.Popen(
        [sys.executable, "-c", RECORDS_UNTIL_KILLED, str(path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert run.stdout
    written = [int(run.stdout.readline()) for _ in range(50)][-1]
    run.kill()
    run.communicate()
    samples = read_point_cache(path)[2]
    assert len(samples) > written
    np.testing.assert_array_equal(samples, np.broadcast_to(np.arange(len(samples))[:, None, None], samples.shape))

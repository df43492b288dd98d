"""Compressed files: read as what is in them, within the limits, and not written."""

from __future__ import annotations

import bz2
import gzip
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from retime import FormatError, FormatWarning, Motion, Signal, read, sample, write
from retime.formats import Limits
from tests.formats.amc_files import AMC, ARM, read_amc

PACK = {".gz": gzip.compress, ".bz2": bz2.compress}


def packed(folder: Path, name: str, data: bytes) -> Path:
    (folder / name).write_bytes(PACK[Path(name).suffix.lower()](data))
    return folder / name


@pytest.mark.parametrize("ending", [".gz", ".bz2", ".GZ"])
@pytest.mark.parametrize("of", [".bvh", ".csv", ".npz", ".npy"])
def test_a_compressed_file_is_read_as_what_is_in_it(tmp_path: Path, of: str, ending: str) -> None:
    clip = sample()[:20] if of == ".bvh" else Signal(("x", "y"), np.random.default_rng(5).normal(size=(20, 2)), 25)
    plain = tmp_path / f"a.b{of}"
    with_names = of != ".npy"
    if with_names:
        write(clip, plain)
    else:
        np.save(plain, clip.values if isinstance(clip, Signal) else 0)
    (tmp_path / f"{plain.name}{ending}").write_bytes(PACK[ending.lower()](plain.read_bytes()))
    rate = None if with_names else 25
    one, other = read(plain, rate=rate), read(tmp_path / f"{plain.name}{ending}", rate=rate)
    assert (one.name, one.rate, one.n_frames) == (other.name, other.rate, other.n_frames) == ("a.b", clip.rate, 20)
    if isinstance(one, Motion) and isinstance(other, Motion):
        np.testing.assert_array_equal(one.rotations, other.rotations)
        np.testing.assert_array_equal(one.local_translations, other.local_translations)
    elif isinstance(one, Signal) and isinstance(other, Signal):
        np.testing.assert_array_equal(one.values, other.values)


@pytest.mark.parametrize("skeleton", ["arm.asf", "arm.asf.gz", "7.asf.bz2", "other.asf.gz"])
def test_an_amc_finds_its_asf_whichever_is_compressed(tmp_path: Path, plain: Motion, skeleton: str) -> None:
    if skeleton.endswith(".asf"):
        (tmp_path / skeleton).write_bytes(ARM.read_bytes())
    else:
        packed(tmp_path, skeleton, ARM.read_bytes())
    name = "07_01.amc.gz" if skeleton[0] == "7" else "arm.amc.gz"
    motion = read_amc(packed(tmp_path, name, (AMC / "plain.amc").read_bytes()))
    np.testing.assert_array_equal(motion.rotations, plain.rotations)
    # The skeleton is written beside the motion, under a name that tells what it is.
    out = tmp_path / "out"
    out.mkdir()
    write(motion, out / "again.amc")
    again = read_amc(out / "again.amc")
    np.testing.assert_allclose(again.local_translations, plain.local_translations, atol=1e-5)


def test_messages_name_the_file_that_is_there(tmp_path: Path) -> None:
    path = packed(tmp_path, "a.bvh.gz", b"HIERARCHY\nROOT r\n{\nOFFSET 0 0 x\n")
    with pytest.raises(FormatError, match=r"a\.bvh\.gz:4:12: OFFSET .*expected a number"):
        read(path)
    with pytest.raises(FormatError, match=r"known endings are \.bvh.*each may be followed by \.gz or \.bz2"):
        read(packed(tmp_path, "a.txt.gz", b"x"))
    with pytest.raises(FormatError, match="known endings"):
        read(packed(tmp_path, "a.gz", b"x"))


def csv_of(n_rows: int) -> bytes:
    return b"t,x\n" + b"".join(b"%.2f,%d\n" % (i / 100, i * i % 997) for i in range(n_rows))


@pytest.mark.parametrize("ending", [".gz", ".bz2"])
def test_what_is_cut_off_is_refused_or_repaired(tmp_path: Path, ending: str) -> None:
    whole = packed(tmp_path, f"a.csv{ending}", csv_of(400_000))
    data = whole.read_bytes()
    for name, broken in (("empty", b""), ("begun", data[:8]), ("other", b"time,x\n0,1\n0.1,2\n")):
        (tmp_path / f"{name}.csv{ending}").write_bytes(broken)
        for repair in (False, True):
            with pytest.raises(FormatError, match="compressed data"):
                read(tmp_path / f"{name}.csv{ending}", repair=repair)
    (tmp_path / f"cut.csv{ending}").write_bytes(data[: len(data) * 3 // 4])
    with pytest.raises(FormatError, match="damaged compressed data"):
        read(tmp_path / f"cut.csv{ending}")
    with pytest.warns(FormatWarning) as caught:
        kept = read(tmp_path / f"cut.csv{ending}", repair=True)
    assert "damaged compressed data" in str(caught[0].message)
    assert isinstance(kept, Signal)
    assert 100_000 < kept.n_frames < 400_000
    # The last row may be cut within a number.
    expected = np.arange(kept.n_frames - 1) ** 2 % 997
    np.testing.assert_array_equal(kept.values[:-1, 0], expected)


def test_a_wrong_checksum_is_damage(tmp_path: Path) -> None:
    data = bytearray(gzip.compress(csv_of(100)))
    data[-6] ^= 1
    (tmp_path / "a.csv.gz").write_bytes(data)
    with pytest.raises(FormatError, match="damaged compressed data: CRC"):
        read(tmp_path / "a.csv.gz")


@pytest.mark.parametrize("ending", [".gz", ".bz2"])
def test_a_bomb_is_refused_before_it_goes_off(tmp_path: Path, ending: str) -> None:
    bomb = packed(tmp_path, f"bomb.bvh{ending}", bytes(300 << 20))
    tracemalloc.start()
    with pytest.raises(FormatError, match=r"Limits\.zip_ratio"):
        read(bomb)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100 << 20


def test_limits_count_what_is_in_a_compressed_file(tmp_path: Path) -> None:
    path = packed(tmp_path, "a.csv.gz", csv_of(200_000))
    with pytest.raises(FormatError, match=r"more than 1000000 bytes.*Limits\.inflated_bytes"):
        read(path, limits=Limits(inflated_bytes=1_000_000))
    with pytest.raises(FormatError, match=r"beyond 2:1 \(Limits\.zip_ratio\)"):
        read(path, limits=Limits(zip_ratio=2))
    with pytest.raises(FormatError, match=r"Limits\.file_bytes"):
        read(path, limits=Limits(file_bytes=1000))
    # A small one may be all alike.
    alike = read(packed(tmp_path, "b.csv.gz", b"x\n" + b"0\n" * 100_000), rate=30)
    assert alike.n_frames == 100_000


@pytest.mark.parametrize(("ending", "packer"), [(".gz", "gzip"), (".bz2", "bzip2")])
def test_a_compressed_file_is_not_written(tmp_path: Path, ending: str, packer: str) -> None:
    with pytest.raises(FormatError, match=rf"write a\.bvh, then compress it \({packer} a\.bvh\)"):
        write(sample()[:5], tmp_path / f"a.bvh{ending}")
    assert list(tmp_path.iterdir()) == []

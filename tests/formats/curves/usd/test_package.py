"""usdz packages: what is packed is found again, aligned; what leads out of one, or bursts it, is refused."""

from __future__ import annotations

import zipfile
from io import BytesIO

import numpy as np
import pytest

from retime.errors import FormatError
from retime.formats.curves.usd.package import packed, unpacked
from retime.formats.read_options import Limits


def test_files_are_found_again_and_begin_at_multiples_of_64() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        files = {"root.usdc": rng.bytes(int(rng.integers(300)))}
        for i in range(int(rng.integers(6))):
            files["é" * int(rng.integers(1, 60)) + f"/{i}.png"] = rng.bytes(int(rng.integers(300)))
        data = packed(files)
        assert unpacked(data, Limits()) == files
        assert list(unpacked(data, Limits())) == list(files)
        for entry in zipfile.ZipFile(BytesIO(data)).infolist():
            name_length, extra_length = (
                int.from_bytes(data[entry.header_offset + i :][:2], "little") for i in (26, 28)
            )
            assert (entry.header_offset + 30 + name_length + extra_length) % 64 == 0


@pytest.mark.parametrize(
    "name", ["../a.usda", "/a.usda", "b/../../a.usda", "b\\a.usda", "c:a.usda", "b//a.usda", "./a.usda"]
)
def test_names_that_lead_out_are_refused(name: str) -> None:
    with pytest.raises(FormatError, match="may leave it"):
        unpacked(packed({"root.usda": b"#usda 1.0", name: b""}), Limits())


def test_what_is_no_package_is_refused() -> None:
    data = packed({"root.usda": b"#usda 1.0\n" * 20, "a.png": b"12"})
    for size in (0, 4, 100, len(data) - 30, len(data) - 1):
        with pytest.raises(FormatError):
            unpacked(data[:size], Limits())
    with pytest.raises(FormatError, match=r"Limits\.inflated_bytes"):
        unpacked(data, Limits(inflated_bytes=100))
    with pytest.raises(FormatError, match="is its root layer"):
        unpacked(packed({"a.png": b"12"}), Limits())
    changed = bytearray(data)
    changed[data.index(b"#usda")] ^= 1
    with pytest.raises(FormatError, match="CRC"):
        unpacked(bytes(changed), Limits())
    empty = BytesIO()
    zipfile.ZipFile(empty, "w").close()
    with pytest.raises(FormatError, match="no file in it"):
        unpacked(empty.getvalue(), Limits())

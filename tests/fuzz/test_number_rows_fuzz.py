"""Mutants of rows of numbers: the compiled reader takes what the one a field at a time takes, the same bits, no more.

``RETIME_FUZZ=200000 pytest tests/fuzz/test_number_rows_fuzz.py`` tries more of them than the suite does.
"""

from __future__ import annotations

import os
import random
import struct
from pathlib import Path

import pytest

from retime.errors import FormatError
from retime.formats import amc_frames, bvh_frames, read
from retime.formats.number_rows import parse_rows
from retime.formats.tables import table_rows
from retime.kernels import compiled_available
from tests.reference.number_rows import read_rows

pytestmark = pytest.mark.skipif(not compiled_available(), reason="there are no compiled kernels to compare")

N_MUTANTS = int(os.environ.get("RETIME_FUZZ", "4000"))
DATA = Path(__file__).resolve().parents[1] / "data"
LETTERS = [bytes([letter]) for letter in b"0123456789012345678901234567890123456789+-.eE,;\t \n\r_n#\x0b\x00\x80"]
PIECES = [b"\r\n", b"1e308", b"1e-400", b"1e100", b"nan", b"-0", b"9007199254740993", b"0" * 30, b".5", b"5.", b"--"]


def number(draw: random.Random) -> str:
    # Of any size, and written in every way that programs write numbers.
    value = draw.choice([draw.gauss(0, 50), draw.uniform(-1, 1) * 10 ** draw.randint(-30, 30), draw.randint(-999, 999)])
    return format(value, draw.choice([".6f", ".9f", "", ".17g", ".3e", "+.1f", ".0f", "E"]))


def mutant(draw: random.Random, delimiter: str) -> bytes:
    n_columns = draw.randint(1, 5)
    part = delimiter or draw.choice([" ", "\t", "  "])
    text = "".join(
        part.join(number(draw) for _ in range(n_columns)) + draw.choice(["\n", "\n", "\r\n", "\r"])
        for _ in range(draw.randint(0, 4))
    ).encode()
    for _ in range(draw.randint(0, 3)):
        text = mutated(draw, text)
    return text


def mutated(draw: random.Random, text: bytes) -> bytes:
    at = draw.randint(0, len(text))
    new = draw.choice(draw.choice([LETTERS, PIECES]))
    return text[:at] + draw.choice([new, b""]) + text[at + draw.choice([0, 0, 1, 3]) :]


def bits(rows: list[list[float]]) -> bytes:
    return b"".join(struct.pack("<d", value) for row in rows for value in row)


def test_rows() -> None:
    draw = random.Random(13)
    taken = left = 0
    for _ in range(N_MUTANTS):
        delimiter = draw.choice(["", ",", ";", "\t"])
        text, n_columns, comma = mutant(draw, delimiter), draw.randint(0, 4), draw.random() < 0.3
        longest = draw.choice([10, 1000, 1000])
        told = {"delimiter": delimiter, "decimal_comma": comma, "line_bytes": longest}
        careful = read_rows(text, n_columns, **told)
        table = parse_rows(text, n_columns, **told)
        if table is not None:
            assert careful is not None, text
            assert table.shape == (len(careful), len(careful[0]))
            assert table.tobytes() == bits(careful), text
            taken += 1
        elif careful is not None:
            # Below the smallest double: all that is left to the careful way.
            assert b"e-" in text.lower(), text
            assert 0.0 in [abs(value) for row in careful for value in row]
            left += 1
    assert taken > N_MUTANTS // 10
    print(f"{N_MUTANTS} mutants of rows: {taken} taken by both, {left} left to the careful way")


def outcome(path: Path, **options: object) -> object:
    try:
        return read(path, **options)
    except FormatError as error:
        return str(error), error.line, error.column


SEEDS = {
    "bvh": sorted((DATA / "bvh").glob("*.bvh")),
    "csv": sorted((DATA / "csv").glob("*.csv")),
    "amc": sorted((DATA / "amc").glob("*.amc")),
}


@pytest.mark.filterwarnings("ignore::retime.RetimeWarning")
@pytest.mark.parametrize("kind", list(SEEDS))
def test_files(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whole files come out the same, message, line and column too, as without the fast way."""
    draw = random.Random(kind)
    seeds = [(path, path.read_bytes()) for path in SEEDS[kind] if path.stat().st_size < 20_000]
    if not seeds:
        pytest.skip(f"no test data of the kind {kind}")
    refused = 0
    for _ in range(N_MUTANTS // 20):
        source, data = draw.choice(seeds)
        text = data
        for _ in range(draw.randint(0, 2)):
            # Mostly among the numbers, which stand at the end.
            front = draw.choice([0, len(text) // 2, len(text) * 3 // 4])
            text = text[:front] + mutated(draw, text[front:])
        path = tmp_path / f"mutant.{kind}"
        path.write_bytes(text)
        options: dict[str, object] = {"repair": draw.random() < 0.3, "decimal_comma": draw.random() < 0.2}
        if draw.random() < 0.5:
            options["rate"] = 30
        if kind == "amc":
            options["skeleton"] = next(source.parent.glob("*.asf"))
        # So that short files are long ones, whose frames go from the text right to the joints.
        monkeypatch.setattr(bvh_frames, "_BLOCK", draw.choice([20, 200, 2000]))
        fast = outcome(path, **options)
        with monkeypatch.context() as slow:
            for module in (bvh_frames, table_rows, amc_frames):
                slow.setattr(module, "parse_rows", lambda *_, **__: None)
            careful = outcome(path, **options)
        if isinstance(careful, tuple):
            assert fast == careful, text
            refused += 1
        else:
            assert same(fast, careful), text
    print(f"{N_MUTANTS // 20} mutants of {kind} files, {refused} refused, with the same words")


def same(a: object, b: object) -> bool:
    return type(a) is type(b) and all(
        getattr(a, name).tobytes() == getattr(b, name).tobytes()
        for name in ("rotations", "local_translations", "declared_angles", "values")
        if getattr(b, name, None) is not None
    )

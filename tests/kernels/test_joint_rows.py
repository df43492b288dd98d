"""Joints right from text: what rows that are read first and turned then give, as far as it goes, the same bits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from retime.kernels import JointArrays, JointChannels, RowFormat, TurnedJoints, backend, compiled_available
from retime.motion.rotation import MANY_DEGREES
from retime.motion.size import LARGEST

pytestmark = pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")
N_JOINTS = 5


def plain(n_columns: int, *, decimal_comma: bool = False, line_bytes: int = 1000) -> RowFormat:
    return RowFormat(n_columns, "", decimal_comma, LARGEST, line_bytes)


def some_channels(generator: np.random.Generator) -> tuple[JointChannels, int]:
    """Joints in two orders, and some coordinates, among columns in any order; and how many columns there are."""
    n_places = int(generator.integers(0, 3 * N_JOINTS + 1))
    n_columns = 3 * N_JOINTS + n_places + int(generator.integers(0, 3))
    columns, joints = generator.permutation(n_columns), generator.permutation(N_JOINTS)
    split = int(generator.integers(0, N_JOINTS + 1))
    turned = tuple(
        TurnedJoints(order, some, columns[: 3 * N_JOINTS].reshape(-1, 3)[some], MANY_DEGREES)
        for order, some in (("ZXY", joints[:split]), ("YZX", joints[split:]))
    )
    places = generator.permutation(3 * N_JOINTS)[:n_places]
    coordinates = columns[3 * N_JOINTS : 3 * N_JOINTS + n_places]
    return JointChannels(turned, coordinates, places, generator.normal(size=(N_JOINTS, 3))), n_columns


def some_rows(generator: np.random.Generator, n_rows: int, n_columns: int) -> list[list[float]]:
    rows = generator.normal(scale=90, size=(n_rows, n_columns)).round(int(generator.integers(0, 9)))
    rows[generator.random(rows.shape) < 0.02] = 1e20
    return rows.tolist()


def room(n_rows: int) -> JointArrays:
    return JointArrays(
        np.zeros((n_rows, N_JOINTS, 4)), np.zeros((n_rows, N_JOINTS, 3)), np.zeros((n_rows, N_JOINTS, 3))
    )


def by_steps(rows: list[list[float]], channels: JointChannels) -> JointArrays:
    """Turn and place joints by a table of all numbers."""
    table, into = np.array(rows).reshape(len(rows), -1), room(len(rows))
    for row in range(len(rows)):
        into.translations[row] = channels.offsets
        for column, place in zip(channels.columns, channels.places, strict=True):
            into.translations[row, place // 3, place % 3] = table[row, column]
    for turned in channels.turned:
        backend("numpy").turn_joints(table, turned, into.angles, into.rotations)
    return into


def same(found: JointArrays, expected: JointArrays, n_rows: int) -> bool:
    return all(
        getattr(found, name)[:n_rows].tobytes() == getattr(expected, name)[:n_rows].tobytes()
        for name in ("rotations", "translations", "angles")
    )


@pytest.mark.parametrize("threads", [1, 2, 3, 7])
@pytest.mark.parametrize("seed", range(4))
def test_rows_become_joints(monkeypatch: pytest.MonkeyPatch, seed: int, threads: int) -> None:
    monkeypatch.setenv("RETIME_THREADS", str(threads))
    generator = np.random.default_rng(seed)
    channels, n_columns = some_channels(generator)
    rows = some_rows(generator, int(generator.integers(1, 400)), n_columns)
    ending = ["\n", "\r\n"][seed % 2]
    front = "frames: 1 2 3\n"
    text = (front + ending.join(" ".join(map(repr, row)) for row in rows) + ["", ending][seed // 2]).encode()
    expected = by_steps(rows, channels)
    for piece_bytes in (1, 1000, 1 << 20):
        into = room(len(rows) + seed)
        told = len(front), piece_bytes, plain(n_columns), channels, into
        assert backend("compiled").read_joint_rows(text, *told) == (len(rows), len(text) - len(front))
        assert same(into, expected, len(rows))


Spoil = Callable[[list[bytes], int], None]


def put_in(line: bytes) -> Spoil:
    return lambda lines, at: lines.insert(at, line)


def change(old: bytes, new: bytes, count: int = 1) -> Spoil:
    def spoil(lines: list[bytes], at: int) -> None:
        lines[at] = lines[at].replace(old, new, count)

    return spoil


@pytest.mark.parametrize(
    "spoil",
    [put_in(b""), put_in(b"  \t"), put_in(b"1 2 3"), put_in(b"0 " * 2000), change(b" ", b" x", 1), change(b" ", b"\n"),
     change(b" ", b"\r"), change(b"e+20", b"e+200"), put_in(b"nan"), put_in(b"\r"), put_in(b"1\0")],
)  # fmt: skip
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("seed", range(3))
def test_it_stops_before_a_piece_with_anything_else(
    monkeypatch: pytest.MonkeyPatch, spoil: Spoil, seed: int, threads: int
) -> None:
    monkeypatch.setenv("RETIME_THREADS", str(threads))
    generator = np.random.default_rng(seed)
    channels, n_columns = some_channels(generator)
    rows = some_rows(generator, 300, n_columns)
    at = int(generator.integers(0, len(rows)))
    rows[at][3] = 1e20
    lines = [" ".join(map(repr, row)).encode() for row in rows]
    spoil(lines, at)
    text = b"\n".join(lines) + b"\n"
    piece_bytes = 700
    # As the pieces are cut, the one that holds the changed line ends all.
    start = 0
    place = len(b"\n".join(lines[:at])) + (at > 0)
    while (stop := text.find(b"\n", start + piece_bytes) + 1) <= place and stop:
        start = stop
    n_before = text[:start].count(b"\n")
    into = room(len(rows))
    found = backend("compiled").read_joint_rows(text, 0, piece_bytes, plain(n_columns), channels, into)
    assert found == (n_before, start)
    assert same(into, by_steps(rows[:n_before], channels), n_before)


def test_it_stops_before_a_piece_that_has_no_room() -> None:
    generator = np.random.default_rng(0)
    channels, n_columns = some_channels(generator)
    rows = some_rows(generator, 100, n_columns)
    text = b"".join(" ".join(map(repr, row)).encode() + b"\n" for row in rows)
    for capacity in (0, 1, 60, 99):
        into = room(capacity + 1)
        some = JointArrays(into.rotations[:capacity], into.translations[:capacity], into.angles[:capacity])
        found = backend("compiled").read_joint_rows(text, 0, 1000, plain(n_columns), channels, some)
        assert found is not None
        n_rows, n_bytes = found
        assert capacity - 10 <= n_rows <= capacity
        assert text[:n_bytes].count(b"\n") == n_rows
        # What is behind the room is left alone.
        assert not into.rotations[capacity:].any()


def test_a_text_without_line_feeds_is_not_looked_through() -> None:
    channels, n_columns = some_channels(np.random.default_rng(0))
    rows = some_rows(np.random.default_rng(1), 100, n_columns)
    text = b"".join(" ".join(map(repr, row)).encode() + b"\r" for row in rows)
    told = plain(n_columns), channels, room(len(rows))
    assert backend("compiled").read_joint_rows(text, 0, 1000, *told) == (0, 0)


def test_a_decimal_comma_is_taken_where_it_was_said() -> None:
    channels, n_columns = some_channels(np.random.default_rng(2))
    row = np.arange(n_columns) + 0.5
    text = " ".join(map(str, row.tolist())).replace(".", ",").encode()
    into = room(1)
    for comma, found in ((False, (0, 0)), (True, (1, len(text)))):
        rows = plain(n_columns, decimal_comma=comma)
        assert backend("compiled").read_joint_rows(text, 0, 100, rows, channels, into) == found
    assert same(into, by_steps([row.tolist()], channels), 1)

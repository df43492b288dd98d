"""BVH: any motion comes back from its file, and any damage ends in a motion or in a FormatError."""

from __future__ import annotations

import random
import warnings
from dataclasses import replace
from fractions import Fraction
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import FormatError, FormatWarning
from retime.formats import Limits, ReadOptions, write
from retime.formats.bvh import BvhDeclaration, read
from retime.motion.euler import angle_between
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from tests.motion.strategies import motions

DATA = Path(__file__).resolve().parents[1] / "data/bvh"
TURNS = [[f"{axis}rotation" for axis in order] for n in range(4) for order in permutations("XYZ", n)]
MOVES = [[f"{axis}position" for axis in order] for n in range(4) for order in permutations("XYZ", n)]


def write_and_read(motion: Motion, folder: Path) -> Motion:
    path = folder / "motion.bvh"
    write(motion, path, overwrite=True)
    return read(path, path.read_bytes(), ReadOptions())


def in_file_order(skeleton: Skeleton) -> list[int]:
    """List joints parent by parent, by asking each for its children."""
    order: list[int] = []

    def visit(joint: int) -> None:
        order.append(joint)
        for child in skeleton.children(joint):
            visit(child)

    visit(0)
    return order


@settings(max_examples=40)
@given(motion=motions(), name=st.text(min_size=1, max_size=8))
def test_a_motion_from_elsewhere_comes_back(
    motion: Motion, name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    names = tuple(f"{n}{name}." for n in motion.skeleton.names)
    skeleton = replace(motion.skeleton, names=names)
    motion = replace(motion, skeleton=skeleton)
    with warnings.catch_warnings():
        # Some names can't be held; what becomes of them is another test.
        warnings.simplefilter("ignore", FormatWarning)
        again = write_and_read(motion, tmp_path_factory.getbasetemp())
    order = in_file_order(skeleton)
    if not set(name) & {"\r", "\n"} and name.isprintable():
        assert again.skeleton.names == tuple(names[joint] for joint in order)
    assert again.rate == motion.rate
    assert [order[parent] if parent >= 0 else -1 for parent in again.skeleton.parents] == [
        skeleton.parents[joint] for joint in order
    ]
    np.testing.assert_array_equal(again.skeleton.offsets, skeleton.offsets[order])
    np.testing.assert_allclose(again.local_translations, motion.local_translations[:, order], rtol=0, atol=0.6e-6)
    # Six decimals of a degree, three times.
    assert np.degrees(angle_between(again.rotations, motion.rotations[:, order])).max() < 2e-6
    ends = sorted(skeleton.end_sites, key=lambda site: order.index(site.parent))
    assert [site.offset for site in again.skeleton.end_sites] == [site.offset for site in ends]


@st.composite
def declared_motions(draw: st.DrawFn) -> tuple[Motion, np.ndarray]:
    """A file's own numbers: joints in file order, any channels in any order, angles of any size."""
    motion = draw(motions())
    n_joints = motion.skeleton.n_joints
    parents = (-1, *(draw(st.integers(joint - 1, joint - 1)) for joint in range(1, n_joints)))
    channels = []
    for _ in range(n_joints):
        names = [*draw(st.sampled_from(MOVES)), *draw(st.sampled_from(TURNS))]
        channels.append(tuple(draw(st.permutations(names))))
    if not any(channels):
        channels[0] = ("Zrotation",)
    width = sum(map(len, channels))
    number = st.one_of(st.sampled_from([0.0, 90.0, -90.0, 180.0, 270.0, 1e-6, 450.0]), st.floats(-2000, 2000))
    rows = draw(st.lists(st.lists(number, min_size=width, max_size=width), min_size=1, max_size=4))
    values = np.round(np.array(rows), 6)
    text = ["HIERARCHY\n"]
    for joint, names in enumerate(channels):
        keyword = "JOINT" if joint else "ROOT"
        offset = " ".join(map(repr, motion.skeleton.offsets[joint].tolist()))
        text.append(f"{keyword} j{parents[joint]}\n{{\nOFFSET {offset}\nCHANNELS {len(names)} {' '.join(names)}\n")
    text.append("}\n" * n_joints + f"MOTION\nFrames: {len(values)}\nFrame Time: 0.04\n")
    text += [" ".join(f"{value:.6f}" for value in row) + "\n" for row in values]
    return read(Path("declared.bvh"), "".join(text).encode(), ReadOptions()), values


@settings(max_examples=40)
@given(declared=declared_motions())
def test_the_numbers_of_a_file_come_back(
    declared: tuple[Motion, np.ndarray], tmp_path_factory: pytest.TempPathFactory
) -> None:
    motion, values = declared
    path = tmp_path_factory.getbasetemp() / "declared.bvh"
    write(motion, path, overwrite=True)
    rows = path.read_bytes().split(b"Frame Time: 0.04\n")[1].split()
    np.testing.assert_allclose(np.array(rows, dtype=float).reshape(values.shape), values, rtol=0, atol=1e-6)
    again = read(path, path.read_bytes(), ReadOptions())
    assert again.declaration == motion.declaration
    np.testing.assert_array_equal(again.rotations, motion.rotations)


@settings(max_examples=40)
@given(declared=declared_motions(), share=st.floats(0, 1))
def test_what_three_channels_hold_survives_resampling(
    declared: tuple[Motion, np.ndarray], share: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    motion, _ = declared
    resampled = motion.at(np.array([share * motion.end_time, 0.0]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        again = write_and_read(resampled, tmp_path_factory.getbasetemp())
    assert motion.declaration is not None
    for joint, names in enumerate(motion.declaration.channels):
        if sum(name.endswith("rotation") for name in names) == 3:
            assert np.degrees(angle_between(again.rotations, resampled.rotations))[:, joint].max() < 2e-6


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Flip, drop, repeat or insert bytes, or cut the end off; sometimes more than one of them."""
    for _ in range(chance.choice([1, 1, 2, 5])):
        place = chance.randrange(len(data) + 1)
        what = chance.randrange(7)
        if what == 0:
            data = data[:place] + bytes([chance.randrange(256)]) + data[place + 1 :]
        elif what == 1:
            data = data[:place]
        elif what == 2:
            data = data[:place] + data[place + chance.randrange(1, 40) :]
        elif what == 3:
            start = chance.randrange(len(data) + 1)
            data = data[:place] + data[start : start + chance.randrange(1, 60)] + data[place:]
        elif what == 4:
            inserted = [
                b"{",
                b"}",
                b"nan",
                b"-",
                b"1e999",
                b"\x00",
                b"\xff\xfe",
                b"ROOT x",
                b"\r",
                b"9" * 30,
                b" ",
                b",",
            ]
            data = data[:place] + chance.choice(inserted) + data[place:]
        elif what == 5:
            words = data.split(b" ")
            first, second = chance.randrange(len(words)), chance.randrange(len(words))
            words[first], words[second] = words[second], words[first]
            data = b" ".join(words)
        else:
            lines = data.splitlines(keepends=True) or [b""]
            del lines[chance.randrange(len(lines))]
            data = b"".join(lines)
    return data


@pytest.mark.parametrize(
    "name", ["plain", "blender_two_roots", "crlf", "names_cjk", "rows_wrapped", "utf16_little_endian"]
)
def test_damage_ends_in_a_motion_or_a_format_error(name: str) -> None:
    data = (DATA / f"{name}.bvh").read_bytes()
    chance = random.Random(name)
    read_anyway = 0
    for i in range(400):
        mutant = damaged(data, chance)
        options = ReadOptions(
            repair=i % 3 == 0,
            decimal_comma=i % 5 == 0,
            rate=Fraction(30) if i % 7 == 0 else None,
            limits=Limits(line_bytes=120, joints=6, frames=20) if i % 11 == 0 else Limits(),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                motion = read(Path("mutant.bvh"), mutant, options)
            except FormatError as error:
                message = str(error)
            else:
                message = "mutant.bvh: read"
                read_anyway += 1
                assert motion.n_frames >= 1
                assert np.isfinite(global_poses(motion).positions).all()
        assert message.startswith("mutant.bvh:")
    # Both ends are reached, or the damage would show nothing.
    assert 5 < read_anyway < 395


def test_every_cut_of_a_file_is_refused_or_warned_of() -> None:
    """Cut at every byte: only a cut into the last number, or in white space after it, can go unseen."""
    data = (DATA / "plain.bvh").read_bytes()
    for end in range(len(data)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                motion = read(Path("cut.bvh"), data[:end], ReadOptions())
            except (FormatError, FormatWarning):
                continue
        assert end >= len(data) - len(b"0.0\n")
        assert motion.n_frames == 2


def test_declarations_are_compared_by_value() -> None:
    channels = (("Zrotation",),)
    assert BvhDeclaration("bvh", channels, "0.1") == BvhDeclaration("bvh", channels, "0.1")
    assert BvhDeclaration("bvh", channels, "0.1") != BvhDeclaration("bvh", channels, "0.1", encoding="latin-1")

"""AMC and ASF written: what was read comes back, and any other skeleton gets an ASF of its own."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.formats import read, write
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton
from tests.formats.amc_files import AMC, ARM, ASF, MOCAP, needs_mocap, read_amc


@pytest.mark.parametrize("name", ["plain", "crlf", "cr_only", "lower_case_keywords"])
def test_a_file_comes_back_byte_for_byte(tmp_path: Path, name: str) -> None:
    path = AMC / f"{name}.amc"
    write(read_amc(path), tmp_path / "out.amc")
    assert (tmp_path / "out.amc").read_bytes() == path.read_bytes()
    assert (tmp_path / "out.asf").read_bytes() == ARM.read_bytes()


def test_radians_come_back(tmp_path: Path) -> None:
    motion = read_amc(AMC / "radians.amc")
    write(motion, tmp_path / "out.amc")
    assert b":RADIANS" in (tmp_path / "out.amc").read_bytes()
    assert read_amc(tmp_path / "out.amc").declared_angles == pytest.approx(motion.declared_angles, abs=1e-9)


def test_a_cut_keeps_its_frame_numbers_and_a_sampled_motion_counts_from_1(tmp_path: Path, plain: Motion) -> None:
    write(plain.frames(1, 3), tmp_path / "cut.amc")
    assert read_amc(tmp_path / "cut.amc").first_frame == 2
    write(plain.at(np.array([0.0, 0.004, 0.01])), tmp_path / "sampled.amc")
    assert read_amc(tmp_path / "sampled.amc").first_frame == 1


def test_an_asf_that_fits_is_left_alone(tmp_path: Path, plain: Motion) -> None:
    asf = tmp_path / "02.asf"
    # The same skeleton in other words.
    asf.write_bytes((ASF / "comments_and_commas.asf").read_bytes())
    write(plain, tmp_path / "02_01.amc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["02.asf", "02_01.amc"]
    assert read_amc(tmp_path / "02_01.amc").rotations == pytest.approx(plain.rotations)


def test_an_asf_that_does_not_fit_is_neither_used_nor_replaced(tmp_path: Path, plain: Motion) -> None:
    other = ARM.read_bytes().replace(b"length 5", b"length 6")
    (tmp_path / "02.asf").write_bytes(other)
    write(plain, tmp_path / "02_01.amc")
    assert (tmp_path / "02.asf").read_bytes() == other
    assert (tmp_path / "02_01.asf").read_bytes() == ARM.read_bytes()
    assert read_amc(tmp_path / "02_01.amc").skeleton.offsets.tolist() == plain.skeleton.offsets.tolist()
    # An ASF of the very stem would be taken for this AMC's.
    (tmp_path / "03.ASF").write_bytes(other)
    with pytest.raises(OutputExistsError, match=r"03\.ASF"):
        write(plain, tmp_path / "03.amc")
    assert not (tmp_path / "03.amc").exists()
    write(plain, tmp_path / "03.amc", overwrite=True)
    assert (tmp_path / "03.ASF").read_bytes() == ARM.read_bytes()


def test_nothing_is_written_where_the_amc_is_there(tmp_path: Path, plain: Motion) -> None:
    (tmp_path / "a.amc").write_text("mine")
    with pytest.raises(OutputExistsError):
        write(plain, tmp_path / "a.amc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.amc"]
    assert (tmp_path / "a.amc").read_text() == "mine"


def test_no_asf_stays_behind_where_the_amc_fails(tmp_path: Path, plain: Motion) -> None:
    (tmp_path / "a.amc").mkdir()
    with pytest.raises(OSError):  # noqa: PT011 (which one is the platform's choice)
        write(plain, tmp_path / "a.amc", overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a.amc"]


def test_a_signal_is_no_amc(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="holds a motion"):
        write(Signal(("a",), np.zeros((2, 1))), tmp_path / "a.amc")


angle = st.floats(-179.9, 179.9, allow_nan=False).map(lambda value: round(value, 6))


@settings(deadline=None, max_examples=30)
@given(frames=st.lists(st.tuples(*[angle] * 9), min_size=1, max_size=4))
def test_angles_come_back(tmp_path_factory: pytest.TempPathFactory, frames: list[tuple[float, ...]]) -> None:
    folder = tmp_path_factory.mktemp("amc")
    lines = [":FULLY-SPECIFIED", ":DEGREES"]
    for number, a in enumerate(frames, 1):
        lines += [str(number), "root 0 0 0 {:.6f} {:.6f} {:.6f}".format(*a[:3])]
        lines += ["upper {:.6f} {:.6f} {:.6f}".format(*a[3:6]), f"lower {a[6]:.6f}", f"hand {a[7]:.6f} {a[8]:.6f}"]
    (folder / "a.amc").write_text("\n".join(lines))
    motion = read_amc(folder / "a.amc", skeleton=ARM)
    write(motion, folder / "b.amc")
    again = read_amc(folder / "b.amc", skeleton=ARM)
    assert np.rad2deg(again.declared_angles) == pytest.approx(np.rad2deg(motion.declared_angles), abs=1e-6)
    # Without the file's angles to stay close to, others may be found; they must mean the same.
    write(replace(motion, declared_angles=None), folder / "c.amc")
    other = read_amc(folder / "c.amc", skeleton=ARM)
    assert np.abs(np.sum(other.rotations * motion.rotations, axis=-1)) == pytest.approx(1.0, abs=1e-12)


def test_turns_that_the_asf_does_not_free_are_written_as_near_as_can_be(tmp_path: Path, plain: Motion) -> None:
    away = rotation.from_euler("XYZ", np.deg2rad([[0.5, -0.4, 0.3], [20.0, 30.0, -40.0], [0, 0, 0]]))
    rotations = plain.rotations.copy()
    for joint in (2, 3):
        rotations[:, joint] = rotation.multiply(rotations[:, joint], away)
    bent = replace(plain, rotations=rotations)
    with pytest.warns(
        FormatWarning, match=r"joint '(lower|hand)' is off by up to [\d.]+ degrees, at frame 1 \(the largest of 2"
    ):
        write(bent, tmp_path / "a.amc")
    again = read_amc(tmp_path / "a.amc")

    def apart(joint: int, frame: int, turned: np.ndarray) -> float:
        return float(2 * np.arccos(min(1.0, abs(np.sum(rotations[frame, joint] * turned)))))

    # A search over the free angles finds nothing nearer.
    c = {
        2: rotation.from_euler("ZYX", np.deg2rad([20.0, 0, 0])),
        3: rotation.from_euler("ZYX", np.deg2rad([20.0, 0, -90])),
    }
    for joint, order in ((2, "X"), (3, "ZX")):
        for frame in range(2):

            def cost(angles: np.ndarray, joint: int = joint, order: str = order, frame: int = frame) -> float:
                turned = rotation.from_euler(order, angles)
                own = rotation.multiply(rotation.multiply(c[joint], turned), rotation.conjugate(c[joint]))
                return apart(joint, frame, own)

            starts = np.random.default_rng(7).uniform(-3, 3, (6, len(order)))
            best = min(minimize(cost, start, method="Nelder-Mead").fun for start in starts)
            assert apart(joint, frame, again.rotations[frame, joint]) <= best + 1e-6
    assert again.rotations[2] == pytest.approx(plain.rotations[2])


def test_a_joint_that_moves_away_is_refused(tmp_path: Path, plain: Motion) -> None:
    translations = plain.local_translations.copy()
    translations[1, 2, 0] += 0.25
    with pytest.raises(FormatError, match=r"joint 'lower' is 0\.25 units from its place at frame 1, .*write a BVH"):
        write(replace(plain, translations=translations), tmp_path / "a.amc")
    assert list(tmp_path.iterdir()) == []


# A skeleton from elsewhere


def elsewhere(names: tuple[str, ...]) -> Motion:
    """A root with two legs, one of them at its place, and a spine that forks; two end sites on a hand."""
    skeleton = Skeleton(
        names,
        (-1, 0, 0, 2, 3, 3, 3),
        np.array([[0, 1, 0], [0, 0, 0], [0, 2, 0.5], [0, 3, 0], [1, 2, 0], [-1, 2, 0], [1, 2, 0]], dtype=float),
        (EndSite(1, (0, -4, 0)), EndSite(4, (1, 0, 0)), EndSite(4, (1, 1, 0)), EndSite(6, (0, 0, 2))),
    )
    rng = np.random.default_rng(5)
    rotations = rotation.normalize(rng.normal(size=(6, 7, 4)))
    translations = np.broadcast_to(skeleton.offsets, (6, 7, 3)).copy()
    translations[:, 0] = rng.normal(size=(6, 3))
    return Motion(skeleton, rotations, translations, rate=Fraction(30), metres_per_unit=0.01)


def test_a_skeleton_from_elsewhere_gets_an_asf(tmp_path: Path) -> None:
    motion = elsewhere(("Hips", "Leg", "Spine", "Chest", "LeftArm", "RightArm", "Pack"))
    write(motion, tmp_path / "a.amc")
    again = read(tmp_path / "a.amc")
    assert isinstance(again, Motion)
    assert_same_places(motion, again, 1e-8)
    assert again.rate == 30
    assert again.metres_per_unit == pytest.approx(0.01)
    # Joints that stand in one place share a helper; the end sites of a hand have one each.
    helpers = set(again.skeleton.names) - set(motion.skeleton.names) - {"root"}
    assert helpers == {
        "root_to_Spine",
        "Chest_to_LeftArm",
        "Chest_to_RightArm",
        "LeftArm_to_end",
        "LeftArm_to_end_2",
    }
    ends = global_poses(again).end_positions
    for site in range(4):
        expected = global_poses(motion).end_positions[:, site]
        assert min(np.abs(ends[:, i] - expected).max() for i in range(ends.shape[1])) < 1e-8
    # It is an AMC like any other from here on.
    write(again, tmp_path / "b.amc")
    assert (tmp_path / "b.amc").read_bytes() == (tmp_path / "a.amc").read_bytes()


def test_names_that_an_asf_cannot_hold_are_renamed_and_said(tmp_path: Path) -> None:
    motion = elsewhere(("Hips", "left leg", "root", "12", "arm#", "end", "arm#"))
    with pytest.warns(
        FormatWarning, match=r"can't hold 6 of the joints' names; renamed 'left leg' to 'left_leg', 'root' to"
    ):
        write(motion, tmp_path / "a.amc")
    again = read(tmp_path / "a.amc")
    renamed = ("Hips", "left_leg", "root_2", "_12", "arm_", "end_2", "arm__2")
    named = replace(motion, skeleton=replace(motion.skeleton, names=renamed))
    assert_same_places(named, again, 1e-8)


def test_a_motion_whose_skeleton_was_changed_gets_an_asf_of_its_own(tmp_path: Path, plain: Motion) -> None:
    skeleton = replace(plain.skeleton, offsets=plain.skeleton.offsets * 2)
    translations = plain.local_translations * 2
    longer = replace(plain, skeleton=skeleton, translations=translations)
    write(longer, tmp_path / "a.amc")
    assert_same_places(longer, read_amc(tmp_path / "a.amc"), 1e-7)


def test_angles_made_up_for_a_skeleton_from_elsewhere_change_little_between_frames(tmp_path: Path) -> None:
    # A slow turn that passes the right angle of the middle axis, where plain angles jump by half a turn.
    skeleton = Skeleton(("a", "b"), (-1, 0), np.array([[0.0, 0, 0], [0, 1, 0]]))
    angles = np.stack([np.full(200, 0.3), np.linspace(-4, 4, 200), np.full(200, -0.2)], axis=-1)
    rotations = np.stack([rotation.from_euler("ZYX", angles)] * 2, axis=1)
    write(Motion(skeleton, rotations, rate=Fraction(120)), tmp_path / "a.amc")
    written = read_amc(tmp_path / "a.amc").declared_angles
    assert written is not None
    assert np.rad2deg(np.abs(np.diff(written, axis=0))).max() < 3


@needs_mocap
@pytest.mark.parametrize("name", ["02_04", "86_01"])
def test_cmu_comes_back_number_for_number(tmp_path: Path, name: str) -> None:
    path = MOCAP / f"cmu-asfamc/{name}.amc"
    write(read_amc(path), tmp_path / f"{name}.amc")
    # Some C libraries write exponents of three digits.
    expected = re.sub(rb"e-0(\d\d)\b", rb"e-\1", path.read_bytes())
    assert (tmp_path / f"{name}.amc").read_bytes() == expected
    assert (tmp_path / f"{name}.asf").read_bytes() == (MOCAP / f"cmu-asfamc/{name[:2]}.asf").read_bytes()


@needs_mocap
@pytest.mark.parametrize(
    "name", ["cmu-bvh/02_04", "cmu-bvh/35_17", "bvh-other/dab", "bvh-other/makehuman_walk1", "bvh-other/test_mocapbank"]
)
def test_a_bvh_written_as_amc_keeps_its_positions(tmp_path: Path, name: str) -> None:
    motion = read(MOCAP / f"{name}.bvh")
    assert isinstance(motion, Motion)
    write(motion, tmp_path / "out.amc")
    again = read(tmp_path / "out.amc", rate=motion.rate)
    assert isinstance(again, Motion)
    assert_same_places(motion, again, 1e-7 * np.abs(global_poses(motion).positions).max())


def assert_same_places(motion: Motion, again: Motion, tolerance: float) -> None:
    assert again.n_frames == motion.n_frames
    ours, theirs = global_poses(motion), global_poses(again)
    for joint, name in enumerate(("root", *motion.skeleton.names[1:])):
        place = theirs.positions[:, again.skeleton.index(name)]
        assert np.abs(ours.positions[:, joint] - place).max() <= tolerance, name

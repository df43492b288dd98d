"""Motions as values, and their sampling between frames."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from retime.data import sample
from retime.errors import InvalidMotionError, OptionError
from retime.frames import frame_positions
from retime.motion import rotation
from retime.motion.flights import flights
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from tests.motion.strategies import RATES, motions
from tests.reference.sampling import frame_place

ARM = Skeleton(("upper", "lower"), (-1, 0), np.array([[0.0, 1.0, 0.0], [2.0, 0.0, 0.0]]))


def arm(n_frames: int = 3, **changes) -> Motion:
    angles = np.linspace(0.0, 1.0, n_frames)[:, None] * np.array([1.0, -0.5])
    parts = {
        "rotations": rotation.about_axis(2, angles),
        "translations": np.arange(n_frames * 6.0).reshape(n_frames, 2, 3),
        "rate": Fraction(10),
        **changes,
    }
    return Motion(ARM, **parts)


class TestConstruction:
    def test_translations_left_out_are_the_rest_offsets(self) -> None:
        motion = arm(4, translations=None)
        assert np.array_equal(motion.local_translations, np.broadcast_to(ARM.offsets, (4, 2, 3)))

    def test_counts_and_duration(self) -> None:
        assert (arm(4).n_frames, arm(4).duration, arm(1).duration) == (4, 0.4, 0.1)
        assert (arm(4).end_time, arm(1).end_time) == (0.3, 0.0)

    def test_a_duration_is_exact_where_the_rate_is_a_fraction(self) -> None:
        motion = arm(30001, rate=Fraction(30000, 1001))
        assert motion.end_time == 1001.0
        assert arm(30000, rate=Fraction(30000, 1001)).duration == 1001.0

    def test_rotations_are_scaled_to_unit_length(self) -> None:
        rotations = arm(2).rotations * np.array([[[3.0], [1e-200]], [[1e200], [1.0]]])
        np.testing.assert_allclose(arm(2, rotations=rotations).rotations, arm(2).rotations, rtol=1e-15)

    @pytest.mark.parametrize("error", [-1e-3, -1e-9, -1e-11, 1e-11, 1e-9, 1e-3])
    def test_however_little_they_are_off(self, error: float) -> None:
        q = arm(3).rotations
        np.testing.assert_allclose(arm(3, rotations=q * (1 + error)).rotations, q, rtol=0, atol=1e-15)

    def test_unit_rotations_are_kept_bit_for_bit(self) -> None:
        rotations = Rotation.random(6, rng=1).as_quat(scalar_first=True).reshape(3, 2, 4)
        assert np.array_equal(arm(3, rotations=rotations).rotations, rotations)

    @pytest.mark.parametrize("name", ["rotations", "translations", "declared_angles"])
    def test_arrays_cannot_be_written(self, name: str) -> None:
        with pytest.raises(ValueError, match="read-only"):
            getattr(arm(declared_angles=np.zeros((3, 2, 3))), name)[0] = 0.0

    @pytest.mark.parametrize(
        ("changes", "message"),
        [
            ({"rotations": np.zeros((0, 2, 4))}, r"rotations of shape \(n_frames >= 1, 2, 4\), found \(0, 2, 4\)"),
            ({"rotations": np.ones((3, 1, 4))}, r"found \(3, 1, 4\)"),
            ({"rotations": np.ones((3, 2, 3))}, r"found \(3, 2, 3\)"),
            ({"rotations": np.ones((2, 4))}, r"found \(2, 4\)"),
            ({"translations": np.ones((2, 2, 3))}, r"translations of shape \(3, 2, 3\), found \(2, 2, 3\)"),
            ({"declared_angles": np.ones((3, 2))}, r"declared angles of shape \(3, 2, 3\), found \(3, 2\)"),
        ],
    )
    def test_shapes_that_no_motion_has(self, changes, message: str) -> None:
        with pytest.raises(InvalidMotionError, match=message):
            arm(**changes)

    @pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize(
        ("name", "shown", "width"),
        [("rotations", "rotation", 4), ("translations", "translation", 3), ("declared_angles", "declared angle", 3)],
    )
    def test_a_number_that_is_not_finite_is_named_by_joint_and_frame(self, name, shown, width, number) -> None:
        values = np.ones((3, 2, width))
        values[1, 1, 2] = number
        with pytest.raises(
            InvalidMotionError, match=f"the {shown} of joint 'lower' at frame 1 is not finite: .*{number}"
        ):
            arm(**{name: values})

    def test_a_rotation_of_length_zero_is_named_by_joint_and_frame(self) -> None:
        rotations = arm().rotations.copy()
        rotations[2, 0] = 0.0
        with pytest.raises(InvalidMotionError, match="the rotation of joint 'upper' at frame 2 has length 0"):
            arm(rotations=rotations)


class TestCutting:
    def test_frames_are_cut_with_their_numbers_and_angles(self) -> None:
        angles = np.arange(18.0).reshape(3, 2, 3)
        cut = arm(declared_angles=angles, first_frame=1, name="wave").frames(1, 3)
        assert (cut.n_frames, cut.first_frame, cut.name, cut.rate) == (2, 2, "wave", 10)
        assert np.array_equal(cut.rotations, arm().rotations[1:])
        assert np.array_equal(cut.local_translations, arm().local_translations[1:])
        assert cut.declared_angles is not None
        assert np.array_equal(cut.declared_angles, angles[1:])

    @pytest.mark.parametrize(("start", "stop"), [(-1, 2), (0, 4), (2, 2), (2, 1), (3, 4)])
    def test_a_range_outside_is_refused(self, start: int, stop: int) -> None:
        with pytest.raises(OptionError, match=f"frames {start} to {stop - 1} .* wave, which has frames 0 to 2"):
            arm(name="wave").frames(start, stop)

    def test_another_rate_plays_the_same_frames(self) -> None:
        slow = arm().with_rate(Fraction(5))
        assert slow.duration == 2 * arm().duration
        assert np.array_equal(slow.rotations, arm().rotations)


class TestFramePositions:
    @given(st.lists(st.floats(-1e3, 1e6), min_size=1, max_size=20), st.sampled_from(RATES), st.integers(1, 10_000_000))
    def test_agree_with_exact_arithmetic(self, times, rate: Fraction, n_frames: int) -> None:
        before, after, fraction = frame_positions(times, rate, n_frames)
        assert np.all((before >= 0) & (after <= n_frames - 1) & (fraction >= 0) & (fraction < 1))
        assert np.all((after == before + 1) | ((before == n_frames - 1) & (after == before)))
        for i, time in enumerate(times):
            exact = frame_place(time, rate, n_frames)
            assert abs(Fraction(int(before[i])) + Fraction(float(fraction[i])) - exact) < 2e-9 + 3e-15 * float(exact)

    @pytest.mark.parametrize("first", [0, 123_456, 9_999_000])
    @pytest.mark.parametrize("rate", RATES)
    def test_a_frames_own_time_is_that_frame_as_far_as_any_file_goes(self, rate: Fraction, first: int) -> None:
        frames = np.arange(first, first + 1000)
        # Both ways to compute a frame's time in floating point.
        for times in ([float(int(frame) / rate) for frame in frames], frames / float(rate)):
            before, _, fraction = frame_positions(times, rate, 10_000_000)
            assert np.array_equal(before, frames)
            assert not fraction.any()

    def test_any_shape_of_times_is_kept(self) -> None:
        assert [part.shape for part in frame_positions(np.zeros((2, 3)), Fraction(30), 5)] == [(2, 3)] * 3

    def test_a_time_that_is_not_a_number_is_refused_and_infinite_ones_are_held(self) -> None:
        with pytest.raises(OptionError, match="time 1 of 3 is not a number"):
            frame_positions([0.0, np.nan, 1.0], Fraction(30), 5)
        before, _, fraction = frame_positions([-np.inf, np.inf], Fraction(30), 5)
        assert (before.tolist(), fraction.tolist()) == ([0, 4], [0.0, 0.0])


class TestSampling:
    @given(motions())
    def test_own_frames_come_back_bit_for_bit(self, motion: Motion) -> None:
        sampled = motion.at(np.arange(motion.n_frames) / float(motion.rate))
        assert np.array_equal(sampled.rotations, motion.rotations)
        assert np.array_equal(sampled.local_translations, motion.local_translations)

    @given(motions(), st.floats(0.01, 0.99))
    def test_between_frames_rotations_slerp_and_translations_are_linear(self, motion: Motion, share: float) -> None:
        times = (np.arange(motion.n_frames - 1) + share) / float(motion.rate)
        if len(times) == 0:
            return
        sampled = motion.at(times)
        for frame in range(len(times)):
            a, b = motion.local_translations[frame : frame + 2]
            np.testing.assert_allclose(sampled.local_translations[frame], (1 - share) * a + share * b, atol=1e-6)
            for joint in range(motion.skeleton.n_joints):
                pair = motion.rotations[frame : frame + 2, joint]
                if abs(np.dot(pair[0], pair[1])) < 1e-6:
                    continue  # half a turn apart: no arc is shorter
                expected = Slerp([0, 1], Rotation.from_quat(pair, scalar_first=True))(share).as_quat(scalar_first=True)
                found = sampled.rotations[frame, joint]
                np.testing.assert_allclose(found * np.sign(np.dot(found, expected)), expected, atol=1e-7)

    @given(motions(), st.floats(0.0, 1e9))
    def test_outside_the_motion_its_ends_are_held(self, motion: Motion, beyond: float) -> None:
        held = motion.at([-beyond, motion.end_time + beyond])
        assert np.array_equal(held.rotations, motion.rotations[[0, -1]])
        assert np.array_equal(held.local_translations, motion.local_translations[[0, -1]])

    def test_one_frame_is_the_same_at_all_times(self) -> None:
        sampled = arm(1).at([-1.0, 0.0, 0.05, 3.0])
        assert np.array_equal(sampled.rotations, np.repeat(arm(1).rotations, 4, axis=0))

    def test_times_may_come_in_any_order_and_repeat(self) -> None:
        sampled = arm(3).at([0.2, 0.05, 0.05, 0.0])
        expected = arm(3).local_translations
        assert np.array_equal(sampled.local_translations[[0, 3]], expected[[2, 0]])
        np.testing.assert_allclose(sampled.local_translations[1:3], [expected[:2].mean(axis=0)] * 2)

    def test_what_is_not_time_is_kept(self) -> None:
        motion = arm(3, name="wave", first_frame=7, metres_per_unit=0.01)
        sampled = motion.at([0.0, 0.1])
        assert (sampled.rate, sampled.name, sampled.metres_per_unit) == (motion.rate, "wave", 0.01)
        assert sampled.first_frame == 0

    def test_declared_angles_are_those_of_the_nearer_frame(self) -> None:
        angles = np.arange(18.0).reshape(3, 2, 3)
        sampled = arm(3, declared_angles=angles).at([0.0, 0.04, 0.06, 0.2])
        assert sampled.declared_angles is not None
        assert np.array_equal(sampled.declared_angles, angles[[0, 0, 1, 2]])

    def test_the_motion_itself_is_not_changed(self) -> None:
        motion = arm(3)
        before = motion.rotations.copy(), motion.local_translations.copy()
        motion.at([0.03, 0.17])
        assert np.array_equal(motion.rotations, before[0])
        assert np.array_equal(motion.local_translations, before[1])

    def test_no_times_make_no_motion(self) -> None:
        with pytest.raises(InvalidMotionError, match=r"found \(0, 2, 4\)"):
            arm(3).at([])


class TestLikeAList:
    @pytest.mark.parametrize("index", [slice(2, 5), slice(None), slice(-3, None), slice(4, 99), slice(0, None, 1)])
    def test_a_slice_cuts_frames_as_a_list_does(self, index: slice) -> None:
        motion = arm(8, first_frame=1)
        numbers = list(range(8))[index]
        cut = motion[index]
        assert len(cut) == cut.n_frames == len(numbers)
        assert np.array_equal(cut.rotations, motion.rotations[index])
        assert cut.first_frame == 1 + numbers[0]

    @pytest.mark.parametrize(
        ("index", "says"),
        [
            (3, r"clip\[10:11\]; found \[3\]"),
            (np.int64(3), "one frame is"),
            (slice(5, 5), "are none"),
            (slice(99, None), "are none"),
            (slice(0, 8, 2), "not with a step of 2"),
            (slice(None, None, -1), "not with a step of -1"),
            (slice(0.5, 2), "whole numbers"),
            ((0, 1), "found a tuple"),
            ("LeftFoot", "found the text 'LeftFoot'"),
        ],
    )
    def test_any_other_index_says_what_to_write(self, index, says: str) -> None:
        with pytest.raises(OptionError, match=says):
            arm(8)[index]

    def test_frames_takes_whole_numbers_of_any_type(self) -> None:
        assert arm(8).frames(np.int64(1), np.uint8(3)).n_frames == 2
        with pytest.raises(OptionError, match=r"whole numbers; found 1\.0"):
            arm(8).frames(1.0, 3)  # type: ignore[arg-type]

    def test_a_motion_is_no_loop_over_frames(self) -> None:
        with pytest.raises(TypeError, match="not iterable"):
            list(arm(3))  # type: ignore[call-overload]
        with pytest.raises(TypeError):
            np.asarray(arm(3), dtype=float)


class TestPositions:
    @given(motions())
    def test_positions_are_those_of_forward_kinematics(self, motion: Motion) -> None:
        assert np.array_equal(motion.positions, global_poses(motion).positions)
        assert motion.positions is motion.positions
        assert not motion.positions.flags.writeable

    def test_a_changed_copy_has_its_own(self) -> None:
        motion = arm(4)
        assert motion.positions.shape == (4, 2, 3)
        assert motion[1:3].positions.shape == (2, 2, 3)

    def test_flights_are_those_that_everything_else_finds(self) -> None:
        clip = sample()
        assert clip.flights() == flights(clip) != []
        assert clip.flights(minimum=9.0) == []


class TestFromArrays:
    @pytest.mark.parametrize("form", ["wxyz", "xyzw", "matrix", "rotvec"])
    def test_every_form_of_rotations_means_the_same_motion(self, form) -> None:
        turns = Rotation.random(12, rng=2)
        as_form = {
            "wxyz": turns.as_quat(scalar_first=True),
            "xyzw": turns.as_quat(),
            "matrix": turns.as_matrix(),
            "rotvec": turns.as_rotvec(),
        }[form]
        rotations = as_form.reshape(6, 2, *as_form.shape[1:])
        roots = np.random.default_rng(0).normal(size=(6, 3))
        motion = Motion.from_arrays(
            rotations,
            form=form,
            parents=np.array([-1, 0]),
            offsets=ARM.offsets.tolist(),
            names=["upper", "lower"],
            root_positions=roots,
            rate="29.97",
            name="wave",
            metres_per_unit=0.01,
            up="z",
        )
        expected = turns.as_matrix().reshape(6, 2, 3, 3)
        np.testing.assert_allclose(rotation.to_matrix(motion.rotations), expected, atol=1e-12)
        assert np.array_equal(motion.local_translations[:, 0], roots)
        assert np.array_equal(motion.local_translations[:, 1], np.tile(ARM.offsets[1], (6, 1)))
        assert (motion.rate, motion.name, motion.up, motion.metres_per_unit) == (
            Fraction(30000, 1001),
            "wave",
            "z",
            0.01,
        )
        assert motion.skeleton.names == ("upper", "lower")

    def test_what_is_left_out(self) -> None:
        motion = Motion.from_arrays(np.zeros((5, 2, 3)), form="rotvec", parents=[-1, 0], offsets=ARM.offsets, rate=30)
        assert motion.skeleton.names == ("joint0", "joint1")
        assert np.array_equal(motion.positions[0], [[0, 1, 0], [2, 1, 0]])

    @pytest.mark.parametrize(
        ("changes", "error", "says"),
        [
            ({"form": "euler"}, OptionError, "one of wxyz, xyzw, matrix, rotvec; found 'euler'"),
            ({"form": "matrix"}, InvalidMotionError, r"\(n_frames >= 1, 2, 3, 3\) where form is 'matrix', found"),
            ({"rotations": np.zeros((0, 2, 4))}, InvalidMotionError, "n_frames >= 1"),
            ({"rotations": [[1], [2, 3]]}, InvalidMotionError, "rotations must be an array of real numbers"),
            ({"rotations": np.ones((5, 2, 4), complex)}, InvalidMotionError, "rotations must be real numbers"),
            ({"rotations": np.zeros((5, 2, 4))}, InvalidMotionError, "length 0"),
            (
                {"rotations": np.full((5, 2, 3), np.nan), "form": "rotvec"},
                InvalidMotionError,
                "at frame 0 is not finite",
            ),
            ({"rotations": np.full((5, 2, 3, 3), np.nan), "form": "matrix"}, InvalidMotionError, "is not finite"),
            ({"rotations": np.ones((5, 2, 3, 3)), "form": "matrix"}, InvalidMotionError, "at frame 0 is no rotation"),
            ({"rotations": np.tile(-np.eye(3), (5, 2, 1, 1)), "form": "matrix"}, InvalidMotionError, "is no rotation"),
            ({"offsets": [[0, 0, 0]]}, InvalidMotionError, "as many names, parents and offsets"),
            ({"parents": [1, -1]}, InvalidMotionError, "the root comes first"),
            ({"root_positions": np.zeros((4, 3))}, InvalidMotionError, r"shape \(5, 3\), found \(4, 3\)"),
            ({"rate": 0}, OptionError, "frame rate"),
        ],
    )
    def test_what_makes_no_motion_is_refused(self, changes, error, says: str) -> None:
        given = {
            "rotations": np.tile([1.0, 0, 0, 0], (5, 2, 1)),
            "parents": [-1, 0],
            "offsets": ARM.offsets,
            "rate": 30,
            **changes,
        }
        with pytest.raises(error, match=says):
            Motion.from_arrays(given.pop("rotations"), **given)

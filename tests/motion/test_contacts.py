"""Contacts: against their definition, on the made figure whose feet's plan is known, and on real captures."""

from __future__ import annotations

import itertools
import json
import warnings
from dataclasses import replace
from fractions import Fraction
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InvalidMotionError, OptionError
from retime.formats.registry import read
from retime.motion import rotation
from retime.motion.contacts import Contact, Contacts, Foot, Slip, contacts, slip, slip_of
from retime.motion.flights import flights
from retime.motion.kinematics import metres_per_unit
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton
from tests.motion.leaps import hops, jumps, leaper, run, run_and_leap
from tests.motion.strategies import skeletons
from tests.motion.strides import strides
from tests.motion.walkers import moved, renamed, scaled, walker
from tests.reference import contacts as literal

# Two legs that reach anywhere: their translations are given.
LEGS = Skeleton(
    ("Hips", "LeftFoot", "RightFoot"), (-1, 0, 0), np.array([[0.0, 0.8, 0.0], [0.1, -0.7, 0.0], [-0.1, -0.7, 0.0]])
)


def legs(left: np.ndarray, right: np.ndarray | None = None, rate: int = 120, unit: float = 1.0) -> Motion:
    """Feet that go where they are told, in metres; (n_frames, 3)."""
    translations = np.zeros((len(left), 3, 3))
    translations[:, 0] = [0.0, 0.8, 0.0]
    translations[:, 1] = left - translations[:, 0]
    translations[:, 2] = ([0.0, 0.0, 0.0] if right is None else right) - translations[:, 0]
    return Motion(
        LEGS, rotation.identity(len(left), 3), translations / unit, Fraction(rate), name="legs", metres_per_unit=unit
    )


def path(*pieces: tuple[float, float, float], rate: int = 120) -> np.ndarray:
    """A foot's path from pieces (seconds, metres forward, metres up in the middle), smooth at both ends of each."""
    rows, z = [], 0.0
    for seconds, forward, up in pieces:
        share = np.arange(round(seconds * rate)) / round(seconds * rate)
        rows.append(np.stack([0 * share, up * np.sin(np.pi * share) ** 2, z + forward * (3 - 2 * share) * share**2], 1))
        z += forward
    return np.concatenate(rows)


def first_and_last(found: Contacts, foot: int = 0) -> list[tuple[int, int]]:
    return [(span.first_frame, span.last_frame) for span in found.spans() if span.foot == foot]


@st.composite
def restless(draw: st.DrawFn) -> Motion:
    """Any tree; its joints rest for a while, then move on, slowly or fast; speeds and heights around the thresholds."""
    skeleton = draw(skeletons(4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n_frames = draw(st.integers(1, 40))
    rate = draw(st.sampled_from([Fraction(12), Fraction(30), Fraction(24000, 1001), Fraction(60)]))
    steps = rng.normal(0, draw(st.sampled_from([0.3, 1.0, 3.0])), (n_frames, skeleton.n_joints, 3)) / float(rate)
    steps *= np.repeat(rng.random((n_frames // 3 + 1, skeleton.n_joints, 1)) < 0.6, 3, axis=0)[:n_frames]
    q = np.broadcast_to(rotation.normalize(rng.normal(size=(skeleton.n_joints, 4))), (n_frames, skeleton.n_joints, 4))
    return Motion(skeleton, q, np.cumsum(steps, axis=0), rate, metres_per_unit=draw(st.sampled_from([1.0, 0.5])))


class TestAgainstTheDefinition:
    @settings(max_examples=40)
    @given(restless())
    def test_contacts(self, motion: Motion) -> None:
        names = [f"joint {i}" for i in range(motion.skeleton.n_joints)]
        skeleton = motion.skeleton
        motion = replace(
            motion, skeleton=Skeleton(tuple(names), skeleton.parents, skeleton.offsets, skeleton.end_sites)
        )
        found = contacts(motion, feet=names)
        for joint in range(len(names)):
            wanted = literal.at_rest(motion, (joint, None), metres_per_unit(motion))
            assert found.at_rest[:, joint].tolist() == wanted
            assert found.held[:, joint].tolist() == literal.held(motion, (joint, None), metres_per_unit(motion))

    @pytest.mark.parametrize(
        "options",
        [
            {},
            {"speed": 0.5},
            {"swing_share": 0.2},
            {"swing_share": 0.5, "most_speed": 0.4},
            {"rise": 0.01},
            {"height": 0.02},
            {"gap": 0.0},
            {"gap": 0.3},
            {"minimum": 0.3},
        ],
    )
    def test_contacts_with_other_thresholds(self, options: dict[str, float]) -> None:
        # Strides with a short break, a slow lift and a touch; the other foot stands a little higher.
        left = path(
            (0.6, 0, 0), (0.4, 0.6, 0.1), (0.3, 0, 0), (0.1, 0.1, 0.005), (0.5, 0, 0.03), (0.2, 0.2, 0.1), (0.15, 0, 0),
            (0.25, 0.3, 0.1), (0.3, 0, 0), (0.05, 0.02, 0), (0.5, 0, 0), rate=60,
        )  # fmt: skip
        motion = legs(left, np.full(left.shape, [0.0, 0.03, 0.0]), rate=60)
        found = contacts(motion, **options)
        for i, foot in enumerate(found.feet):
            assert found.at_rest[:, i].tolist() == literal.at_rest(motion, (foot.joint, None), 1.0, **options)
            assert found.held[:, i].tolist() == literal.held(motion, (foot.joint, None), 1.0, **options)
        assert not options or not np.array_equal(found.at_rest, contacts(motion).at_rest)

    @settings(max_examples=40)
    @given(restless(), st.integers(0, 2**32 - 1), st.sampled_from([1.0, 0.01, 0.0254]))
    def test_slip(self, motion: Motion, seed: int, unit: float) -> None:
        rng = np.random.default_rng(seed)
        motion = replace(motion, metres_per_unit=unit)
        feet = [Foot(joint) for joint in range(motion.skeleton.n_joints)]
        feet += [Foot(site.parent, i) for i, site in enumerate(motion.skeleton.end_sites)]
        standing = Contacts(tuple(feet), rng.random((motion.n_frames, len(feet))) < 0.7, motion.rate)
        measured = slip(motion, standing)
        for span, found in zip(measured.contacts, measured.millimetres, strict=True):
            foot = feet[span.foot]
            wanted = literal.slip(motion, (foot.joint, foot.end_site), unit, span.first_frame, span.last_frame)
            assert found == pytest.approx(wanted, abs=1e-8)
        assert measured.contacts == standing.spans()

    @given(st.lists(st.booleans(), min_size=1, max_size=30), st.integers(0, 2**32 - 1))
    def test_the_contacts_that_are_shown(self, column: list[bool], seed: int) -> None:
        rng = np.random.default_rng(seed)
        feet = Contacts((Foot(0),), np.array(column)[:, None], Fraction(25))
        # On frames, between them, outside, in any order; steps that leave out whole contacts and breaks.
        places = np.cumsum(rng.choice([-1.5, 0, 0.25, 0.5, 1, 4], 20)) + rng.integers(0, 5)
        held = np.clip(places, 0, len(column) - 1)
        wanted = literal.shown(column, held.tolist())
        assert feet.spans_at(places / 25) == tuple(Contact(0, first, last) for _, first, last in wanted)
        stands = {frame for _, first, last in wanted for frame in range(first, last + 1)}
        sampled = feet.at(places / 25)
        assert np.flatnonzero(sampled.at_rest[:, 0]).tolist() == sorted(stands)
        assert (sampled.feet, sampled.rate) == (feet.feet, feet.rate)


class TestWhatStands:
    def test_a_foot_that_stands_swings_and_stands(self) -> None:
        found = contacts(legs(path((1.0, 0, 0), (0.5, 0.7, 0.15), (1.0, 0, 0))))
        (first, second) = first_and_last(found)
        # Swinging begins and ends slowly, and speeds are looked at over a thirtieth of a second to either side.
        assert first == (0, pytest.approx(120, abs=6))
        assert second == (pytest.approx(180, abs=6), 299)
        assert first_and_last(found, 1) == [(0, 299)]

    @pytest.mark.parametrize("rate", [24, 30, 60, 120, 240])
    @pytest.mark.parametrize("unit", [1.0, 0.01, 0.0254])
    def test_rate_and_unit_make_little_difference(self, rate: int, unit: float) -> None:
        pieces = ((1.0, 0, 0), (0.5, 0.7, 0.15), (0.5, 0, 0), (0.5, 0.7, 0.15), (1.0, 0, 0))
        found = first_and_last(contacts(legs(path(*pieces, rate=rate), rate=rate, unit=unit)))
        finest = first_and_last(contacts(legs(path(*pieces, rate=480), rate=480)))
        np.testing.assert_allclose(np.array(found) / rate, np.array(finest) / 480, atol=1.5 / min(rate, 30))

    def test_a_foot_held_up_still_does_not_stand(self) -> None:
        raised = path((1.0, 0, 0), (2.0, 0, 0.0), (1.0, 0, 0))
        times = np.arange(len(raised)) / 120
        raised[:, 1] = 0.4 * np.interp(times, [1.0, 1.4, 2.6, 3.0], [0, 1, 1, 0])
        assert [last - first < 130 for first, last in first_and_last(contacts(legs(raised)))] == [True, True]

    def test_nor_does_one_at_the_top_of_a_hop(self) -> None:
        # Both feet leave the ground by a hand's breadth: nothing else is lower.
        times = np.arange(-1, 1.0, 1 / 120)
        hop = np.zeros((len(times), 3))
        hop[:, 1] = np.maximum(0.1 - 9.81 / 2 * times**2, 0)
        found = contacts(legs(hop, hop))
        assert [len(first_and_last(found, foot)) for foot in (0, 1)] == [2, 2]

    @pytest.mark.parametrize("slope", [-0.1, 0.1])
    def test_floors_need_not_be_level(self, slope: float) -> None:
        swings = path(*[(0.5, 0, 0), (0.5, 0.7, 0.15)] * 6)
        tilted = swings + np.stack([0 * swings[:, 2], slope * swings[:, 2], 0 * swings[:, 2]], axis=1)
        level, found = contacts(legs(swings, swings)), contacts(legs(tilted, tilted))
        assert len(first_and_last(found)) == 6
        np.testing.assert_allclose(first_and_last(found), first_and_last(level), atol=3)

    @pytest.mark.parametrize("down", [False, True])
    def test_stairs_are_not_one_floor(self, down: bool) -> None:
        # Steps of 17 cm; each foot stands on every other one.
        frames = np.arange(0, 3.0, 1 / 120)

        def foot(times: list[float], heights: list[float]) -> np.ndarray:
            climbed = np.interp(frames, times, heights)
            return np.stack([0 * frames, climbed, climbed * 1.7], axis=1)

        left = foot([0.65, 1.1, 1.75, 2.2], [0.0, 0.34, 0.34, 0.68])
        right = foot([0.1, 0.55, 1.2, 1.65], [-0.17, 0.17, 0.17, 0.51])
        if down:
            left, right = left[::-1], right[::-1]
        found = contacts(legs(left, right))
        for side, path_of_foot in enumerate((left, right)):
            climbing = np.concatenate([[False], np.abs(np.diff(path_of_foot[:, 1])) > 1e-9])
            assert len(first_and_last(found, side)) == 3
            # On each step all the time that it stays there, but for the instants that a speed is measured over.
            assert np.mean(found.at_rest[:, side] == ~climbing) > 0.9

    def test_short_breaks_are_closed_and_flickers_dropped(self) -> None:
        # Still but for kicks; measured over 4 frames to either side, a kick of 1 frame breaks 8 or so.
        still = np.zeros((480, 3))
        still[100:, 0] += 0.05
        assert len(first_and_last(contacts(legs(still)))) == 1
        assert len(first_and_last(contacts(legs(still), gap=0.0))) == 2
        # Slow for 9 frames between fast stretches.
        z = np.concatenate([np.arange(100), np.full(17, 100.0), 100 + np.arange(1, 101)]) * 0.02
        path_of_z = np.stack([0 * z, 0 * z, z], axis=1)
        ((first, last),) = first_and_last(contacts(legs(path_of_z)))
        assert last - first + 1 >= 6
        assert first_and_last(contacts(legs(path_of_z), minimum=0.2)) == []

    @pytest.mark.parametrize("n_frames", [1, 2, 3])
    def test_clips_of_a_few_frames(self, n_frames: int) -> None:
        found = contacts(legs(np.zeros((n_frames, 3)), rate=30))
        assert found.at_rest.shape == (n_frames, 2)
        # A single frame tells no speed.
        assert first_and_last(found) == ([(0, n_frames - 1)] if n_frames > 1 else [])

    def test_where_the_whole_body_is_and_looks_does_not_matter(self) -> None:
        motion = legs(path(*[(0.5, 0, 0), (0.5, 0.7, 0.15)] * 3))
        elsewhere = moved(motion, rotation.about_axis(1, 1.1), np.array([30.0, -7.0, 11.0]))
        assert len(contacts(motion).spans()) == 4
        assert np.array_equal(contacts(motion).at_rest, contacts(elsewhere).at_rest)
        assert np.array_equal(contacts(motion).at_rest, contacts(scaled(motion, 39.37)).at_rest)


def precision_and_recall(motion: Motion, touches: np.ndarray, **options: float) -> tuple[float, float]:
    """Of the frames found for either foot how many are right; of the right ones how many are found."""
    found = contacts(motion, **options)
    names = [motion.skeleton.names[foot.joint] for foot in found.feet]
    sides = [[i for i, name in enumerate(names) if name.startswith(side)] for side in ("Left", "Right")]
    stands = np.stack([found.at_rest[:, side].any(axis=1) for side in sides], axis=1)
    right = (stands & touches).sum()
    return right / stands.sum(), right / touches.sum()


class TestStancesThatAreKnown:
    """Feet that roll from heel to toe, in stances from those of a run to those of a stroll."""

    @pytest.mark.parametrize("rate", [24, 30, 60, 120, 240])
    @pytest.mark.parametrize("stance", [0.3, 0.4, 0.56, 0.75, 1.0, 1.5, 2.0])
    def test_feet_with_toes(self, rate: int, stance: float) -> None:
        for size, unit, noise in ((1.0, 1.0, 0.001), (0.6, 0.01, 0.0005), (1.4, 0.0564, 0.002)):
            motion, touches = strides(stance, rate=rate, size=size, unit=unit, noise=noise)
            precision, found = precision_and_recall(motion, touches)
            assert found > (0.8 if stance > 0.5 else 0.7)
            # Slow feet are slow before they land, too: no rolling is looked for there.
            without = precision_and_recall(motion, touches, swing_share=0.0)
            assert precision > (0.95 if stance <= 1 else 0.9)
            assert precision > without[0] - 0.05
            assert found >= without[1]

    @pytest.mark.parametrize("rate", [30, 120])
    @pytest.mark.parametrize("stance", [0.4, 0.56, 0.75])
    def test_an_ankle_alone_lifts_long_before_the_foot_does(self, rate: int, stance: float) -> None:
        motion, touches = strides(stance, rate=rate, toes=False)
        precision, found = precision_and_recall(motion, touches)
        assert precision > 0.97
        # From when the sole is down to the middle of the stance, when the heel leaves, and some of either side.
        assert 0.5 < found < 0.85
        assert found > precision_and_recall(motion, touches, swing_share=0.0)[1] + 0.08

    @pytest.mark.parametrize("rate", [30, 60, 120])
    @pytest.mark.parametrize(
        ("plan", "options", "found_at_least"),
        [
            (jumps(0.3, 0.45, 0.6), {"arms": 0.4}, 0.95),
            (jumps(0.45, 0.5, 0.4, ground=(0.4, 0.4, 0.0)), {}, 0.95),
            (hops(0.2), {"speed": 0.8}, 0.85),
            (run(0.22, 0.11), {"speed": 3.5, "lift": 0.35}, 0.8),
            (run_and_leap(), {"speed": 4.0, "lift": 0.3}, 0.8),
        ],
        ids=["jumps", "boxes", "hops", "a run", "a leap"],
    )
    def test_feet_stand_between_flights_and_not_in_them(self, plan, options, found_at_least: float, rate: int) -> None:
        for size, unit, noise in ((1.0, 1.0, 0.001), (0.6, 0.01, 0.0005), (1.2, 0.0564, 0.003)):
            motion, aloft = leaper(plan, rate=rate, size=size, unit=unit, noise=noise, **options)
            stands = contacts(motion).at_rest.any(axis=1)
            assert (stands & ~aloft).sum() > 0.98 * stands.sum()
            assert (stands & ~aloft).sum() > found_at_least * (~aloft).sum()

    def test_what_rolls_is_not_held_and_does_not_slip(self) -> None:
        motion, _ = strides(0.56)
        found, plain = contacts(motion), contacts(motion, swing_share=0.0)
        assert found.at_rest.sum() > 1.1 * found.held.sum()
        assert np.array_equal(found.held, plain.at_rest)
        assert slip(motion, found).millimetres.tolist() == slip(motion, plain).millimetres.tolist()
        assert found.where_held().spans() == plain.spans()
        times = np.arange(0, 2, 0.017)
        assert np.array_equal(found.at(times).held, plain.at(times).at_rest)


class TestWhichJoints:
    def feet_of(self, motion: Motion) -> list[str]:
        return [motion.skeleton.names[foot.joint] for foot in contacts(motion).feet]

    def test_those_whose_names_say_it(self) -> None:
        assert self.feet_of(walker(10)) == ["LeftFoot", "LeftToe", "RightFoot", "RightToe"]
        sides = {"Left": "l", "Right": "r"}
        cmu = {
            side + part: letter + name
            for side, letter in sides.items()
            for part, name in {"UpLeg": "femur", "Leg": "tibia", "Foot": "foot", "Toe": "toes"}.items()
        }
        assert self.feet_of(renamed(walker(10), cmu)) == ["lfoot", "ltoes", "rfoot", "rtoes"]
        mixamo = {name: f"mixamorig:{name}" for name in walker(10).skeleton.names}
        assert self.feet_of(renamed(walker(10), mixamo)) == [
            f"mixamorig:{name}" for name in ("LeftFoot", "LeftToe", "RightFoot", "RightToe")
        ]
        ankles = {"LeftFoot": "LeftAnkle", "RightFoot": "RightAnkle", "LeftToe": "a", "RightToe": "b"}
        assert self.feet_of(renamed(walker(10), ankles)) == ["LeftAnkle", "RightAnkle"]

    def test_else_the_limbs_that_get_down_to_the_ground(self) -> None:
        motion = walker(80)
        anonymous = renamed(motion, {name: f"n{i}" for i, name in enumerate(motion.skeleton.names)})
        toes = [motion.skeleton.index("LeftToe"), motion.skeleton.index("RightToe")]
        assert [foot.joint for foot in contacts(anonymous).feet] == toes

    def test_or_their_end_sites_where_those_are_lower(self) -> None:
        parents, offsets = (-1, 0, 0, 0), np.array([[0.0, 0.5, 0], [0.1, 0, 0.4], [-0.1, 0, 0.4], [0, 0.1, -0.4]])
        ends = (EndSite(1, (0, 0.3, 0)), EndSite(1, (0, -0.5, 0)), EndSite(2, (0, -0.5, 0)), EndSite(3, (0, 0, -0.3)))
        table = Motion(Skeleton(("top", "one", "two", "tail"), parents, offsets, ends), rotation.identity(30, 4))
        assert contacts(replace(table, metres_per_unit=1.0)).feet == (Foot(1, 1), Foot(2, 2))

    def test_a_prop_has_none(self) -> None:
        ball = Skeleton(("ball",), (-1,), np.zeros((1, 3)))
        found = contacts(Motion(ball, rotation.identity(20, 1)))
        assert found.feet == ()
        assert found.at_rest.shape == (20, 0)
        assert found.spans() == ()
        nothing = slip(Motion(ball, rotation.identity(20, 1)), found)
        assert (nothing.mean, nothing.largest, nothing.total) == (0.0, 0.0, 0.0)

    def test_or_those_that_are_asked_for(self) -> None:
        motion = walker(40)
        found = contacts(motion, feet=["LeftHand", "Head"])
        assert [motion.skeleton.names[foot.joint] for foot in found.feet] == ["LeftHand", "Head"]
        # However still they are, they are up in the air.
        assert not contacts(replace(motion, rotations=motion.rotations[:1].repeat(40, 0)), feet=["Head"]).at_rest.any()

    def test_all_that_share_a_name_are_looked_at(self) -> None:
        names = {"LeftFoot": "foot", "RightFoot": "foot", "LeftToe": "L ball", "RightToe": "L ball"}
        motion = renamed(walker(40), names)
        wanted = [walker(1).skeleton.index(name) for name in ("LeftFoot", "RightFoot")]
        assert [foot.joint for foot in contacts(motion, feet=["foot"]).feet] == wanted
        # By their names both are the left one's toes; which is the first is none of the motion's affair.
        wanted = [walker(1).skeleton.index(name) for name in ("LeftToe", "RightToe")]
        assert [foot.joint for foot in contacts(motion).feet] == wanted

    def test_a_helper_below_a_foot_may_be_the_end_of_the_leg(self) -> None:
        motion = walker(80)
        skeleton = motion.skeleton
        toes = [skeleton.index("LeftToe"), skeleton.index("RightToe")]
        n_joints = skeleton.n_joints
        # Above the toes, and without a name that says anything.
        names = (*(f"n{i}" for i in range(n_joints)), "twist a", "twist b")
        longer = Skeleton(
            names, (*skeleton.parents, *toes), np.concatenate([skeleton.offsets, np.full((2, 3), [0, 0.05, 0])])
        )
        q = np.concatenate([motion.rotations, rotation.identity(80, 2)], axis=1)
        p = np.concatenate([motion.local_translations, np.full((80, 2, 3), [0, 0.05, 0])], axis=1)
        found = contacts(replace(motion, skeleton=longer, rotations=q, translations=p))
        assert [foot.joint for foot in found.feet] == [n_joints, n_joints + 1]

    def test_a_joint_that_is_not_there_is_named(self) -> None:
        with pytest.raises(OptionError, match=r"no joint is called 'LeftHnd'; near to it: 'LeftHand'"):
            contacts(walker(5), feet=["LeftHnd"])


class TestValues:
    def test_contacts_of_another_shape_are_refused(self) -> None:
        for shape in ((5,), (0, 2), (5, 1), (5, 2, 1)):
            with pytest.raises(InvalidMotionError, match="2 feet"):
                Contacts((Foot(0), Foot(1)), np.zeros(shape, dtype=bool), Fraction(30))

    def test_a_foot_is_held_only_where_it_stands(self) -> None:
        stands = np.array([[True], [False]])
        with pytest.raises(InvalidMotionError, match="foot 0 is held at frame 1, where it does not stand"):
            Contacts((Foot(0),), stands, Fraction(30), ~stands)
        with pytest.raises(InvalidMotionError, match=r"found \(2, 1\) and \(3, 1\)"):
            Contacts((Foot(0),), stands, Fraction(30), np.zeros((3, 1), dtype=bool))
        assert np.array_equal(Contacts((Foot(0),), stands, Fraction(30)).held, stands)

    def test_the_array_is_a_copy_and_stays_as_it_is(self) -> None:
        column = np.zeros((5, 1), dtype=bool)
        found = Contacts((Foot(0),), column, Fraction(30))
        column[:] = True
        assert not found.at_rest.any()
        with pytest.raises(ValueError, match="read-only"):
            found.at_rest[0] = True

    def test_two_contacts_stay_two_where_the_break_is_skipped(self) -> None:
        column = np.array([True, True, False, True, True])[:, None]
        found = Contacts((Foot(0),), column, Fraction(1))
        assert found.spans_at([0.0, 1.0, 3.0, 4.0]) == (Contact(0, 0, 1), Contact(0, 2, 3))
        assert found.at([0.0, 1.0, 3.0, 4.0]).spans() == (Contact(0, 0, 3),)

    def test_slip_by_hand(self) -> None:
        # 3 cm to the side and 4 cm ahead, then back; rising counts for nothing.
        left = np.array([[0, 0, 0], [0.03, 0.02, 0.04], [0.01, 0.5, 0]])
        motion = legs(left)
        measured = slip(motion, Contacts((Foot(1),), np.ones((3, 1), dtype=bool), motion.rate))
        assert measured.contacts == (Contact(0, 0, 2),)
        assert measured.millimetres.tolist() == [pytest.approx(50.0)]
        assert (measured.mean, measured.largest, measured.total) == (pytest.approx(50.0),) * 3
        two = slip_of(motion, (Foot(1), Foot(2)), (Contact(0, 0, 2), Contact(1, 0, 2), Contact(0, 1, 1)))
        np.testing.assert_allclose(two.millimetres, [50.0, 0.0, 0.0], atol=1e-9)
        assert two.mean == pytest.approx(50 / 3)

    def test_slip_of_another_motion_is_refused(self) -> None:
        with pytest.raises(OptionError, match="of 20 frames, but walker has 10"):
            slip(walker(10), contacts(walker(20)))

    def test_what_no_contact_slips(self) -> None:
        assert Slip((), np.zeros(0)).largest == 0.0


@pytest.fixture(scope="module")
def figure() -> tuple[Motion, dict[str, list[slice]]]:
    """The shipped sample, and its phases' frames."""
    folder = resources.files("retime") / "data"
    with resources.as_file(folder / "sample.bvh") as place:
        motion = read(place)
    assert isinstance(motion, Motion)
    phases: dict[str, list[slice]] = {}
    for phase in json.loads((folder / "sample_phases.json").read_text()):
        phases.setdefault(phase["name"], []).append(slice(phase["first_frame"], phase["last_frame"] + 1))
    return motion, phases


class TestOnTheFigure:
    """Its feet stand and swing as planned, to a fraction of a millimetre."""

    def test_it_stands_while_it_stands(self, figure: tuple[Motion, dict[str, list[slice]]]) -> None:
        motion, phases = figure
        found = contacts(motion)
        for frames in phases["stand"]:
            assert found.at_rest[frames].all()
        for frames in phases["flight"]:
            assert not found.at_rest[frames.start + 1 : frames.stop - 1].any()
        # In walking one foot or the other stands: some part of it.
        for frames in phases["walk"]:
            assert found.at_rest[frames].any(axis=1).all()
            assert not found.at_rest[frames].all(axis=1).all()

    def test_each_stride_is_one_contact(self, figure: tuple[Motion, dict[str, list[slice]]]) -> None:
        motion, phases = figure
        found = contacts(motion)
        names = [motion.skeleton.names[foot.joint] for foot in found.feet]
        for foot, name in enumerate(names):
            for walk in phases["walk"]:
                # Two or three steps of each foot in both walks.
                swings = np.flatnonzero(np.diff(found.at_rest[walk, foot].astype(int)) == -1)
                assert len(swings) in (2, 3), name

    def test_it_hardly_slips(self, figure: tuple[Motion, dict[str, list[slice]]]) -> None:
        motion, _ = figure
        measured = slip(motion, contacts(motion))
        # What there is comes from the first and last instants of each contact, at up to 0.2 m/s.
        assert measured.mean < 3
        assert measured.largest < 15


@pytest.mark.parametrize("name", ["49_04", "02_04", "49_02"])
def test_no_foot_stands_in_flight(mocap: Path, name: str) -> None:
    motion = read(mocap / "cmu-bvh" / f"{name}.bvh")
    assert isinstance(motion, Motion)
    motion = motion.frames(1, min(motion.n_frames, 1200))
    found, jumps = contacts(motion), flights(motion)
    assert jumps
    for first, last in jumps:
        assert not found.at_rest[first : last + 1].any()
    assert 0.1 < found.at_rest.any(axis=1).mean() < 0.99


def test_a_dancer_balances_on_one_leg(mocap: Path) -> None:
    motion = read(mocap / "cmu-bvh" / "49_20.bvh")
    assert isinstance(motion, Motion)
    found = contacts(motion.frames(1, motion.n_frames))
    sides = {motion.skeleton.names[foot.joint]: found.at_rest[:, i] for i, foot in enumerate(found.feet)}
    for name in ("LeftFoot", "LeftToeBase"):
        assert sides[name].all()
    for name in ("RightFoot", "RightToeBase"):
        assert sides[name][:200].all()
        assert not sides[name][260:].any()


@pytest.mark.parametrize("name", ["07_01", "07_09", "07_10", "07_12", "08_01", "08_08", "08_10"])
def test_in_walking_a_foot_stands_at_any_time(mocap: Path, name: str) -> None:
    motion = read(mocap / "cmu-bvh" / f"{name}.bvh")
    assert isinstance(motion, Motion)
    motion = motion.frames(2, motion.n_frames)
    assert contacts(motion).at_rest.any(axis=1).mean() > 0.9
    assert not flights(motion)


@pytest.mark.parametrize("name", ["35_17", "35_20", "35_22", "35_26"])
def test_in_running_a_foot_stands_between_flights(mocap: Path, name: str) -> None:
    motion = read(mocap / "cmu-bvh" / f"{name}.bvh")
    assert isinstance(motion, Motion)
    motion = motion.frames(2, motion.n_frames)
    found, jumps = contacts(motion).at_rest.any(axis=1), flights(motion)
    assert len(jumps) > 1
    assert not any(found[first : last + 1].any() for first, last in jumps)
    assert all(found[last:first].any() for (_, last), (first, _) in itertools.pairwise(jumps))


@pytest.mark.parametrize("offset", [5e-324, 1e-300, 1e-160, 1e-40])
@pytest.mark.parametrize("unit", [None, 1e300])
def test_a_figure_far_too_small_for_where_it_goes_overflows_nowhere(offset: float, unit: float | None) -> None:
    skeleton = Skeleton(("Hips", "LeftFoot"), (-1, 0), np.array([[0.0, 0.0, 0.0], [0.0, -offset, 0.0]]))
    places = np.broadcast_to(skeleton.offsets, (9, 2, 3)).copy()
    places[:, 0] = np.linspace(-1e100, 1e100, 9)[:, None]
    for names in (skeleton.names, ("a", "b")):
        named = replace(skeleton, names=names)
        motion = Motion(named, rotation.identity(9, 2), places, Fraction(30), metres_per_unit=unit)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = contacts(motion)
            assert np.isfinite(slip(motion, found).total)
            flights(motion)
        # It falls or flies by 1e99 metres a frame, and stands nowhere.
        assert not found.at_rest.any()

"""Flights: against their definition, on made motion whose flights are known, and on real captures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.motion import rotation
from retime.motion.flights import corrected_flights, flights, within
from retime.motion.kinematics import GRAVITY
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from study.clips.library import Library
from tests.motion.leaps import Phase, hops, jumps, leaper, run, run_and_leap
from tests.motion.strides import strides
from tests.motion.walkers import moved, permuted, renamed, scaled
from tests.reference import flights as literal


def aloft_in(motion: Motion) -> np.ndarray:
    """Whether each frame lies in a flight that is found."""
    found = np.zeros(motion.n_frames, dtype=bool)
    for first, last in flights(motion):
        assert not found[first : last + 1].any()
        found[first : last + 1] = True
    return found


def precision_and_recall(plan: Sequence[Phase], **options: object) -> tuple[float, float]:
    """Of the frames found to be in flight how many are; of those that are how many are found."""
    motion, aloft = leaper(plan, **options)  # type: ignore[arg-type]
    found = aloft_in(motion)
    right = (found & aloft).sum()
    return right / max(1, found.sum()), right / aloft.sum()


class TestAgainstTheDefinition:
    @settings(max_examples=30)
    @given(st.integers(0, 2**32 - 1), st.sampled_from([24, 30, 60, 120]))
    def test_on_plans_that_are_drawn(self, seed: int, rate: int) -> None:
        rng = np.random.default_rng(seed)
        plan = [Phase(0.4, "both")]
        for _ in range(rng.integers(1, 5)):
            ground = float(rng.choice([0.0, 0.0, 0.03, 0.3]))
            plan += [Phase(rng.uniform(0.04, 0.5), ""), Phase(rng.uniform(0.1, 0.8), str(rng.choice(["both", "left"])))]
            plan[-1] = replace(plan[-1], ground=ground)
        options = {"noise": rng.choice([0.0, 0.002, 0.01]), "arms": rng.uniform(0, 0.6), "toes": bool(rng.integers(2))}
        motion, _ = leaper(plan, rate=rate, lift=rng.uniform(0, 0.4), speed=rng.uniform(0, 3), seed=seed, **options)
        assert flights(motion) == literal.flights(motion)
        assert flights(motion, clearance=0.1, minimum=0.2) == literal.flights(motion, clearance=0.1, minimum=0.2)

    @settings(max_examples=30)
    @given(st.integers(0, 2**32 - 1), st.integers(1, 40))
    def test_on_heaps_of_numbers(self, seed: int, n_frames: int) -> None:
        rng = np.random.default_rng(seed)
        skeleton = Skeleton(("a", "LeftFoot", "c"), (-1, 0, 0), rng.normal(size=(3, 3)))
        heights = rng.normal(0, 0.3, (n_frames, 3, 3)).cumsum(axis=0)
        motion = Motion(skeleton, rotation.identity(n_frames, 3), heights, Fraction(30), metres_per_unit=1.0)
        assert flights(motion) == literal.flights(motion)


# Name, plan, options; precision and recall to be had at least, with toes and without (ankles lift early).
KNOWN = [
    ("jumps", jumps(0.3, 0.45, 0.6), {}, (0.99, 0.9), (0.95, 0.95)),
    ("low jumps", jumps(0.15, 0.2, 0.25), {}, (0.99, 0.85), (0.85, 0.95)),
    ("tucked, with arms", jumps(0.4, 0.5), {"lift": 0.3, "arms": 0.4}, (0.99, 0.85), (0.95, 0.9)),
    ("onto boxes", jumps(0.45, 0.5, 0.4, ground=(0.4, 0.4, 0.0)), {}, (0.99, 0.9), (0.95, 0.95)),
    ("up a slope", jumps(0.4, 0.4), {"slope": 0.1, "speed": 0.5}, (0.99, 0.9), (0.95, 0.95)),
    ("hops", hops(0.2), {"speed": 0.8}, (0.99, 0.9), (0.8, 0.95)),
    ("long hops", hops(0.3), {"speed": 1.5}, (0.99, 0.9), (0.9, 0.95)),
    ("a sprint", run(0.13, 0.13), {"speed": 7.0, "lift": 0.4}, (0.99, 0.55), (0.9, 0.85)),
    ("a run and a leap", run_and_leap(), {"speed": 4.0, "lift": 0.3}, (0.99, 0.5), (0.8, 0.8)),
]


class TestFlightsThatAreKnown:
    @pytest.mark.parametrize("rate", [24, 30, 60, 120, 240])
    @pytest.mark.parametrize(("name", "plan", "options", "with_toes", "without"), KNOWN, ids=[row[0] for row in KNOWN])
    def test_most_frames_of_flights_are_found_and_few_others(
        self, name: str, plan: list[Phase], options: dict, with_toes: tuple, without: tuple, rate: int
    ) -> None:
        for size, unit, noise in ((1.0, 1.0, 0.001), (0.6, 0.01, 0.0005), (1.2, 0.0564, 0.003)):
            for toes, (precise, complete) in ((True, with_toes), (False, without)):
                precision, recall = precision_and_recall(
                    plan, rate=rate, size=size, unit=unit, noise=noise, toes=toes, **options
                )
                assert precision >= precise
                assert recall >= complete

    def test_a_flight_is_found_for_each_jump(self) -> None:
        motion, aloft = leaper(jumps(0.3, 0.45, 0.6))
        edges = np.flatnonzero(np.diff(aloft.astype(int))).reshape(-1, 2) + np.array([1, 0])
        np.testing.assert_allclose(flights(motion), edges, atol=4)

    def test_z_up_and_units_and_places_and_the_order_of_joints_make_no_difference(self) -> None:
        plan = jumps(0.4, 0.25, 0.5)
        motion, _ = leaper(plan, noise=0.0, arms=0.3)
        found = flights(motion)
        assert len(found) == 3
        assert flights(leaper(plan, noise=0.0, arms=0.3, up="z")[0]) == found
        assert flights(scaled(motion, 39.37)) == found
        assert flights(moved(motion, rotation.about_axis(1, 1.0), np.array([5.0, -3.0, 2.0]))) == found
        # Any order that has parents before their children.
        rng, order = np.random.default_rng(1), [0]
        while len(order) < motion.skeleton.n_joints:
            below = [j for j, parent in enumerate(motion.skeleton.parents) if parent in order and j not in order]
            order.append(int(rng.choice(below)))
        assert order != sorted(order)
        assert flights(permuted(motion, order)) == found
        nameless = flights(renamed(motion, {name: f"j{i}" for i, name in enumerate(motion.skeleton.names)}))
        np.testing.assert_allclose(nameless, found, atol=3)

    @pytest.mark.parametrize("rate", [30, 120])
    @pytest.mark.parametrize("stance", [0.4, 0.56, 0.75, 1.0])
    def test_a_walk_has_none(self, stance: float, rate: int) -> None:
        motion, _ = strides(stance, rate=rate)
        # Hips that rise and fall over each step, hard: by 5 cm, a fall of up to gravity's half.
        times = np.arange(motion.n_frames) / rate
        step = stance / (0.6 + 0.03 * min(1.0, stance - 0.4)) / 2
        bob = np.minimum(0.05, 0.45 * GRAVITY * (step / (2 * np.pi)) ** 2) * np.cos(2 * np.pi * times / step)
        local = motion.local_translations.copy()
        local[:, 0, 1] += bob
        for joint, parent in enumerate(motion.skeleton.parents):
            if parent == 0 and "Head" not in motion.skeleton.names[joint]:
                local[:, joint, 1] -= bob
        assert flights(replace(motion, translations=local)) == []

    @pytest.mark.parametrize("seconds", [1.0, 1.6])
    def test_a_cartwheel_has_none(self, seconds: float) -> None:
        # A stiff figure that rolls over hands and feet like a wheel.
        motion, _ = leaper([Phase(1.0, "both")], noise=0.0)
        rest = motion.positions[0]
        hands = rest.copy()
        for name, side in (("LeftHand", 0.3), ("RightHand", -0.3)):
            hands[motion.skeleton.index(name)] = [side, 1.9, 0.0]
        # About the middle of the body, whose height above the ground is the least that keeps all of it there.
        rate, n_frames = 120, round((1 + seconds) * 120)
        angle = 2 * np.pi * np.clip(np.arange(n_frames) / rate - 0.5, 0, seconds) / seconds
        middle = hands - [0.0, 0.95, 0.0]
        turned = rotation.rotate(
            rotation.about_axis(2, angle)[:, None], np.broadcast_to(middle, (n_frames, *middle.shape))
        )
        turned[..., 1] -= turned[..., 1].min(axis=1, keepdims=True)
        local = turned.copy()
        for joint, parent in enumerate(motion.skeleton.parents):
            if parent >= 0:
                local[:, joint] = turned[:, joint] - turned[:, parent]
        assert flights(replace(motion, rotations=rotation.identity(n_frames, len(rest)), translations=local)) == []

    @pytest.mark.parametrize("seconds", [0.5, 0.7])
    def test_a_leg_that_is_kicked_up_is_none(self, seconds: float) -> None:
        # Up a step, and one leg up to the head and down again: the mean of the joints rises and falls, well off the
        # lowest that anything was.
        motion, _ = leaper([Phase(2.0, "both")], noise=0.0)
        times = np.arange(motion.n_frames) / 120
        share = np.clip((times - 0.7) / seconds, 0, 1)
        rise = np.clip(np.minimum(times - 0.1, 2.0 - times) / 0.5, 0, 1)
        stair = 0.18 * rise * rise * (3 - 2 * rise)
        places = motion.positions + stair[:, None, None] * [0, 1, 0]
        for name, height in (("LeftLeg", 0.8), ("LeftFoot", 1.6), ("LeftToe", 1.7)):
            places[:, motion.skeleton.index(name), 1] += height * np.sin(np.pi * share) ** 2
        local = places.copy()
        for joint, parent in enumerate(motion.skeleton.parents):
            if parent >= 0:
                local[:, joint] = places[:, joint] - places[:, parent]
        kick = replace(motion, translations=local)
        mean = places[..., 1].mean(axis=1)
        assert np.diff(mean, n=2).min() * 120**2 < -GRAVITY / 2
        assert flights(kick) == []

    def test_a_handstand_has_none(self) -> None:
        motion, _ = leaper([Phase(3.0, "both")], noise=0.002)
        upside_down = motion.local_translations * [1, -1, 1]
        assert flights(replace(motion, translations=upside_down)) == []

    def test_noise_makes_none(self) -> None:
        for seed in range(5):
            assert flights(leaper([Phase(4.0, "both")], noise=0.01, seed=seed, rate=60)[0]) == []

    def test_a_foot_that_hangs_still_in_a_leap_is_no_stance(self) -> None:
        # One foot stays where it is in the air, the body goes up and down over it.
        motion, aloft = leaper(jumps(0.6), noise=0.0)
        local = motion.local_translations.copy()
        joint = motion.skeleton.index("LeftToe")
        place = motion.positions[:, joint].copy()
        frames = np.flatnonzero(aloft)[18:-18]
        place[frames, 1] = place[frames[0], 1]
        local[:, joint] = place - motion.positions[:, motion.skeleton.parents[joint]]
        assert len(flights(replace(motion, translations=local))) == 1

    def test_flights_under_a_tenth_of_a_second_may_be_missed(self) -> None:
        _, recall = precision_and_recall(run(0.27, 0.08), speed=2.5, lift=0.3)
        assert recall < 0.5

    def test_a_least_clearance_and_a_least_length_leave_some_out(self) -> None:
        motion, _ = leaper(jumps(0.2, 0.6))
        both = flights(motion)
        assert len(both) == 2
        assert flights(motion, clearance=0.3) == both[1:]
        assert flights(motion, minimum=0.3) == both[1:]


def test_walks_have_none_and_every_step_of_a_run_has_one(mocap: Path) -> None:
    clips = Library(mocap)
    for walk in ("07_01", "07_09", "07_10", "07_12", "29_01"):
        assert flights(clips[walk]) == []
    # Three forward, three back, three forward, and one in the middle of the second turn.
    assert len(flights(clips["01_01"])) == 10


class TestWithin:
    def test_ends_belong_to_a_span_and_a_margin_widens_it(self) -> None:
        times = np.arange(10) / 10
        assert np.flatnonzero(within(times, [(0.3, 0.5), (0.8, 0.8)])).tolist() == [3, 4, 5, 8]
        assert np.flatnonzero(within(times, [(0.3, 0.5)], margin=0.1)).tolist() == [2, 3, 4, 5, 6]
        assert not within(times, []).any()

    def test_frames_of_a_span_made_of_frames_are_in_it(self) -> None:
        times = np.arange(1000) * (1 / 30)
        for first, last in ((1, 3), (299, 777)):
            assert np.flatnonzero(within(times, [(first / 30, last / 30)])).tolist() == list(range(first, last + 1))


class TestFlights:
    """A stick of 1.6 units of a metre, its hip 0.8 above the ground, moved up and down as a whole."""

    def stick(self, rise: np.ndarray, rate: int = 120, unit: float = 1.0) -> Motion:
        offsets = np.array([[0.0, 0, 0], [0, 0.8, 0], [0, -0.8, 0]]) / unit
        body = Skeleton(("hip", "head", "foot"), (-1, 0, 0), offsets)
        translations = np.broadcast_to(offsets, (len(rise), 3, 3)).copy()
        translations[:, 0, 1] = (0.8 + rise) / unit
        rotations = rotation.identity(len(rise), 3)
        return Motion(body, rotations, translations, Fraction(rate), metres_per_unit=unit)

    def hop(self, rate: int, start: float, speed: float, length: float) -> np.ndarray:
        """Stand, leave the ground at `start` seconds, fall freely, stand; `length` seconds in all."""
        times = np.arange(round(length * rate)) / rate - start
        in_air = (times > 0) & (times < 2 * speed / GRAVITY)
        return np.where(in_air, speed * times - GRAVITY / 2 * times**2, 0.0)

    @pytest.mark.parametrize("rate", [30, 60, 120])
    @pytest.mark.parametrize("unit", [1.0, 0.01, 0.0254])
    def test_a_jump_is_found_within_its_flight(self, rate: int, unit: float) -> None:
        speed, start = 2.5, 1.0  # half a second in the air
        (flight,) = flights(self.stick(self.hop(rate, start, speed, 3.0), rate, unit))
        first, last = start, start + 2 * speed / GRAVITY
        # Not the ends, where the body is still near the ground; but most of the time between them.
        assert first < flight[0] / rate < first + 0.1
        assert last - 0.1 < flight[1] / rate < last

    def test_two_jumps_are_two_flights(self) -> None:
        rise = np.concatenate([self.hop(120, 1.0, 2.5, 2.0), self.hop(120, 0.3, 3.0, 2.0)])
        first, second = flights(self.stick(rise))
        assert first[1] < 240 < second[0]

    def test_standing_sitting_down_and_a_hop_too_low_are_none(self) -> None:
        assert flights(self.stick(np.zeros(300))) == []
        assert flights(self.stick(-0.4 * np.linspace(0, 1, 300))) == []
        assert flights(self.stick(self.hop(120, 1.0, 0.5, 3.0))) == []

    def test_dropping_into_a_crouch_is_none(self) -> None:
        # The hip and the head fall freely for a quarter of a second, the foot stays.
        fall = -GRAVITY / 2 * np.clip(np.arange(360) / 120 - 1, 0, 0.25) ** 2
        motion = self.stick(fall)
        translations = motion.local_translations.copy()
        translations[:, 2, 1] -= fall
        assert flights(Motion(motion.skeleton, motion.rotations, translations, motion.rate, metres_per_unit=1.0)) == []

    def test_being_lifted_is_none(self) -> None:
        # Up a metre and down again within 2 s, smoothly: off the ground, but not falling freely.
        times = np.arange(360) / 120
        rise = np.where((times > 0.5) & (times < 2.5), 0.5 - 0.5 * np.cos(np.pi * (times - 0.5)), 0.0)
        assert flights(self.stick(rise)) == []

    @pytest.mark.parametrize("n_frames", [1, 2, 3, 7])
    def test_a_clip_too_short_to_tell_has_none(self, n_frames: int) -> None:
        assert flights(self.stick(np.zeros(n_frames))) == []


TABLE = json.loads(Path(__file__).with_name("flight_corrections.json").read_text())


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row["is"])
def test_what_a_person_says_of_flights_holds(row: dict[str, Any]) -> None:
    marked = {flies: [(start, end) for start, end, said in row["marks"] if said is flies] for flies in (True, False)}
    found = [(start, end) for start, end in row["found"]]
    expected = sorted([*((start, end) for start, end in row["left"]), *marked[True]])
    assert corrected_flights(found, flown=marked[True], grounded=marked[False]) == expected


@pytest.mark.parametrize("seed", range(20))
def test_corrected_flights_are_what_each_moment_says(seed: int) -> None:
    """Moment by moment: marked as flown; or found, in a flight that no mark touches, and not denied."""
    rng = np.random.default_rng(seed)

    def spans(n: int) -> list[tuple[float, float]]:
        starts = rng.integers(0, 40, n)
        return [
            (float(start), float(start + length)) for start, length in zip(starts, rng.integers(1, 8, n), strict=True)
        ]

    found, flown, grounded = (spans(int(rng.integers(0, 5))) for _ in range(3))
    corrected = corrected_flights(found, flown=flown, grounded=grounded)
    assert corrected == sorted(corrected)
    for moment in np.arange(0, 48) + 0.5:

        def holds(stretches: list[tuple[float, float]], moment: float = moment) -> bool:
            return any(start < moment < end for start, end in stretches)

        untouched = [(a, b) for a, b in found if not any(start <= b and a <= end for start, end in flown)]
        assert holds(corrected) == (holds(flown) or (holds(untouched) and not holds(grounded))), moment


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.integers(-4, 40), st.integers(-4, 40))),
    st.lists(st.integers(-90, 900).map(lambda hundredths: hundredths / 60)),
    st.sampled_from([0.0, 1 / 30, 0.25]),
)
def test_what_lies_in_some_stretches_lies_in_one_of_them(
    frames: list[tuple[int, int]], times: list[float], margin: float
) -> None:
    """Of stretches in any order, that overlap, are single moments, or end before they begin."""
    spans = [(first / 30, last / 30) for first, last in frames]
    ends = [time + side * margin for span in spans for time in span for side in (-1, 0, 1)]
    asked = [*times, *ends, float("nan")]
    assert within(asked, spans, margin=margin).tolist() == literal.within(asked, spans, margin)

"""What people pass: each call with each type is accepted and means one thing, or is refused and says what to pass."""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime import (
    InvalidMotionError,
    Keytime,
    Lock,
    Motion,
    OptionError,
    PoseOptions,
    Reference,
    Signal,
    Skeleton,
    Warp,
    apply_warp,
    contacts,
    guided_warp,
    imitate,
    linear_warp,
    plot_warps,
    read,
    read_warp,
    retimed_slip,
    spline_warp,
    write,
    write_warp,
)
from retime.motion.contacts import Contacts, Foot

NTSC = Fraction(30000, 1001)
ONE = Skeleton(("root",), (-1,), np.zeros((1, 3)))
RATES = [
    (30, Fraction(30)),
    (30.0, Fraction(30)),
    (29.97, NTSC),
    (Fraction(30000, 1001), NTSC),
    (Fraction(1, 2), Fraction(1, 2)),
    ("30", Fraction(30)),
    ("29.97", NTSC),
    ("30000/1001", NTSC),
    (np.int64(30), Fraction(30)),
    (np.float32(29.97), NTSC),
    (np.float64(29.97), NTSC),
    (Decimal("29.97"), NTSC),
    (0, None),
    (-30, None),
    (Fraction(-30), None),
    (Fraction(0), None),
    (float("nan"), None),
    (float("inf"), None),
    ("fast", None),
    ("", None),
    (None, None),
    (True, None),
    (30j, None),
    ([30], None),
    (b"30", None),
]


def of_motion(rate):
    return Motion(ONE, np.tile([1.0, 0, 0, 0], (3, 1, 1)), rate=rate).rate


def of_signal(rate):
    return Signal(("x",), np.zeros((3, 1)), rate).rate


def of_contacts(rate):
    return Contacts((Foot(0),), np.zeros((3, 1), bool), rate).rate


def with_rate(rate):
    return Signal(("x",), np.zeros((1, 1))).with_rate(rate).rate


@pytest.mark.parametrize("call", [of_motion, of_signal, of_contacts, with_rate])
@pytest.mark.parametrize(("rate", "expected"), RATES, ids=[repr(rate) for rate, _ in RATES])
def test_rates(call, rate, expected) -> None:
    if expected is None:
        with pytest.raises(OptionError, match="expected a frame rate"):
            call(rate)
    else:
        found = call(rate)
        assert found == expected
        assert isinstance(found, Fraction)


CLIP = retime.sample()[:180]
WAVE = np.sin(np.arange(90) ** 2 / 900)
KEYS = [(1.0, 0.8)]
RESULT = guided_warp(CLIP, length="75%")
WARP = RESULT.warp
SLOW = Warp([0.0, 2.0], [0.0, 1.0])


def solved(**options):
    return guided_warp(CLIP, **{"length": "75%", **options}).warp


def shown(clip, warp, **options):
    return apply_warp(clip, warp, **options).rotations.tolist()


def imitated(example, hand):
    """Imitate a stretch that is no cycle and unlike the rest, which it warns of."""
    with pytest.warns(retime.RetimeWarning):
        return imitate(CLIP, example, hand).warp


def drawn(warps, **options):
    pytest.importorskip("matplotlib", reason="needs the extra plot")
    axes = plot_warps(warps, **options).axes[0]
    return [line.get_xydata().tolist() for line in axes.lines if not line.get_label().startswith("_")]


class Holding:
    """Has a warp, as a result has."""

    def __init__(self, warp: Warp) -> None:
        self.warp = warp


# A call, and another that must mean the same.
ACCEPTED = {
    "length: float": (lambda: solved(length=2.25), lambda: solved(length="135f")),
    "length: numpy float": (lambda: solved(length=np.float32(2.25)), lambda: solved(length="135f")),
    "length: text without unit": (lambda: solved(length="2.25"), lambda: solved(length="135f")),
    "length: timecode": (lambda: solved(length="00:00:02:15"), lambda: solved(length="135f")),
    "max_length: float": (
        lambda: solved(length="free", max_length=2.5),
        lambda: solved(length="free", max_length="150f"),
    ),
    "keys: lists": (lambda: solved(keys=[[1, 0.8]]), lambda: solved(keys=KEYS)),
    "keys: array": (lambda: solved(keys=np.array(KEYS)), lambda: solved(keys=KEYS)),
    "keys: text": (lambda: solved(keys=[("60f", "0.8s")]), lambda: solved(keys=KEYS)),
    "keys: numpy": (lambda: solved(keys=[(np.int64(1), np.float64(0.8))]), lambda: solved(keys=KEYS)),
    "keys: fractions": (lambda: solved(keys=[(Fraction(1), Fraction(4, 5))]), lambda: solved(keys=KEYS)),
    "keys: as typed": (lambda: solved(keys=["60f=0:00.8"]), lambda: solved(keys=KEYS)),
    "locks: as typed": (lambda: solved(locks=["1..2=1/2-1"]), lambda: solved(locks=[Lock(1, 2, 0.5, 1)])),
    "keys: Keytime": (lambda: solved(keys=[Keytime(input_time=1, output_time=0.8)]), lambda: solved(keys=KEYS)),
    "keys: no speed": (lambda: solved(keys=[(1.0, 0.8, None)]), lambda: solved(keys=KEYS)),
    "keys: speed as text": (lambda: solved(keys=[(1, 0.8, "1/2")]), lambda: solved(keys=[(1, 0.8, 0.5)])),
    "locks: numpy": (lambda: solved(locks=[Lock(np.int64(1), np.float32(2))]), lambda: solved(locks=[Lock(1.0, 2.0)])),
    "speed: list": (lambda: solved(speed=[0.5, 4]), lambda: solved(speed=(0.5, 4.0))),
    "speed: text": (lambda: solved(speed="1/2..4"), lambda: solved(speed=(0.5, 4.0))),
    "speed: texts": (lambda: solved(speed=("1/2", np.int64(4))), lambda: solved(speed=(0.5, 4.0))),
    "max_skip: float": (lambda: solved(max_skip=6.0), lambda: solved(max_skip=6)),
    "upsample: numpy": (lambda: solved(upsample=np.uint8(2)), lambda: solved(upsample=2)),
    "n_neighbors: float": (lambda: solved(n_neighbors=2.0), lambda: solved(n_neighbors=2)),
    "time_scale: numpy": (lambda: solved(time_scale=np.float64(0.1)), lambda: solved(time_scale=0.1)),
    "rate: fraction": (lambda: solved(rate=Fraction(15)), lambda: solved(rate="15")),
    "influence: lists": (
        lambda: solved(influence=[[0, 0], [2, 1]]),
        lambda: solved(influence=np.array([[0.0, 0], [2, 1]])),
    ),
    "features: a name": (lambda: solved(features="torso"), lambda: solved(features=PoseOptions("torso"))),
    "features: one a clip": (lambda: solved(features=[PoseOptions("torso")]), lambda: solved(features="torso")),
    "reference: itself": (lambda: solved(reference=[Reference(CLIP)]), lambda: solved(reference=Reference(CLIP))),
    "motion: a tuple": (lambda: guided_warp((CLIP,), length="75%").warp, solved),
    "array: a list": (
        lambda: guided_warp(WAVE.tolist(), rate="30", length="75%").warp,
        lambda: guided_warp(WAVE[:, None], rate=30, length="75%").warp,
    ),
    "apply_warp: result": (lambda: shown(CLIP, RESULT), lambda: shown(CLIP, WARP)),
    "apply_warp: array": (
        lambda: apply_warp(WAVE[:61], SLOW, rate="60").tolist(),
        lambda: apply_warp(Signal(("x",), WAVE[:61, None], 60), SLOW).values[:, 0].tolist(),
    ),
    "apply_warp: points": (
        lambda: apply_warp(np.arange(366.0).reshape(61, 2, 3), SLOW, rate=60).tolist(),
        lambda: apply_warp(np.arange(366.0).reshape(61, 6), SLOW, rate=60).reshape(-1, 2, 3).tolist(),
    ),
    "apply_warp: ints": (
        lambda: apply_warp([0, 1, 2], SLOW, rate=2).tolist(),
        lambda: [0.0, 0.5, 1.0, 1.5, 2.0],
    ),
    "retimed_slip: result": (
        lambda: retimed_slip(CLIP, RESULT).plain.millimetres.tolist(),
        lambda: retimed_slip(CLIP, WARP).plain.millimetres.tolist(),
    ),
    "compose: result": (lambda: WARP.compose(RESULT), lambda: WARP.compose(WARP)),
    "imitate: result": (
        lambda: imitated((np.int64(0), 61), Holding(SLOW)),
        lambda: imitated((0, 61), SLOW),
    ),
    "linear_warp: tuples": (
        lambda: linear_warp([(0, 0), (3, 2)]),
        lambda: linear_warp([Keytime(input_time=0, output_time=0), Keytime(input_time=3, output_time=2)]),
    ),
    "spline_warp: array": (
        lambda: spline_warp(np.array([(0, 0), (1, 0.5), (3, 2)]), rate="60"),
        lambda: spline_warp([(0, 0), (1, 0.5), (3, 2)], rate=60.0),
    ),
    "Warp: numbers of any type": (
        lambda: Warp([Fraction(0), 2], np.array([0, 1], np.int8), [[0, 0]]),
        lambda: Warp([0.0, 2.0], [0.0, 1.0], (Keytime(input_time=0, output_time=0),)),
    ),
    "Signal: names in a list": (lambda: Signal(["a"], [[1]], 30).names, lambda: ("a",)),
    "Skeleton: lists": (lambda: Skeleton(["a"], [-1], [[0, 0, 0]]).names, lambda: ("a",)),
    "plot_warps: one": (lambda: drawn(WARP), lambda: drawn([WARP])),
    "plot_warps: results by name": (lambda: drawn({"g": RESULT}), lambda: drawn({"g": WARP})),
    "plot_warps: keytimes in tuples": (
        lambda: drawn(WARP, keytimes=[(1, 0.8)]),
        lambda: drawn(WARP, keytimes=[Keytime(input_time=1, output_time=0.8)]),
    ),
}


@pytest.mark.parametrize("name", ACCEPTED)
def test_what_is_accepted_means_the_same(name) -> None:
    call, same = ACCEPTED[name]
    assert call() == same()


# A call, and what its refusal says.
REFUSED = {
    # It meant frames, and would mean seconds.
    "length: int": (lambda: solved(length=90), 'write "90f" for frames, or "90s" for seconds'),
    "length: numpy int": (lambda: solved(length=np.int64(90)), 'write "90f" for frames, or "90s" for seconds'),
    "max_length: int": (lambda: solved(length="free", max_length=90), 'write "90f" for frames'),
    "length: not a number": (lambda: solved(length=float("nan")), "a length such as 65%"),
    "length: true": (lambda: solved(length=True), "a length such as 65%"),
    "length: list": (lambda: solved(length=[90]), "a length such as 65%"),
    "keys: one flat": (lambda: solved(keys=(1.0, 0.8)), r"a key is \(input time, output time\).*; found 1\.0"),
    "keys: one Keytime": (lambda: solved(keys=Keytime(input_time=1, output_time=1)), "keys are a sequence.*a Keytime"),
    "keys: a mapping": (lambda: solved(keys={1: 0.8}), "keys are a sequence.*a dict"),
    "keys: a text": (lambda: solved(keys="1=0.8"), "keys are a sequence.*the text '1=0.8'"),
    "keys: a number": (lambda: solved(keys=5), "keys are a sequence.*the number 5"),
    "keys: none": (lambda: solved(keys=[None]), "a key is .*found None"),
    "keys: complex": (lambda: solved(keys=[(1j, 1)]), "expected a time such as 2.5"),
    "keys: true": (lambda: solved(keys=[(True, 1)]), "expected a time such as 2.5"),
    "locks: one": (lambda: solved(locks=Lock(1, 2)), r"locks=\[Lock\(6\.12, 6\.52\)\]; found a Lock"),
    "locks: tuples": (lambda: solved(locks=[(1, 2)]), "a sequence of Lock"),
    "locks: none": (lambda: solved(locks=None), "a sequence of Lock.*found None"),
    "Lock: text": (lambda: Lock("1s", 2), "the start of a lock must be a number, found the text '1s'"),
    "speed: one": (lambda: solved(speed=2), r"speed is \(slowest, fastest\).*; found the number 2"),
    "speed: the fastest first": (lambda: solved(speed=(4, 0.5)), "the slowest first"),
    "speed: a text that is none": (lambda: solved(speed="fast"), "playback speed"),
    "max_skip: text": (lambda: solved(max_skip="8"), "max_skip must be a whole number, found the text '8'"),
    "max_skip: fraction": (lambda: solved(max_skip=8.5), "max_skip must be a whole number, found the number 8.5"),
    "upsample: true": (lambda: solved(upsample=True), "upsample must be a whole number"),
    "n_neighbors: text": (lambda: solved(n_neighbors="3"), "n_neighbors must be a whole number"),
    "time_scale: text": (lambda: solved(time_scale="0.2"), "time scale must be a number"),
    "low_pass: none": (lambda: solved(low_pass=None), "low pass must be a number, found None"),
    "smoothing: text": (lambda: solved(smoothing="5"), "smoothing must be a number"),
    "smoothness: text": (lambda: solved(smoothness="a"), "smoothness must be a number"),
    "influence: text": (lambda: solved(influence="a"), "influence must be real numbers; found text"),
    "score": (lambda: solved(score="x"), "one of joint, conditional; found 'x'"),
    "search": (lambda: solved(search="x"), "one of priced, layered, heuristic; found 'x'"),
    "features": (lambda: solved(features="nose"), "one of torso, heading, signal; found 'nose'"),
    "free_weight": (lambda: solved(free_weight="x"), "one of neutral, sum; found 'x'"),
    "up": (lambda: read("a.bvh", up="x"), "up must be one of y, z; found 'x'"),
    "motion: path": (lambda: guided_warp("walk.bvh"), "a file is read by retime.read.*found the text 'walk.bvh'"),
    "motion: warp": (lambda: guided_warp(WARP), "expected a motion.*found a Warp"),
    "motion: none": (lambda: guided_warp(None), "expected a motion.*found None"),
    "motion: clip and array": (lambda: guided_warp([CLIP, WAVE], rate=30), "a group holds no arrays"),
    "motion: complex": (lambda: guided_warp(WAVE + 0j, rate=30), "complex numbers"),
    "motion: array without rate": (lambda: guided_warp(WAVE), r"guided_warp\(array, rate=30\)"),
    "reference: path": (lambda: solved(reference="x.bvh"), "a file is read by retime.read"),
    "Reference: path": (lambda: Reference("x.bvh"), "expected a motion.*found the text 'x.bvh'"),
    "Reference: number": (lambda: Reference(5), "expected a motion.*found the number 5"),
    "Reference: weight": (lambda: Reference(CLIP, weight="2"), "weight of a reference must be a number"),
    "Reference: joint map": (lambda: Reference(CLIP, joint_map=["a"]), "a joint map is a mapping.*found a list"),
    "apply_warp: swapped": (lambda: apply_warp(WARP, CLIP), r"the clip comes first: apply_warp\(motion, warp\)"),
    "apply_warp: swapped result": (lambda: apply_warp(RESULT, CLIP), "the clip comes first"),
    "apply_warp: path": (lambda: apply_warp(CLIP, "w.json"), r"found the text 'w.json'; .*Warp\.load\(path\)"),
    "apply_warp: path of the clip": (lambda: apply_warp("a.bvh", WARP), "found the text 'a.bvh'"),
    "apply_warp: no warp": (lambda: apply_warp(CLIP, None), "found None"),
    "apply_warp: group": (lambda: apply_warp([CLIP, CLIP], WARP), "must be an array of real numbers"),
    "apply_warp: array without rate": (
        lambda: apply_warp(WAVE, WARP),
        r"needs its rate: apply_warp\(array, warp, rate=30\)",
    ),
    "apply_warp: clip with rate": (lambda: apply_warp(CLIP, WARP, rate=30), "a motion has its own rate"),
    "apply_warp: contacts": (
        lambda: apply_warp(CLIP, WARP, contacts=np.ones(3)),
        "contacts must be Contacts, 'find' or None",
    ),
    "retimed_slip: swapped": (lambda: retimed_slip(WARP, CLIP), r"retimed_slip\(motion, warp\) with a Motion"),
    "retimed_slip: signal": (lambda: retimed_slip(Signal(("x",), [[1.0]]), WARP), "with a Motion, for feet slip"),
    "retimed_slip: contacts": (lambda: retimed_slip(CLIP, WARP, contacts="all"), "contacts must be Contacts or None"),
    "contacts: array": (lambda: contacts(WAVE), "with a Motion, for feet stand; found an array"),
    "imitate: swapped": (lambda: imitate(SLOW, (0, 60), CLIP), r"imitate\(motion, \(start, stop\), warp\)"),
    "imitate: no warp": (lambda: imitate(CLIP, (0, 60), CLIP), "found a Motion"),
    "imitate: no range": (lambda: imitate(CLIP, 60, SLOW), r"the example is \(first frame"),
    "linear_warp: clip": (lambda: linear_warp(CLIP), "expected keytimes.*found a Motion"),
    "spline_warp: rate": (lambda: spline_warp([(0, 0), (1, 1)], rate="fast"), "expected a frame rate"),
    "Warp: text": (lambda: Warp("ab", "ab"), "must be real numbers; found text"),
    "Warp: none": (lambda: Warp(None, None), "None is not a number"),
    "Warp: complex": (lambda: Warp([0, 1j], [0, 1]), "complex numbers"),
    "Warp: name": (lambda: Warp([0, 1], [0, 1], name=5), "the name of a warp is text, found the number 5"),
    "warp(text)": (lambda: WARP("1s"), "output times must be real numbers; found text"),
    "warp(None)": (lambda: WARP(None), "None is not a number"),
    "warp.speed(text)": (lambda: WARP.speed("1s"), "output times must be real numbers"),
    "warp.smooth(text)": (lambda: WARP.smooth("a"), "smoothing window must be a number"),
    "warp.compose(clip)": (lambda: WARP.compose(CLIP), "found a Motion"),
    "warp.save(warp)": (lambda: WARP.save(WARP), r"warp\.save\(path\) with a path, found a Warp"),
    "Warp.load(warp)": (lambda: Warp.load(WARP), "with a path, found a Warp"),
    "write_warp: swapped": (lambda: write_warp("w.json", WARP), r"expected write_warp\(warp, path\)"),
    "write_warp: clip": (lambda: write_warp(CLIP, "w.json"), "found a Motion"),
    "write: swapped": (lambda: write("a.bvh", CLIP), r"expected write\(motion, path\).*found the text 'a.bvh'"),
    "write: warp": (lambda: write(WARP, "w.json"), r"found a Warp; warp\.save\(path\)"),
    "write: no path": (lambda: write(CLIP, None), "with a path, found None"),
    "read: clip": (lambda: read(CLIP), r"read\(path\) with a path, found a Motion"),
    "read_warp: warp": (lambda: read_warp(WARP), "with a path, found a Warp"),
    "plot_warps: clip": (lambda: plot_warps(CLIP), "found a Motion"),
    "plot_warps: path": (lambda: plot_warps("w.json"), "found the text 'w.json'"),
    "plot_warps: motion": (lambda: plot_warps(WARP, motion=WAVE), "with a motion or a signal, found an array"),
    "plot_warps: explanation": (lambda: plot_warps(WARP, explanation=RESULT), r"result\.explain\(\)"),
    "plot_warps: path to write": (lambda: plot_warps(WARP, path=5), "with a path, found the number 5"),
    "plot_warps: n_poses": (lambda: plot_warps(WARP, n_poses="x"), "n_poses must be a whole number"),
    "motion.at(text)": (lambda: CLIP.at("1s"), "times must be real numbers; found text"),
    "Motion: skeleton": (lambda: Motion(5, CLIP.rotations), "expected a Skeleton, found the number 5"),
    "Motion: complex": (lambda: Motion(CLIP.skeleton, CLIP.rotations + 0j), "complex numbers"),
    "Signal: names in one text": (
        lambda: Signal("ab", np.zeros((3, 2))),
        "a text for each channel, found the text 'ab'",
    ),
    "Signal: names": (lambda: Signal(5, [[1.0]]), "found the number 5"),
    "Skeleton: names in one text": (lambda: Skeleton("a", (-1,), [[0, 0, 0]]), "a text for each joint"),
    "PoseOptions: weights": (
        lambda: PoseOptions(weights=[1]),
        "weights are a mapping of names to numbers, found a list",
    ),
    "PoseOptions: weight": (lambda: PoseOptions(weights={"a": "x"}), "the weight of 'a' must be a number"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_says_what_to_pass(name, tmp_path, monkeypatch) -> None:
    call, says = REFUSED[name]
    monkeypatch.chdir(tmp_path)
    with pytest.raises((OptionError, InvalidMotionError), match=says):
        call()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", [Warp, Motion, Signal, Skeleton])
def test_what_is_declared_to_type_checkers_is_what_there_is(kind) -> None:
    (declared,) = [
        node
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(kind))))
        if isinstance(node, ast.FunctionDef) and node.name == "__init__"
    ]
    there = list(inspect.signature(kind).parameters.values())
    assert [arg.arg for arg in declared.args.args] == ["self", *(parameter.name for parameter in there)]
    defaults = [parameter.default for parameter in there if parameter.default is not parameter.empty]
    known = vars(sys.modules[kind.__module__])
    assert [eval(ast.unparse(default), known) for default in declared.args.defaults] == defaults

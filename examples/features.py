"""Every feature of the guide on a real clip, with a picture of each.

Usage: python examples/features.py [FOLDER] (default: docs/images/guide)

The shipped sample serves for all of it. The reference with another skeleton needs two captures, which are looked for in
../shared/mocap beside the checkout; without them that picture is left as it is.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np

import retime
from retime.motion.flights import flights
from retime.search.keytimes import as_keytimes

ROOT = Path(__file__).resolve().parents[1]
MOCAP = ROOT.parent / "shared" / "mocap"
CLIP = retime.sample()
RATE = float(CLIP.rate)
CYCLE, WALK = CLIP.frames(100, 200), CLIP.frames(60, 190)
# A stride of the first walk (first frame, and the one after its last), and where it changes feet; two steps of the
# second walk, which begin with the other foot.
STRIDE, HALF_STRIDE = (81, 151), 35 / RATE
LATER_STEPS = np.array([512, 547, 581]) / RATE
(FIRST_UP, FIRST_DOWN), (SECOND_UP, SECOND_DOWN) = [(a / RATE, b / RATE) for a, b in flights(CLIP)]


def camera_path() -> retime.Signal:
    """Make a camera path of eight seconds that waits, pans, and waits."""
    t = np.arange(240) / 30
    pan = 90 / (1 + np.exp(-6 * (t - 4)))
    path = np.stack([pan, 2 + 0.05 * np.sin(0.7 * t), 0.3 * t], axis=1)
    return retime.Signal(("yaw", "height", "dolly"), path, Fraction(30), name="camera")


def pan_of_the_clip() -> retime.Signal:
    """Make a camera's pan that goes with the clip: it turns while the figure stands still."""
    yaw = 90 / (1 + np.exp(-6 * (np.arange(CLIP.n_frames) / RATE - PANS_AT)))
    return retime.Signal(("yaw",), yaw[:, None], Fraction(CLIP.rate), name="camera")


PANS_AT = 4.5
CAMERA, PAN = camera_path(), pan_of_the_clip()


def hold() -> dict[str, retime.Warp]:
    """Hold the top of the second jump for half a second."""
    top = (SECOND_UP + SECOND_DOWN) / 2
    result = retime.guided_warp(CLIP, keys=[(top, top), (top, top + 0.5)])
    shown = result.warp(np.linspace(top, top + 0.5, 11))
    assert np.allclose(shown, top)
    return {"guided": result.warp}


def backward() -> dict[str, retime.Warp]:
    """Play the second jump, back to its take-off, and again."""
    keys = [(SECOND_DOWN, 6.0), (SECOND_UP, 6.6), (CLIP.end_time, 9.0)]
    result = retime.guided_warp(CLIP, length="9.0167s", keys=keys)
    assert np.all(result.warp.speed(np.linspace(6.1, 6.5, 9)) < 0)
    return {"guided": result.warp}


def locked_jump() -> dict[str, retime.Warp]:
    """Lock the second jump to half speed; all else as it likes."""
    lock = retime.Lock(SECOND_UP, SECOND_DOWN, 0.5, 0.5)
    free = retime.guided_warp(CLIP, length="80%")
    result = retime.guided_warp(CLIP, length="80%", locks=[lock])
    inside = (result.staircase.input_times[:-1] >= SECOND_UP + 0.05) & (
        result.staircase.input_times[1:] <= SECOND_DOWN - 0.05
    )
    assert np.allclose(result.staircase.slopes[inside], 0.5)
    return {"guided": free.warp, "jump locked to 1/2": result.warp}


def tangent() -> dict[str, retime.Warp]:
    """Crouch at twice the speed, and land at half."""
    keys = [(SECOND_UP - 0.6, 7.0, 2.0), (SECOND_DOWN + 0.2, 8.2, 0.5)]
    result = retime.guided_warp(CLIP, length="75%", keys=keys, smoothness=0.3)
    for _, out, speed in keys:
        assert np.allclose(result.warp.speed([out - 1e-3, out + 1e-3]), speed)
    return {"guided": result.warp, "spline": spline(result)}


def spline(result: retime.GuidedWarp) -> retime.Warp:
    """Return the spline through a result's keytimes; where a tangent is too steep for it, it says so."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", retime.RetimeWarning)
        return retime.spline_warp(result.warp.keytimes, rate=RATE)


def blend() -> dict[str, retime.Warp]:
    """Mix the guided warp and the spline, through the same keytimes."""
    keys = [(SECOND_UP, 6.5)]
    mixed = {
        f"influence {name}": retime.guided_warp(CLIP, length="65%", keys=keys, influence=share).warp
        for name, share in (("0", 0.0), ("1/2", 0.5), ("1", 1.0))
    }
    assert all(abs(float(warp(6.5)) - SECOND_UP) < 1e-9 and warp.monotone for warp in mixed.values())
    return mixed


def many_keys() -> dict[str, retime.Warp]:
    """Put both jumps on the beat: four keys and a length, one search."""
    keys = [(FIRST_UP, 4.0), (FIRST_DOWN, 4.5), (SECOND_UP, 8.0), (SECOND_DOWN, 8.5)]
    result = retime.guided_warp(CLIP, length="10s", keys=keys)
    assert all(abs(float(result.warp(out)) - at) < 1e-9 for at, out in keys)
    keytimes = as_keytimes(CLIP, "10s", keys)
    return {"linear": retime.linear_warp(keytimes), "spline": spline(result), "guided": result.warp}


def free_length() -> dict[str, retime.Warp]:
    """Move like a jump in slow motion, and let the search find the length (V8)."""
    span = retime.Warp(np.array([0.0, 2.0]), np.array([0.0, 1.0]))
    start, stop = round((SECOND_UP - 0.25) * RATE), round((SECOND_UP + 0.75) * RATE) + 1
    slow = retime.apply_warp(CLIP.frames(start, stop), span, average=False)
    neutral = retime.guided_warp(CLIP, reference=slow, length="free")
    plain = retime.guided_warp(CLIP, reference=slow, length="free", free_weight="sum")
    return {"neutral weight": neutral.warp, "plain sum": plain.warp}


def smooth() -> dict[str, retime.Warp]:
    """Charge changes of speed."""
    return {
        f"smoothness {weight:g}": retime.guided_warp(CLIP, length="65%", smoothness=weight).warp
        for weight in (0.0, 0.3, 3.0)
    }


def limits() -> dict[str, retime.Warp]:
    """Stay between half and twice the speed."""
    result = retime.guided_warp(CLIP, length="80%", speed=(0.5, 2.0))
    assert result.path_speeds.min() >= 0.5
    assert result.path_speeds.max() <= 2
    return {"no limits": retime.guided_warp(CLIP, length="80%").warp, "1/2 to 2": result.warp}


def camera() -> dict[str, retime.Warp]:
    """Retime a camera path that waits, pans, and waits: the pan keeps its pace."""
    result = retime.guided_warp(CAMERA, length="60%")
    moved = retime.apply_warp(CAMERA, result.warp)
    assert moved.n_frames == 144
    assert moved.names == CAMERA.names
    return {"linear": retime.linear_warp(as_keytimes(CAMERA, "60%", ())), "guided": result.warp}


def another_skeleton() -> dict[str, retime.Warp] | None:
    """Give a CMU take the timing of a boxer with another skeleton."""
    if not MOCAP.is_dir():
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", retime.FormatWarning)
        clip = retime.read(MOCAP / "cmu-asfamc" / "86_01.amc").frames(1980, 2500)
        boxer = retime.read(MOCAP / "bvh-other" / "Boxing_Toes.bvh").frames(300, 900)
    result = retime.guided_warp(clip, reference=boxer, length="100%")
    assert result.n_reference == 180
    return {"guided": result.warp}


def propagate() -> dict[str, retime.Warp]:
    """Make one stride limp by hand; the steps of both walks follow, and the jumps keep their speed."""
    start, stop = STRIDE
    hand = retime.Warp([0.0, 0.35, 1.2], [0.0, HALF_STRIDE, (stop - 1 - start) / RATE])
    with warnings.catch_warnings():
        # Of the jumps, and of standing, a stride says nothing: it warns of that.
        warnings.simplefilter("ignore", retime.RetimeWarning)
        result = retime.imitate(CLIP, STRIDE, hand)
    first, last = start / RATE, (stop - 1) / RATE
    by_hand = retime.Warp(
        [0.0, first, *(first + hand.output_times[1:]), first + 1.2 + CLIP.end_time - last],
        [0.0, first, *(first + hand.input_times[1:]), CLIP.end_time],
    )
    assert result.example is not None
    assert any(start < SECOND_UP < end for start, end in result.example.unspoken)
    shown = np.interp(LATER_STEPS, result.warp.input_times, result.warp.output_times)
    # Seven seconds later the left foot's step lingers and the right one's is hurried, as in the stride.
    slow, quick = np.diff(LATER_STEPS) / np.diff(shown)
    assert quick > 1.4 * slow
    return {"by hand": by_hand, "the rest follows": result.warp}


def double() -> dict[str, retime.Warp]:
    """Keep step with a double who hurries at first, then takes time."""
    keys = [(0.0, 0.0), (FIRST_UP, 0.8 * FIRST_UP), (FIRST_DOWN, 0.8 * FIRST_UP + FIRST_DOWN - FIRST_UP)]
    late = CLIP.end_time - SECOND_UP
    keys += [(SECOND_UP, CLIP.end_time + 0.8 - late), (CLIP.end_time, CLIP.end_time + 0.8)]
    answer = retime.spline_warp([retime.Keytime(output_time=out, input_time=shown) for shown, out in keys], rate=RATE)
    double = retime.apply_warp(CLIP, answer, average=False)
    result = retime.align(CLIP, double)
    # Where the figure moves it does what the double does.
    moves = np.linspace(keys[1][1] - 0.4, keys[2][1] + 0.4, 50)
    assert np.abs(result.warp(moves) - answer(moves)).max() < 0.05
    return {"linear": retime.linear_warp(result.warp.keytimes), "align": result.warp}


def takes() -> dict[str, retime.Warp]:
    """Draw four natural timings of one clip."""
    found = retime.variants(CLIP, 4, seed=2)
    lengths = [take.warp.output_span for take in found]
    assert len(set(lengths)) == 4
    return {f"take {number}": take.warp for number, take in enumerate(found, start=1)}


def loop() -> dict[str, retime.Warp]:
    """Keep a cycle a cycle: first and last speed agree."""
    closed = retime.guided_warp(CYCLE, length="80%", loop=True).warp
    assert np.isclose(closed.slopes[0], closed.slopes[-1])
    return {"as a clip": retime.guided_warp(CYCLE, length="80%").warp, "as a loop": closed}


def weights() -> dict[str, retime.Warp]:
    """Weigh two references, a slow jump and a quick one."""
    start, stop = round((SECOND_UP - 0.25) * RATE), round((SECOND_UP + 0.75) * RATE) + 1
    jump = CLIP.frames(start, stop)
    slow, quick = (
        retime.apply_warp(jump, retime.Warp([0.0, seconds], [0.0, jump.end_time]), average=False)
        for seconds in (1.6, 0.7)
    )
    found = {
        f"{name} × 4": retime.guided_warp(
            CLIP, reference=[retime.Reference(slow, weight=a), retime.Reference(quick, weight=b)], length="free"
        ).warp
        for name, a, b in (("slow", 4, 1), ("quick", 1, 4))
    }
    lengths = [warp.output_span for warp in found.values()]
    assert lengths[0] > lengths[1]
    return found


def mirror() -> dict[str, retime.Warp]:
    """Imitate one slow left step: seen in a mirror it is a right one too."""
    left, right = (1.35, 1.93), (1.93, 2.5)
    step = CLIP.frames(round(left[0] * RATE), round(left[1] * RATE) + 1)
    slow = retime.apply_warp(step, retime.Warp([0.0, 2 * step.end_time], [0.0, step.end_time]), average=False)
    found = {
        name: retime.guided_warp(WALK, reference=retime.Reference(slow, mirror=mirrored), length="free").warp
        for name, mirrored in (("as it is", False), ("mirrored too", True))
    }

    def seconds(warp: retime.Warp, span: tuple[float, float]) -> float:
        start, end = warp.inverse()([at - 1.0 for at in span])
        return float(end - start)

    # Seen both ways, the right step gets the time of the left one.
    uneven = [abs(np.log(seconds(warp, left) / seconds(warp, right))) for warp in found.values()]
    assert uneven[1] < uneven[0]
    return found


def joints() -> dict[str, retime.Warp]:
    """Choose what counts: all joints, the arms alone, or the feet ten times."""
    arms = [name for name in CLIP.skeleton.names if "Arm" in name or "Hand" in name]
    feet = dict.fromkeys([name for name in CLIP.skeleton.names if "Foot" in name or "Toe" in name], 10.0)
    choices = {
        "all joints": None,
        "arms alone": retime.PoseOptions(joints=arms),
        "feet 10 times": retime.PoseOptions(weights=feet),
    }
    found = {name: retime.guided_warp(CLIP, length="65%", features=some) for name, some in choices.items()}
    assert len({tuple(result.path.frames.tolist()) for result in found.values()}) == 3
    return {name: result.warp for name, result in found.items()}


def group() -> dict[str, retime.Warp]:
    """Spare a camera's pan while the figure stands still: find the warp on both."""
    alone = retime.guided_warp(CLIP, length="65%").warp
    # The pan counts in standard deviations and the figure in centimetres: a weight makes them comparable.
    counts = [retime.PoseOptions(), retime.PoseOptions(weights={"yaw": 200})]
    both = retime.guided_warp([CLIP, PAN], length="65%", features=counts).warp
    moved = [retime.apply_warp(clip, both) for clip in (CLIP, PAN)]
    assert moved[0].n_frames == moved[1].n_frames
    rates = [
        float(np.median(warp.speed(warp.inverse()(np.linspace(PANS_AT - 0.3, PANS_AT + 0.3, 21)))))
        for warp in (alone, both)
    ]
    assert rates[1] < rates[0] / 2
    return {"figure alone": alone, "both": both}


def scores() -> dict[str, retime.Warp]:
    """Imitate a slowed jump by the paper's score, and by the conditional one."""
    start, stop = round((SECOND_UP - 0.25) * RATE), round((SECOND_UP + 0.75) * RATE) + 1
    slow = retime.apply_warp(CLIP.frames(start, stop), retime.Warp([0.0, 2.0], [0.0, 1.0]), average=False)
    return {
        name: retime.guided_warp(CLIP, reference=slow, length="free", score=name).warp
        for name in ("joint", "conditional")
    }


def heuristic() -> dict[str, retime.Warp]:
    """Compare the exact search with the paper's heuristic."""
    best = retime.guided_warp(CLIP, length="65%")
    found = retime.guided_warp(CLIP, length="65%", search="heuristic")
    assert best.path.optimal
    assert found.excess is not None
    assert np.isclose(found.total, best.total * (1 + found.excess))
    return {"exact": best.warp, f"heuristic, +{found.excess:.0%}": found.warp}


def explain(path: Path) -> None:
    """Say why: what each frame scored, and what was binding."""
    keys, locks = [(6.12, 4.0)], [retime.Lock(9.0, 10.0)]
    result = retime.guided_warp(CLIP, length="65%", keys=keys, locks=locks)
    why = result.explain()
    assert {"key", "lock", "fastest"} <= {word for words in why.binding for word in words.split("+")}
    retime.plot_warps(
        {"guided": result.warp}, motion=CLIP, path=path, title=title(explain), explanation=why, overwrite=True
    )


def feet(path: Path) -> None:
    """Measure how far standing feet slide at four times the speed."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    warp = retime.Warp([0.0, CLIP.end_time / 4], [0.0, CLIP.end_time])
    standing, report = retime.contacts(CLIP), retime.retimed_slip(CLIP, warp)
    assert report.contact_aware.mean < 0.75 * report.plain.mean
    with mpl.rc_context({"svg.hashsalt": "retime", "svg.fonttype": "none", "font.size": 9}):
        figure = Figure(figsize=(9.2, 3.4), layout="constrained")
        axes = figure.add_subplot()
        where = np.arange(len(report.plain.contacts))
        for offset, slip, label, color in (
            (-0.2, report.plain, "the paper's averaging", "#be185d"),
            (0.2, report.contact_aware, "standing feet exempt", "#0f766e"),
        ):
            axes.bar(
                where + offset, slip.millimetres, 0.38, label=f"{label}: {slip.mean:.1f} mm on average", color=color
            )
        names = [CLIP.skeleton.names[standing.feet[contact.foot].joint] for contact in report.plain.contacts]
        axes.set_xticks(
            where, [name.replace("Left", "L ").replace("Right", "R ").replace("Base", "") for name in names]
        )
        axes.tick_params(axis="x", labelrotation=90, length=0, labelsize=7)
        axes.set_ylabel("slip (mm)")
        axes.set_title(title(feet), loc="left", fontweight="bold")
        axes.legend(frameon=False)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        figure.savefig(path, format="svg", metadata={"Date": None})


def title(feature: Callable[..., object]) -> str:
    """Return what a feature says that it shows."""
    return (feature.__doc__ or "").splitlines()[0]


# Those that draw their own picture.
DRAWN: dict[str, Callable[[Path], None]] = {"explain": explain, "feet": feet}
# What each is shown on, beside the curves: the sample's poses; of a signal, its values. None: curves alone.
FEATURES: dict[str, tuple[Callable[[], dict[str, retime.Warp] | None], retime.Motion | retime.Signal | None]] = {
    "keytimes": (many_keys, CLIP),
    "hold": (hold, CLIP),
    "backward": (backward, CLIP),
    "lock": (locked_jump, CLIP),
    "tangent": (tangent, CLIP),
    "smoothness": (smooth, CLIP),
    "limits": (limits, CLIP),
    "blend": (blend, CLIP),
    "free": (free_length, CLIP),
    "imitate": (propagate, CLIP),
    "align": (double, CLIP),
    "variants": (takes, CLIP),
    "loop": (loop, CYCLE),
    # Its clip is a capture, which is not this repository's to show.
    "skeleton": (another_skeleton, None),
    "camera": (camera, CAMERA),
    "weights": (weights, CLIP),
    "mirror": (mirror, WALK),
    "joints": (joints, CLIP),
    "group": (group, PAN),
    "score": (scores, CLIP),
    "heuristic": (heuristic, CLIP),
}


def main() -> None:
    """Draw all of them."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "guide"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (feature, motion) in FEATURES.items():
        warps = feature()
        summary = title(feature)
        if warps is None:
            print(f"{name}: left as it is (no captures at hand)")
            continue
        retime.plot_warps(warps, motion=motion, path=folder / f"{name}.svg", title=summary, overwrite=True)
        print(f"{name}: {summary}")
    for name, draw in DRAWN.items():
        draw(folder / f"{name}.svg")
        print(f"{name}: {title(draw)}")


if __name__ == "__main__":
    main()

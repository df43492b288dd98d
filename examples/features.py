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
from retime.motion.kinematics import flights
from retime.warp.keytimes import as_keytimes

ROOT = Path(__file__).resolve().parents[1]
MOCAP = ROOT.parent / "shared" / "mocap"
CLIP = retime.sample()
RATE = float(CLIP.rate)
(FIRST_UP, FIRST_DOWN), (SECOND_UP, SECOND_DOWN) = [(a / RATE, b / RATE) for a, b in flights(CLIP)]


def hold() -> dict[str, retime.Warp]:
    """Hold the top of the first jump for half a second."""
    top = (FIRST_UP + FIRST_DOWN) / 2
    result = retime.guided_warp(CLIP, keys=[(top, top), (top, top + 0.5)])
    shown = result.warp(np.linspace(top, top + 0.5, 11))
    assert np.allclose(shown, top)
    return {"guided": result.warp}


def backward() -> dict[str, retime.Warp]:
    """Play the second jump, back to its take-off, and again."""
    keys = [(SECOND_DOWN, 6.0), (SECOND_UP, 6.6), (CLIP.duration, 9.0)]
    result = retime.guided_warp(CLIP, length="9.0167s", keys=keys)
    assert np.all(result.warp.speed(np.linspace(6.1, 6.5, 9)) < 0)
    return {"guided": result.warp}


def locked_jump() -> dict[str, retime.Warp]:
    """Lock the first jump to half speed; all else as it likes."""
    lock = retime.Lock(FIRST_UP, FIRST_DOWN, 0.5, 0.5)
    free = retime.guided_warp(CLIP, length="80%")
    result = retime.guided_warp(CLIP, length="80%", locks=[lock])
    inside = (result.steps.input_times[:-1] >= FIRST_UP + 0.05) & (result.steps.input_times[1:] <= FIRST_DOWN - 0.05)
    assert np.allclose(result.steps.slopes[inside], 0.5)
    return {"guided": free.warp, "jump locked to 1/2": result.warp}


def tangent() -> dict[str, retime.Warp]:
    """Pass a keytime at twice the speed, and another at half."""
    keys = [(3.0, 2.0, 2.0), (9.0, 6.5, 0.5)]
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
    keys = [(FIRST_UP, 3.5)]
    mixed = {
        f"influence {name}": retime.guided_warp(CLIP, length="65%", keys=keys, influence=share).warp
        for name, share in (("0", 0.0), ("1/2", 0.5), ("1", 1.0))
    }
    assert all(abs(float(warp(3.5)) - FIRST_UP) < 1e-9 and warp.monotone for warp in mixed.values())
    return mixed


def many_keys() -> dict[str, retime.Warp]:
    """Land both jumps on the beat: five keytimes, one search."""
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
    t = np.arange(240) / 30
    pan = 90 / (1 + np.exp(-6 * (t - 4)))
    path = np.stack([pan, 2 + 0.05 * np.sin(0.7 * t), 0.3 * t], axis=1)
    camera_path = retime.Signal(("yaw", "height", "dolly"), path, Fraction(30), name="camera")
    result = retime.guided_warp(camera_path, length="60%")
    moved = retime.apply_warp(camera_path, result.warp)
    assert moved.n_frames == 144
    assert moved.names == camera_path.names
    return {"linear": retime.linear_warp(as_keytimes(camera_path, "60%", ())), "guided": result.warp}


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
    """Slow the second jump to half by hand; the rest of the clip follows."""
    start, stop = round((SECOND_UP - 0.25) * RATE), round((SECOND_UP + 0.75) * RATE) + 1
    hand = retime.Warp(np.array([0.0, 2.0]), np.array([0.0, 1.0]))
    result = retime.imitate(CLIP, (start, stop), hand)
    assert result.warp.output_end > hand.output_end
    return {"the rest follows": result.warp}


def loop() -> dict[str, retime.Warp]:
    """Keep a cycle a cycle: first and last speed agree."""
    cycle = CLIP.frames(100, 200)
    closed = retime.guided_warp(cycle, length="80%", loop=True).warp
    assert np.isclose(closed.slopes[0], closed.slopes[-1])
    return {"as a clip": retime.guided_warp(cycle, length="80%").warp, "as a loop": closed}


FEATURES: dict[str, Callable[[], dict[str, retime.Warp] | None]] = {
    "keytimes": many_keys,
    "hold": hold,
    "backward": backward,
    "lock": locked_jump,
    "tangent": tangent,
    "smoothness": smooth,
    "limits": limits,
    "blend": blend,
    "free": free_length,
    "imitate": propagate,
    "loop": loop,
    "skeleton": another_skeleton,
    "camera": camera,
}


def main() -> None:
    """Draw all of them."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "guide"
    folder.mkdir(parents=True, exist_ok=True)
    for name, feature in FEATURES.items():
        warps = feature()
        summary = (feature.__doc__ or "").splitlines()[0]
        if warps is None:
            print(f"{name}: left as it is (no captures at hand)")
            continue
        retime.plot_warps(warps, path=folder / f"{name}.svg", title=summary, overwrite=True)
        print(f"{name}: {summary}")


if __name__ == "__main__":
    main()

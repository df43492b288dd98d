"""What a warp did, in a few words and numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import Spans
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_of
from retime.motion.contacts import Contacts
from retime.motion.kinematics import global_poses, metres_per_unit, torso_positions
from retime.motion.motion import Motion
from retime.search.example.reading import ExampleReading
from retime.warp.curve import Warp

# A playback speed this near to 1 counts as unit speed: nobody sees the difference.
_UNIT = 0.01


def example_text(reading: ExampleReading) -> str:
    """Say how much of a clip an example speaks for, and where it does not."""
    spans = ", ".join(f"{start:.2f}..{end:.2f}" for start, end in reading.unspoken)
    return f"speaks for {reading.share:.0%} of the clip" + (f", not for input seconds {spans}" if spans else "")


def idle_spans(motion: Motion) -> list[tuple[float, float]]:
    """Find stretches in which a figure stands still, a quarter of a second or longer.

    The root moves at less than 0.2 m/s, and the other joints at less than 0.1 m/s against it on average.
    """
    motion = body_of(motion)
    scale, rate = metres_per_unit(motion), float(motion.rate)
    if motion.n_frames < 2:
        return []
    poses = global_poses(motion)
    root = np.linalg.norm(np.gradient(poses.positions[:, 0] * scale * rate, axis=0), axis=-1)
    joints = np.linalg.norm(np.gradient(torso_positions(poses) * scale * rate, axis=0), axis=-1).mean(axis=-1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (root < 0.2) & (joints < 0.1), [0]]).astype(np.int8)))
    spans = [(start / rate, (stop - 1) / rate) for start, stop in edges.reshape(-1, 2).tolist()]
    return [(start, end) for start, end in spans if end - start >= 0.25]


def speeds_in(warp: Warp, start: float, end: float) -> FloatArray:
    """Return the speeds of the warp's pieces between two input times, else of those that cross them."""
    ends = np.sort(np.stack([warp.input_times[:-1], warp.input_times[1:]]), axis=0)
    inside = (ends[0] >= start - 1e-9) & (ends[1] <= end + 1e-9)
    if not inside.any():
        inside = (ends[0] < end) & (ends[1] > start)
    return np.asarray(warp.slopes[inside])


def at_unit_speed(speeds: FloatArray) -> bool:
    """Whether all of them are 1, as near as one can see."""
    return bool(np.all(np.abs(speeds - 1.0) < _UNIT))


def unit_share(warp: Warp) -> float:
    """Return how much of the output plays at unit speed, from 0 to 1."""
    seconds = np.diff(warp.output_times)
    return float(seconds[np.abs(warp.slopes - 1.0) < _UNIT].sum() / seconds.sum())


def output_seconds(warp: Warp, start: float, end: float, clip: AnyMotion) -> float:
    """Return how long the output shows the input between two times; the warp plays all of the clip, forward.

    A span that reaches the clip's end holds its last frame, which output and input show for a frame period each.
    """
    back = warp.inverse()
    last_frame = max(0.0, end - clip.end_time)
    return float(back(end) - back(start)) + last_frame


def length_text(n_frames: int, rate: Fraction) -> str:
    """Write a length: each frame is shown for a frame period."""
    return f"{n_frames} frame{'s' * (n_frames != 1)}, {float(n_frames / rate):.2f} s"


def rate_text(rate: Fraction) -> str:
    """Write a rate in Hz."""
    return f"{float(rate):.6g} Hz"


def speed_text(warp: Warp) -> str:
    """Write the range of speeds, and how much plays at unit speed."""
    slopes = warp.slopes
    return f"{slopes.min():.2f} to {slopes.max():.2f}; {unit_share(warp):.0%} of the output at unit speed"


def flights_text(warp: Warp, spans: Spans) -> str:
    """Write how many flights play at unit speed, and how the others play."""
    speeds = [speeds_in(warp, *span) for span in spans]
    changed = [
        f"{start:.2f}-{end:.2f} s at {_range_text(speed)}"
        for (start, end), speed in zip(spans, speeds, strict=True)
        if len(speed) and not at_unit_speed(speed)
    ]
    kept = sum(bool(len(speed)) and at_unit_speed(speed) for speed in speeds)
    text = f"{kept} of {len(spans)} kept at unit speed"
    return text + (f"; input {', '.join(changed)}" if changed else "")


def _range_text(speeds: FloatArray) -> str:
    low, high = float(speeds.min()), float(speeds.max())
    return f"{low:.2f}" if f"{low:.2f}" == f"{high:.2f}" else f"{low:.2f} to {high:.2f}"


def slip_facts(clip: AnyMotion, warp: Warp, output: AnyMotion, feet: Contacts | None) -> dict[str, float | bool] | None:
    """Measure how far standing feet slide, before and after, in millimetres a contact; None, where no foot stands.

    Beside the output as it is this is done for one in which the feet are averaged too.
    """
    from retime.warp.slip import slip_of_output

    if not isinstance(clip, Motion) or not isinstance(output, Motion) or feet is None:
        return None
    before, after, averaged = slip_of_output(clip, warp, output, feet)
    if not before.contacts:
        return None
    return {
        "contacts": len(before.contacts),
        "input_mm": before.mean,
        "output_mm": after.mean,
        "averaged_mm": averaged.mean,
        "size_guessed": before.size_guessed,
    }


def slip_text(slip: dict[str, float | bool] | None) -> str:
    """Say what `slip_facts` measured; nothing, where no foot stands."""
    if slip is None:
        return ""
    about, why = ("about ", "; the size of the figure is guessed") if slip["size_guessed"] else ("", "")
    return (
        f"standing feet slide {about}{slip['input_mm']:.1f} mm a contact in the input, {about}{slip['output_mm']:.1f} "
        f"mm in the output ({slip['averaged_mm']:.1f} mm if they were averaged too{why})"
    )

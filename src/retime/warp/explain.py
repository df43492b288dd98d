"""Why a warp is as it is: what each output frame scored, what it was matched with, and what held it back."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np

from retime.kernels import FloatArray, IntArray
from retime.warp.control import BoolArray
from retime.warp.keytimes import Reduction
from retime.warp.path import FramePath
from retime.warp.score import Model, matched_frames


@dataclass(frozen=True, eq=False)
class Explanation:
    """One row for each output frame at the analysis rate.

    Attributes
    ----------
    output_times, input_times : float arrays, shape (n_output,)
        Seconds, on the analysis grid.
    speeds : float array, shape (n_output,)
        Playback speed of the step from this frame to the next; the last one repeats.
    scores : float array, shape (n_output,)
        Local score; nan at the two ends, which have none.
    references : int array, shape (n_output, n_neighbors)
        Which reference each match is from, the nearest first; -1 at the ends.
    reference_times : float array, shape (n_output, n_neighbors)
        Its time there, seconds; nan at the ends.
    binding : tuple of str
        What bound the frame: any of "key", "lock", "fastest", "slowest", "hold", joined by "+"; "" where nothing did.
    reference_names : tuple of str
        Names of the references.
    """

    output_times: FloatArray
    input_times: FloatArray
    speeds: FloatArray
    scores: FloatArray
    references: IntArray
    reference_times: FloatArray
    binding: tuple[str, ...]
    reference_names: tuple[str, ...]

    def to_csv(self) -> str:
        """Return a table with a header: one row an output frame, one pair of columns a matched reference frame."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        n_neighbors = self.references.shape[1]
        matches = [f"{what}_{i + 1}" for i in range(n_neighbors) for what in ("reference", "reference_time")]
        writer.writerow(["output_time", "input_time", "speed", "score", *matches, "binding"])
        for i in range(len(self.output_times)):
            row: list[str] = [f"{value:.6f}" for value in (self.output_times[i], self.input_times[i], self.speeds[i])]
            row.append("" if np.isnan(self.scores[i]) else f"{self.scores[i]:.6g}")
            for which, when in zip(self.references[i], self.reference_times[i], strict=True):
                row += ["", ""] if which < 0 else [self.reference_names[which], f"{when:.6f}"]
            writer.writerow([*row, self.binding[i]])
        return out.getvalue()


def explain_path(
    reduction: Reduction,
    path: FramePath,
    model: Model,
    input_poses: FloatArray,
    allowed: BoolArray,
    *,
    references: tuple[str, ...],
    n_neighbors: int,
    score: str,
) -> Explanation:
    """Explain a path; the parameters are the fields of `retime.warp.session.GuidedWarp`."""
    frames = path.frames
    n_output = len(frames)
    which = np.full((n_output, n_neighbors), -1, dtype=np.int64)
    when = np.full((n_output, n_neighbors), np.nan)
    scores = np.full(n_output, np.nan)
    if n_output > 2:
        rows, distances = matched_frames(input_poses, frames, model, n_neighbors=n_neighbors, score=score)
        which[1:-1] = model.reference[rows]
        when[1:-1] = model.frame[rows] / reduction.rate
        scores[1:-1] = distances.mean(axis=1)
    input_times = reduction.input_times[frames]
    speeds = np.diff(input_times) * reduction.rate
    return Explanation(
        reduction.keytimes[0].output_time + np.arange(n_output) / reduction.rate,
        input_times,
        np.append(speeds, speeds[-1:]),
        scores,
        which,
        when,
        _binding(reduction, frames, allowed),
        references,
    )


def _binding(reduction: Reduction, frames: IntArray, allowed: BoolArray) -> tuple[str, ...]:
    """Say what bound each frame: the steps beside it at the end of what was allowed, or a keytime."""
    steps = np.diff(frames)
    n_steps = allowed.shape[1]
    inside = np.minimum(n_steps, reduction.n_input - 1 - frames[:-1])
    choices = allowed[frames[:-1]]
    longest = n_steps - np.argmax(choices[:, ::-1], axis=1)
    shortest = np.argmax(choices, axis=1) + 1
    only = choices.sum(axis=1) == 1
    held = reduction.held[frames[:-1]]
    # Where a keytime is near, a step ends there at the latest; that is the key's doing, not the limit's.
    fastest = (steps == longest) & (inside == n_steps) & ~only & ~held & (longest == n_steps)
    slowest = (steps == shortest) & (reduction.upsample > 1) & ~only & ~held
    lock = only & ~held & (inside > 1)
    keys = set(reduction.positions)
    words = []
    for position in range(len(frames)):
        around = [step for step in (position - 1, position) if 0 <= step < len(steps)]
        found = ["key"] if position in keys else []
        for name, flags in (("hold", held), ("lock", lock), ("fastest", fastest), ("slowest", slowest)):
            if any(flags[step] for step in around):
                found.append(name)
        words.append("+".join(found))
    return tuple(words)

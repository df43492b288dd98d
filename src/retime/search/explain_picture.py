"""A small picture of why a warp is as it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray
from retime.svg import INKS, Panel, facts_html, side_by_side, stacked, thinned

# What can be binding, from the top of the picture down.
_BINDING = ("key", "tangent", "lock", "hold", "flight", "even", "fastest", "slowest")


def explanation_html(
    times: FloatArray, all_scores: FloatArray, binding: Sequence[str], reference_names: Sequence[str]
) -> str:
    """Return what each output frame scored, and what was binding where.

    Parameters
    ----------
    times, all_scores : float arrays, shape (n_output,)
        Output time of each frame, seconds, and its score; nan where it has none.
    binding : sequence of str
        What bound each frame, as `retime.search.explain.Explanation` has it.
    reference_names : sequence of str
        What was imitated.
    """
    start, end = float(times[0]), float(times[-1])
    # The ends have no score.
    scored = np.flatnonzero(np.isfinite(all_scores))
    scores = all_scores[scored]
    worst = float(scores.max()) if len(scores) else 0.0
    panel = Panel("score (low: like the reference)", start, end, 0.0, worst)
    panel.rule(0.0, "0")
    if worst > 0:
        panel.rule(worst, f"{worst:.3g}")
        kept = scored[thinned(len(scored))]
        panel.line(times[kept], all_scores[kept])
    lanes = Panel("what was binding", start, end, -len(_BINDING) + 0.5, 0.5)
    half = (end - start) / max(len(times) - 1, 1) / 2
    for lane, word in enumerate(_BINDING):
        lanes.rule(-lane, word)
        bound = np.array([word in words.split("+") for words in binding])
        edges = np.flatnonzero(np.diff(np.concatenate([[0], bound, [0]]).astype(np.int8))).reshape(-1, 2)
        for first, stop in edges:
            low, high = max(times[first] - half, start), min(times[stop - 1] + half, end)
            lanes.bar(float(low), float(high), -lane, ink=INKS[lane])
    facts = {
        "output frames": len(times),
        "mean score": f"{scores.mean():.4g}" if len(scores) else "none",
        "references": ", ".join(reference_names[:4]) + ", …" * (len(reference_names) > 4),
    }
    return stacked(side_by_side(panel.svg(), lanes.svg()), facts_html(facts))

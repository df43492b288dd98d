"""A small picture of why a warp is as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retime.svg import INKS, Panel, facts_html, side_by_side, stacked, thinned

if TYPE_CHECKING:
    from retime.search.explain import Explanation

# What can be binding, from the top of the picture down.
_BINDING = ("key", "tangent", "lock", "hold", "fastest", "slowest")


def explanation_html(explanation: Explanation) -> str:
    """Return what each output frame scored, and what was binding where."""
    times = explanation.output_times
    start, end = float(times[0]), float(times[-1])
    # The ends have no score.
    scored = np.flatnonzero(np.isfinite(explanation.scores))
    scores = explanation.scores[scored]
    worst = float(scores.max()) if len(scores) else 0.0
    panel = Panel("score (low: like the reference)", start, end, 0.0, worst)
    panel.rule(0.0, "0")
    if worst > 0:
        panel.rule(worst, f"{worst:.3g}")
        kept = scored[thinned(len(scored))]
        panel.line(times[kept], explanation.scores[kept])
    lanes = Panel("what was binding", start, end, -len(_BINDING) + 0.5, 0.5)
    half = (end - start) / max(len(times) - 1, 1) / 2
    for lane, word in enumerate(_BINDING):
        lanes.rule(-lane, word)
        bound = np.array([word in words.split("+") for words in explanation.binding])
        edges = np.flatnonzero(np.diff(np.concatenate([[0], bound, [0]]).astype(np.int8))).reshape(-1, 2)
        for first, stop in edges:
            low, high = max(times[first] - half, start), min(times[stop - 1] + half, end)
            lanes.bar(float(low), float(high), -lane, ink=INKS[lane])
    facts = {
        "output frames": len(times),
        "mean score": f"{scores.mean():.4g}" if len(scores) else "none",
        "references": ", ".join(explanation.reference_names[:4]) + ", …" * (len(explanation.reference_names) > 4),
    }
    return stacked(side_by_side(panel.svg(), lanes.svg()), facts_html(facts))

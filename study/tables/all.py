"""All tables of a run."""

from __future__ import annotations

from study.run import Results
from study.sets.measure import SETS
from study.tables.answers import answer_times_table, answers_table
from study.tables.choices import choices_table, losses_table
from study.tables.figures import figures_table
from study.tables.propagation import propagation_table
from study.tables.sets import sets_table
from study.tables.signals import signals_table
from study.tables.sizes import sizes_table
from study.tables.table import Table


def tables(results: Results) -> dict[str, Table]:
    """Lay out every number that a reader is shown, by name."""
    found = {evaluation.key: figures_table(evaluation) for evaluation in results.evaluations}
    if results.evaluations:
        found["sizes"] = sizes_table(results.evaluations)
    for clips in SETS:
        if results.played:
            found[f"set-{clips}"] = sets_table(results.played, clips)
    if results.answered:
        found["answers"] = answers_table(results.answered)
        found["answer-times"] = answer_times_table(results.answered)
    if results.propagated:
        found["propagation"] = propagation_table(results.propagated)
    if results.sensitivity:
        found["sensitivity"] = choices_table(results.sensitivity)
        found["losses"] = losses_table(results.sensitivity)
    if results.camera is not None and results.curve is not None and results.ball is not None:
        found["signals"] = signals_table(results.camera, results.curve, results.ball)
    return found

"""The numbers that the text around the tables mentions."""

from __future__ import annotations

from collections.abc import Sequence

from study.choices.questions import Row, default_row, printed_row, row_of
from study.evaluations.evaluation import Evaluation
from study.text import number


def text_values(rows: Sequence[Row], evaluations: Sequence[Evaluation]) -> dict[str, str]:
    """Write the numbers that the text around the tables mentions, by name."""
    found: dict[str, str] = {}
    if rows:
        default = default_row(rows)
        for name, row in (("default", default), ("printed", printed_row(rows))):
            kept, frames = row.kept()
            found[f"kept-{name}"] = f"{kept:,} of {frames:,}"
            found[f"share-{name}"] = f"{kept / frames:.0%}".replace("%", " %")
        high, high_frames = default.kept_high()
        found["kept-high"] = f"{high} of {high_frames}"
        # A quick run compares the main settings alone.
        torso = row_of(rows, {**default.setting.options, "features": "torso"})
        if torso is not None:
            found["share-torso"] = f"{torso.kept()[0] / torso.kept()[1]:.0%}".replace("%", " %")
        for name, one in (("default", default), ("torso", torso)):
            if one is not None:
                found[f"jumps-{name}"] = number(one.mean("correlation", kind="jump"))
                found[f"limps-{name}"] = number(one.mean("correlation", kind="limp"))
        for weight in ("neutral", "sum"):
            found[f"length-{weight}"] = number(default.mean("length_ratio", length=weight), 0, " %")
            found[f"log-speed-{weight}"] = number(default.mean("log_speed_error", length=weight))
    for name, excesses in (
        ("excess", [one.row.excess for one in evaluations if one.row.excess is not None]),
        (
            "excess-keytimes",
            [one.row.excess_as_keytimes for one in evaluations if one.row.excess_as_keytimes is not None],
        ),
    ):
        if excesses:
            found[name] = f"{min(excesses) * 100:.1f} to {max(excesses) * 100:.1f} %"
    return found

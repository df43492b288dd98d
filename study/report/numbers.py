"""All numbers of a run as JSON."""

from __future__ import annotations

import json
from typing import Any

from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.report.plain import plain
from study.run import Results
from study.tables.all import tables
from study.tables.values import text_values


def numbers(results: Results) -> dict[str, Any]:
    """Collect all numbers for JSON; what is not finite is null."""
    return {
        "format": "retime-study",
        "version": 1,
        "machine": results.machine,
        "seconds": round(results.seconds, 1),
        "settings": plain(DEFAULTS),
        "evaluations": [_evaluation_numbers(one) for one in results.evaluations],
        "sets": plain(results.played),
        "answers": plain(results.answered),
        "propagation": plain(results.propagated),
        "sensitivity": plain(results.sensitivity),
        "camera": plain(results.camera),
        "curve": plain(results.curve),
        "ball": plain(results.ball),
        "values": text_values(results.sensitivity, results.evaluations),
        "tables": {name: plain(table) for name, table in tables(results).items()},
    }


def _evaluation_numbers(evaluation: Evaluation) -> dict[str, Any]:
    left_out = ("versions", "about")
    versions = [
        {"label": one.label, "note": one.note, "warp": plain(one.warp), "figures": plain(one.figures)}
        for one in evaluation.versions
    ]
    return {name: value for name, value in plain(evaluation).items() if name not in left_out} | {"versions": versions}


def json_text(document: dict[str, Any]) -> str:
    """Write one line for each part, and for each item of a list or table in it: compact, and fit to be compared."""

    def flat(value: Any) -> str:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)

    def part(value: Any) -> str:
        if isinstance(value, list) and value:
            return "[\n" + ",\n".join(flat(one) for one in value) + "\n]"
        if isinstance(value, dict) and value:
            return "{\n" + ",\n".join(f"{flat(name)}:{flat(one)}" for name, one in value.items()) + "\n}"
        return flat(value)

    return "{\n" + ",\n".join(f"{flat(name)}:{part(value)}" for name, value in document.items()) + "\n}\n"

"""The summary of a retimed motion says how far standing feet slide."""

from __future__ import annotations

import json
import re
from pathlib import Path

from click.testing import CliRunner

from retime.cli.main import main
from retime.data import SAMPLE


def test_slip_is_reported_before_and_after(tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["warp", str(SAMPLE), "--length", "65%", "-o", str(tmp_path / "out.bvh")])
    assert result.exit_code == 0, result.output
    found = re.search(
        r"slide ([\d.]+) mm a contact in the input, ([\d.]+) mm in the output \(([\d.]+) mm", result.output
    )
    assert found is not None
    before, after, averaged = (float(number) for number in found.groups())
    # The sample's feet stand still; exempted from averaging they go on doing so.
    assert before < 5
    assert after <= before + 1
    assert averaged >= after


def test_json_has_what_the_summary_says(tmp_path: Path) -> None:
    slips = {}
    for name, options in {"averaged": (), "straight": ("--no-average",)}.items():
        arguments = ["warp", str(SAMPLE), "--length", "50%", "-o", str(tmp_path / f"{name}.bvh"), "--json", *options]
        slips[name] = json.loads(CliRunner().invoke(main, arguments).stdout)["slip"]
    assert set(slips["averaged"]) == {"contacts", "input_mm", "output_mm", "averaged_mm"}
    assert slips["averaged"]["contacts"] > 10
    assert slips["averaged"]["output_mm"] <= slips["averaged"]["averaged_mm"]
    # Feet are exempt from averaging, so that it makes no difference to them.
    assert slips["straight"]["output_mm"] == slips["averaged"]["output_mm"]
    nothing_written = CliRunner().invoke(main, ["warp", str(SAMPLE), "--length", "50%", "--json"])
    assert json.loads(nothing_written.stdout)["slip"] is None

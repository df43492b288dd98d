"""The summary of a retimed motion says how far standing feet slide."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

from click.testing import CliRunner

from retime.cli.main import main
from retime.cli.summary import slip_facts, slip_text
from retime.data import SAMPLE, sample
from retime.motion.contacts import contacts
from retime.search.guided import guided_warp
from retime.warp.apply import apply_warp
from retime.warp.slip import retimed_slip


def test_slip_is_reported_before_and_after(tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["warp", str(SAMPLE), "--length", "65%", "-o", str(tmp_path / "out.bvh")])
    assert result.exit_code == 0, result.output
    found = re.search(
        r"slide about ([\d.]+) mm a contact in the input, about ([\d.]+) mm in the output \(([\d.]+) mm if they were "
        r"averaged too; the size of the figure is guessed\)",
        result.output,
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
    assert set(slips["averaged"]) == {"contacts", "input_mm", "output_mm", "averaged_mm", "size_guessed"}
    assert slips["averaged"]["size_guessed"] is True
    assert slips["averaged"]["contacts"] > 10
    assert slips["averaged"]["output_mm"] <= slips["averaged"]["averaged_mm"]
    # Feet are exempt from averaging, so that it makes no difference to them.
    assert slips["straight"]["output_mm"] == slips["averaged"]["output_mm"]
    nothing_written = CliRunner().invoke(main, ["warp", str(SAMPLE), "--length", "50%", "--json"])
    assert json.loads(nothing_written.stdout)["slip"] is None


def test_where_the_unit_is_known_millimetres_are_not_about_right() -> None:
    clip = sample().frames(0, 400)
    warp = guided_warp(clip, length="80%").warp
    known = replace(clip, metres_per_unit=0.01)
    facts = slip_facts(known, warp, apply_warp(known, warp), contacts(known))
    assert facts is not None
    assert facts["size_guessed"] is False
    assert "about" not in slip_text(facts)
    assert "guessed" not in slip_text(facts)
    for report, about in ((retimed_slip(clip, warp), True), (retimed_slip(known, warp), False)):
        for text in (repr(report), repr(report.input), repr(report.contact_aware), report._repr_html_()):
            assert ("about" in text) == about

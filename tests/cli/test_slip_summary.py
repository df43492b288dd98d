"""The summary of a retimed motion says how far standing feet slide."""

from __future__ import annotations

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

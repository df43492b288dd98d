"""`retime export` and `retime import`: curves for other programs, and from them."""

from __future__ import annotations

import json

import pytest

from retime import Warp, export_curve, read_warp, write_warp


@pytest.fixture
def warp(tmp_path):
    """Save a warp that plays, holds and runs backward."""
    write_warp(Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 2.0, 1.0]), tmp_path / "warp.json")
    return tmp_path / "warp.json"


def test_a_curve_is_written_and_its_error_said(run, tmp_path, warp) -> None:
    result = run(
        "export", "warp.json", "-o", "a.nk", "--host", "nuke", "--rate", "24", "--start", "1001", "--item", "Shot12"
    )
    assert result.stdout.splitlines() == [
        "wrote  a.nk",
        "keys   73",
        "error  under 0.000001 frames, under 0.000001 ms at most, read back from the file",
    ]
    text = (tmp_path / "a.nk").read_text()
    assert text.startswith("TimeWarp {\n lookup {{curve L x1001 1001 x1002 1003 ")
    assert " name Shot12\n" in text


def test_the_summary_as_json(run, warp) -> None:
    result = run(
        "export", "warp.json", "-o", "a.fcpxml", "--host", "fcpxml", "--rate", "29.97", "--tolerance", "0.01", "--json"
    )
    document = json.loads(result.stdout)
    assert document.pop("error_frames") == pytest.approx(0, abs=1e-5)
    assert document.pop("error_seconds") == pytest.approx(0, abs=1e-6)
    assert document == {"output": "a.fcpxml", "host": "fcpxml", "rate": "30000/1001", "keys": 4}


def test_a_curve_comes_back_as_a_warp(run, tmp_path, warp) -> None:
    run("export", "warp.json", "-o", "a.ma", "--host", "maya", "--rate", "30", "-q")
    result = run("import", "a.ma", "-o", "back.json")
    assert result.stdout.splitlines() == [
        "wrote   back.json",
        "knots   4",
        "output  0 to 3 s",
        "input   0 to 2 s",
        "speed   -1 to 2",
    ]
    back = read_warp(tmp_path / "back.json")
    assert back.input_times.tolist() == pytest.approx([0.0, 2.0, 2.0, 1.0])
    assert back.name == "a"


def test_the_summary_of_a_warp_that_came_back_as_json(run, tmp_path, warp) -> None:
    export_curve(read_warp(warp), tmp_path / "a.txt", "framecurve", rate=24)
    result = run("import", "a.txt", "--host", "framecurve", "--rate", "24", "--start", "1", "-o", "back.json", "--json")
    assert json.loads(result.stdout) == {
        "output": "back.json",
        "knots": 4,
        "output_times": [0.0, 3.0],
        "input_times": [0.0, 2.0],
        "slowest": -1.0,
        "fastest": 2.0,
    }


def test_a_rounded_curve_is_drawn_as_finely_as_is_asked_for(run, tmp_path) -> None:
    ease = {"o": {"x": [0.42], "y": [0]}, "i": {"x": [0.58], "y": [1]}}
    keys = [{"t": 0, "s": [0], **ease}, {"t": 48, "s": [4]}]
    (tmp_path / "a.json").write_text(json.dumps({"fr": 24, "layers": [{"tm": {"a": 1, "k": keys}}]}))
    counts = []
    for tolerance in ("0.1", "0.0001"):
        result = run("import", "a.json", "--tolerance", tolerance, "-o", "x.json", "--force", "--json")
        counts.append(json.loads(result.stdout)["knots"])
    assert 3 < counts[0] < 12 < counts[1]


def test_one_of_several_curves(run, tmp_path) -> None:
    (tmp_path / "two.nk").write_text(
        "".join(
            f"TimeWarp {{\n lookup {{{{curve L x1 1 x25 {last}}}}}\n name {name}\n}}\n"
            for name, last in (("A", 25), ("B", 49))
        )
    )
    assert "there are 2 curves, A, B" in run("import", "two.nk", "--rate", "24", "-o", "x.json", code=2).stderr
    run("import", "two.nk", "--rate", "24", "--item", "B", "-o", "x.json", "-q")
    assert read_warp(tmp_path / "x.json").input_times.tolist() == [0.0, 2.0]


def test_files_are_kept_unless_told(run, tmp_path, warp) -> None:
    (tmp_path / "a.csv").write_text("old")
    assert "--force" in run("export", "warp.json", "-o", "a.csv", "--host", "csv", code=1).stderr
    assert (tmp_path / "a.csv").read_text() == "old"
    run("export", "warp.json", "-o", "a.csv", "--host", "csv", "--force")
    assert "--force" in run("import", "a.csv", "-o", "warp.json", code=1).stderr
    run("import", "a.csv", "-o", "warp.json", "--force")
    assert "is the input" in run("import", "a.csv", "-o", "a.csv", "--force", code=2).stderr


def test_what_can_t_be_played_is_a_usage_error_and_leaves_nothing(run, tmp_path, warp) -> None:
    error = run("export", "warp.json", "-o", "a.txt", "--host", "ffmpeg", "--rate", "24", code=2).stderr
    assert "the warp holds from output time 1 to 2 s" in error
    assert not (tmp_path / "a.txt").exists()


def test_a_file_that_is_no_curve_is_named_with_its_line(run, tmp_path) -> None:
    (tmp_path / "a.csv").write_text("output_time,input_time\n0,0\n1,nan\n")
    assert "a.csv:3: expected a finite number, found 'nan'" in run("import", "a.csv", "-o", "x.json", code=1).stderr
    (tmp_path / "a.xyz").write_text("")
    assert "name the host (--host)" in run("import", "a.xyz", "-o", "x.json", code=1).stderr


def test_the_help_lists_the_hosts_without_loading_numpy(command) -> None:
    import subprocess
    import sys

    code = "import sys, retime.cli.export_curve, retime.cli.import_curve; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
    for name in ("unreal", "usd-clips", "framecurve"):
        assert name in command("export", "--help").stdout

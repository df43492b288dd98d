"""`retime batch`: what it says, what it leaves, and how it ends."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

import retime
from retime.cli import batch as batch_command
from tests.batch.storm import UNRULY
from tests.cli.conftest import Run

SERIAL = ("--workers", "0")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    root = tmp_path / "clips"
    for i, name in enumerate(("a.bvh", "deep/b.bvh")):
        place = root / name
        place.parent.mkdir(parents=True, exist_ok=True)
        retime.write(retime.sample().frames(60 * i, 60 * i + 40), place)
    (root / "broken.bvh").write_text("HIERARCHY\n")
    return root


def test_a_folder_is_retimed_and_what_failed_is_said(run: Run, library: Path, tmp_path: Path) -> None:
    result = run("batch", "clips", "--out", "out", "--length", "80%", *SERIAL, "--report", "report.html", code=4)
    assert "done    2 outputs" in result.output
    assert "failed  1 clips, 1 format" in result.output
    assert "broken.bvh: format: broken.bvh:" in result.output
    assert retime.read(tmp_path / "out" / "deep" / "b.bvh").n_frames == 32
    page = (tmp_path / "report.html").read_text()
    assert "<svg" in page
    assert "broken.bvh" in page
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    again = json.loads(run("batch", "clips", "--out", "out", "--length", "80%", *SERIAL, "--json", code=4).output)
    assert (again["done"], again["kept"], again["failures"]) == (0, 2, {"format": 1})
    lines = [json.loads(line) for line in (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()]
    assert [(line["name"], line["status"]) for line in lines] == [
        ("a.bvh", "kept"),
        ("broken.bvh", "failed"),
        ("deep/b.bvh", "kept"),
    ]


def test_exit_codes(run: Run, library: Path, tmp_path: Path) -> None:
    (library / "broken.bvh").unlink()
    run("batch", "clips", "--out", "out", *SERIAL, "-q", code=0)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "x.bvh").write_text("")
    run("batch", "bad", "--out", "out2", *SERIAL, code=5)
    (tmp_path / "empty").mkdir()
    assert "holds no clip" in run("batch", "empty", "--out", "out3", *SERIAL, code=2).output
    assert "holds no clip" in run("batch", "empty", "--out", "out3", "--dry-run", code=2).output
    assert "is not a folder" in run("batch", "nowhere", "--out", "out4", *SERIAL, code=2).output
    assert "lie in one another" in run("batch", "clips", "--out", "clips/out", *SERIAL, code=2).output
    # What is refused leaves nothing.
    assert not any((tmp_path / name).exists() for name in ("out3", "out4", "clips/out"))


def test_references_are_drawn_for_variants(run: Run, library: Path, tmp_path: Path) -> None:
    references = []
    for start in (0, 200):
        references += ["--reference", f"ref_{start}.bvh"]
        retime.write(retime.sample()[start : start + 60], tmp_path / f"ref_{start}.bvh")
    given = ("batch", "clips", "--out", "out", *references, "--draw-references")
    assert "drawn for variants" in run(*given, code=2).output
    run(*given, "--variants", "2", *SERIAL, "-q", code=4)
    lines = [json.loads(line) for line in (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()]
    made = [Path(line["reference"]).name for line in lines if line["status"] == "done"]
    assert sorted(made) == ["ref_0.bvh"] * (len(made) // 2) + ["ref_200.bvh"] * (len(made) // 2)
    assert made


def test_a_dry_run_writes_nothing(run: Run, library: Path, tmp_path: Path) -> None:
    result = run("batch", "clips", "--out", "out", "--variants", "2", "--speed", "0.8..1.25", "--dry-run")
    assert "outputs     6, about" in result.output
    assert "a_1.bvh, a_2.bvh" in result.output
    assert not (tmp_path / "out").exists()
    facts = json.loads(run("batch", "clips", "--out", "out", "--dry-run", "--json").output)
    assert facts["clips"] == 3
    assert facts["failed"] == 1
    assert 1000 < facts["bytes"] < 10_000_000
    assert facts["seconds"] > 0
    # What has been done by then is not counted again.
    run("batch", "clips", "--out", "out", "--length", "80%", *SERIAL, "-q", code=4)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}
    retime.write(retime.sample().frames(200, 240), library / "new.bvh")
    facts = json.loads(run("batch", "clips", "--out", "out", "--length", "80%", "--dry-run", "--json").output)
    assert (facts["clips"], facts["kept"], facts["failed_before"], facts["to_do"], facts["tried"]) == (4, 2, 1, 1, 1)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")} == before
    said = run("batch", "clips", "--out", "out", "--length", "80%", "--dry-run").output
    assert "2 clips that an earlier run has done" in said
    assert "1 clips in an earlier run, and not tried again" in said
    (tmp_path / "out" / "new.bvh").write_text("mine")
    said = run("batch", "clips", "--out", "out", "--length", "80%", "--dry-run").output
    assert "1 files that no run has written (--force)" in said
    facts = json.loads(run("batch", "clips", "--out", "out", "--length", "90%", "--dry-run", "--json").output)
    assert (facts["kept"], facts["to_do"]) == (0, 4)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_dry_run_outlives_the_clips_that_it_tries(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(UNRULY))
    (tmp_path / "deadly").mkdir()
    for name in ("kills.bvh", "hangs.bvh"):
        retime.write(retime.sample().frames(0, 40), tmp_path / "deadly" / name)
    given = ("batch", "deadly", "--out", "out", "--length", "80%", "--time-limit", "2", "--dry-run")
    said = run(*given).output
    assert "2 clips, of which 2 failed" in said
    assert "nobody knows how long" in said
    facts = json.loads(run(*given, "--json").output)
    assert (facts["seconds"], facts["bytes"], facts["failed"]) == (None, None, 2)


def test_every_setting_reaches_the_treatment(
    run: Run, library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    (tmp_path / "r.toml").write_text('[[rule]]\nmatch = "deep/*"\nlength = "90%"\n')

    def looked(tasks, sizes, bounds):
        seen.extend(task.treatment for task in tasks)
        return batch_trial.Estimate(0, 0, 3, (), 0.0, 0.0, 0, 0)

    from retime.batch import trial as batch_trial

    monkeypatch.setattr("retime.batch.trial.estimate", looked)
    given = {
        "--key": "0.2=0.3",
        "--lock": "0.1..0.2",
        "--keep": "0.3..0.4",
        "--method": "guided",
        "--reference": "ref.bvh",
        "--reference-frames": "0:20",
        "--frames": "0:30",
        "--drop-first": "1",
        "--fps": "60",
        "--skeleton": "s.asf",
        "--up": "y",
        "--root": "Hips",
        "--channel": "x=linear",
        "--gaps": "keep",
        "--array": "poses",
        "--animation": "walk",
        "--on": "2",
        "--format": ".bvh",
        "--beside": "{stem}.json",
        "--seed": "3",
        "--length": "80%",
        "--evenness": "2",
        "--recipe": "r.toml",
    }
    flags = ("--mirror", "--repair", "--decimal-comma", "--no-average")
    for name in ("ref.bvh", "s.asf"):
        (tmp_path / name).write_text("HIERARCHY")
    run("batch", "clips", "--out", "out", *(word for pair in given.items() for word in pair), *flags, "--dry-run")
    a, _, b = seen
    assert (a.search, b.search) == ({"length": "80%", "evenness": "2"}, {"length": "90%", "evenness": "2"})
    assert (a.key, a.lock, a.keep) == (("0.2=0.3",), ("0.1..0.2",), ("0.3..0.4",))
    assert a.reference == (str(tmp_path / "ref.bvh"),)
    assert a.skeleton == str(tmp_path / "s.asf")
    assert (a.reference_frames, a.frames, a.drop_first, a.fps, a.up, a.root) == ("0:20", "0:30", 1, "60", "y", "Hips")
    assert (a.channel, a.gaps, a.array, a.animation) == (("x=linear",), "keep", ("poses",), "walk")
    assert (a.on, a.format, a.beside, a.seed) == (2, ".bvh", ("{stem}.json",), 3)
    assert (a.mirror, a.repair, a.decimal_comma, a.average) == (True, True, True, False)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--length", "eighty"), "--length"),
        (("--lock", "1"), "lock: "),
        (("--variants", "2", "--length", "80%"), "variants have lengths"),
        (("--workers", "2", "--scheduler", "tcp://x:1"), "give one of them"),
        (("--memory", "lots"), "a size of memory such as 2GB"),
        (("--report", "r.pdf"), "a report is a page"),
        (("--report", "nowhere/r.html"), "is not there"),
        (("--reference", "none.bvh"), "none.bvh is not there"),
        (("--recipe", "none.toml"), "none.toml"),
        (("--time-limit", "0"), "--time-limit"),
        (("--chunk", "0"), "--chunk"),
    ],
)
def test_what_can_t_be_is_refused_before_anything_is_done(
    run: Run, library: Path, tmp_path: Path, given: tuple[str, ...], said: str
) -> None:
    code = 1 if said == "none.toml" else 2
    assert said in run("batch", "clips", "--out", "out", *given, code=code).output
    assert not (tmp_path / "out").exists()


def test_restart_retry_and_force(run: Run, library: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a.bvh").write_text("mine")
    given = ("batch", "clips", "--out", "out", "--length", "80%", *SERIAL, "--memory", "2GB", "--json")
    assert json.loads(run(*given, code=4).output)["failures"] == {"exists": 1, "format": 1}
    # What is in the way is no fault of the clip: it is tried again without being asked for.
    assert json.loads(run(*given, code=4).output)["failures"] == {"exists": 1, "format": 1}
    assert json.loads(run(*given, "--force", code=4).output)["done"] == 1
    assert json.loads(run(*given, "--resume", code=4).output)["kept"] == 2
    # The broken one stays broken; nothing but this tries it again.
    assert json.loads(run(*given, code=4).output)["failures"] == {"format": 1}
    planned = [json.loads(run(*given, "--dry-run", *more).output) for more in ((), ("--retry",))]
    assert [(one["failed_before"], one["to_do"]) for one in planned] == [(1, 0), (0, 1)]
    assert json.loads(run(*given, "--restart", code=4).output)["done"] == 2


@pytest.mark.parametrize(("text", "size"), [("2GB", 2 << 30), ("1.5 MiB", 3 << 19), ("512", 512), ("4k", 4096)])
def test_sizes(text: str, size: int) -> None:
    assert batch_command._size(text) == size


def test_a_report_replaces_none_but_its_like(run: Run, library: Path, tmp_path: Path) -> None:
    (library / "broken.bvh").unlink()
    given = ("batch", "clips", "--out", "out", "--length", "80%", *SERIAL, "--report", "out/page.html")
    run(*given)
    first = (tmp_path / "out" / "page.html").read_text()
    run(*given)
    assert (tmp_path / "out" / "page.html").read_text() != first
    (tmp_path / "out" / "page.html").write_text("mine")
    assert "exists already" in run(*given, code=1).output
    assert (tmp_path / "out" / "page.html").read_text() == "mine"
    run(*given, "--force")
    assert "To look at first" in (tmp_path / "out" / "page.html").read_text()

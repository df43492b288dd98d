"""An export is what the command line writes."""

from __future__ import annotations

import numpy as np
import pytest

from retime import Warp, read_warp
from tests.server.serving import KEY, serving

LOCK = {"id": "l", "start": 2.5, "end": 3.0, "slowest": 1.0, "fastest": 1.0}
KEPT = {"id": "m", "start": 0.2, "end": 0.5, "slowest": 0.0, "fastest": 1.0}
EXPORTS = {
    "a length": ({"options": {"length": "65%"}}, "--length 65%"),
    "keys and a tangent": (
        {
            "keys": [KEY, {"id": "j", "input_time": 3.0, "output_time": 2.75, "speed": 0.5}],
            "options": {"length": "200f"},
        },
        "--key 2=1.5 --key 3.0=2.75@0.5 --length 200f",
    ),
    "flights put right": (
        {
            "flights": [
                {"id": "f", "start": 0.2, "end": 0.5, "flies": True},
                {"id": "g", "start": 1.7, "end": 2.3, "flies": False},
            ],
            "options": {"length": "60%"},
        },
        "--flight 0.2..0.5 --no-flight 1.7..2.3 --length 60%",
    ),
    "in step": (
        {"references": [{"path": "leap.bvh"}], "method": "align", "repeat": 1.5, "options": {"smoothing": 3}},
        "--reference leap.bvh --method align --repeat 1.5 --smoothing 3",
    ),
    "locks and limits": (
        {"locks": [LOCK, KEPT], "options": {"length": "3s", "speed": "0.25..4", "smoothness": 0.5}},
        "--lock 2.5..3.0 --keep 0.2..0.5 --length 3s --speed 1/4..4 --smoothness 0.5",
    ),
    # Another motion's timing is met in small steps: a low rate keeps these quick.
    "a reference": (
        {
            "references": [{"path": "leap.bvh", "first_frame": 10, "last_frame": 200, "weight": 2.0, "mirror": True}],
            "options": {"rate": "12"},
        },
        "--reference leap.bvh --reference-frames 10:200 --reference-weight 2 --mirror --rate 12",
    ),
    "a stretch of itself": (
        {"references": [{"first_frame": 60}], "options": {"length": "80%", "rate": "12"}},
        "--reference-frames 60: --length 80% --rate 12",
    ),
    "a free length": (
        {"options": {"length": "free", "min_length": "100f", "max_length": "200f", "free_weight": "sum"}},
        "--length free --min-length 100f --max-length 200f --free-weight sum",
    ),
    "frames and a rate": (
        {
            "clips": [{"path": "jump.bvh", "first_frame": 5, "last_frame": 150, "fps": "30"}],
            "options": {"length": "3s"},
        },
        "--frames 5:150 --fps 30 --length 3s",
    ),
    "half guided, not averaged": (
        {"keys": [KEY], "average": False, "options": {"length": "75%", "influence": 0.5, "score": "conditional"}},
        "--key 2.0=1.5 --length 75% --influence 0.5 --no-average --score conditional",
    ),
    "all settings": (
        {
            "options": {
                "length": "75%",
                "rate": "20",
                "max_skip": 9,
                "upsample": 2,
                "n_neighbors": 2,
                "time_scale": 0.05,
                "low_pass": 3.0,
                "smoothing": 3,
                "features": "heading",
            },
        },
        "--length 75% --rate 20 --max-skip 9 --upsample 2 --neighbors 2 --time-scale 0.05 --low-pass 3 "
        "--smoothing 3 --features heading",
    ),
    "z up": ({"clips": [{"path": "jump.bvh", "up": "z"}], "options": {"length": "75%"}}, "--up z --length 75%"),
    "a loop": ({"options": {"length": "150f", "loop": True}}, "--length 150f --loop"),
    "a spline": ({"keys": [KEY], "method": "spline"}, "--key 2=1.5 --method spline"),
    "from coarse to fine": ({"options": {"length": "80%", "search": "heuristic"}}, "--length 80% --search heuristic"),
    "straight lines": ({"options": {"length": "65%"}, "method": "linear"}, "--length 65% --method linear"),
}


@pytest.fixture(scope="module")
def exporting(tmp_path_factory):
    from tests.server.serving import make_clips

    folder = make_clips(tmp_path_factory.mktemp("export") / "clips")
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        yield page, served, dict(page.document)


@pytest.mark.parametrize("kind", EXPORTS)
def test_an_export_is_what_the_command_line_writes(exporting, run, monkeypatch, kind) -> None:
    page, served, plain = exporting
    changes, arguments = EXPORTS[kind]
    monkeypatch.chdir(served.folder)
    page.edit(**{**plain, **changes})
    page.told()
    for what, name in (("motion", "page.bvh"), ("warp", "page.json")):
        page.say("export", what=what, path=name, clip=0, overwrite=True)
        assert page.until("exported", "refused")["type"] == "exported"
    run("warp", "jump.bvh", *arguments.split(), "-o", "line.bvh", "--save", "line.json", "--force", "-q")
    assert (served.folder / "page.json").read_bytes() == (served.folder / "line.json").read_bytes()
    assert (served.folder / "page.bvh").read_bytes() == (served.folder / "line.bvh").read_bytes()


# What the page says of a curve where a person said nothing.
CURVE = {"rate": "", "start": "", "tolerance": "", "item": "", "overwrite": False}


@pytest.mark.parametrize(
    ("curve", "arguments"),
    [
        (
            {"host": "nuke", "path": "page.nk", "rate": "24", "start": "1001", "item": "A"},
            "--rate 24 --start 1001 --item A",
        ),
        # Frames a second that nobody named are the clip's.
        ({"host": "maya", "path": "page.ma"}, "--rate 60"),
        ({"host": "ffmpeg", "path": "page.txt", "rate": "29.97"}, "--rate 30000/1001"),
        ({"host": "csv", "path": "page.csv", "tolerance": " 0.05 s"}, "--rate 60 --tolerance 0.05"),
    ],
)
def test_a_curve_is_what_the_command_line_writes(exporting, run, monkeypatch, curve, arguments) -> None:
    page, served, plain = exporting
    monkeypatch.chdir(served.folder)
    page.edit(**{**plain, "options": {"length": "80%"}})
    page.told()
    page.say("export", what="warp", path="page.json", clip=0, overwrite=True)
    assert page.until("exported", "refused")["error"] == ""
    page.say("export_curve", **{**CURVE, **curve})
    done = page.until("exported", "refused")
    assert (done["type"], done["what"]) == ("exported", "curve")
    assert done["error"].endswith("at most, read back from the file")
    suffix = curve["path"][4:]
    said = run("export", "page.json", "-o", f"line{suffix}", "--host", curve["host"], *arguments.split()).stdout
    assert done["error"] in said
    assert (served.folder / curve["path"]).read_bytes() == (served.folder / f"line{suffix}").read_bytes()


@pytest.mark.parametrize(
    ("curve", "says"),
    [
        ({"host": "nuke", "path": "x.nk", "start": "one"}, "expected the first frame's number"),
        ({"host": "nuke", "path": "x.nk", "rate": "fast"}, "expected a frame rate"),
        ({"host": "abacus", "path": "x.nk"}, "no host is called 'abacus'"),
        ({"host": "usd-clips", "path": "x.usda"}, "needs “For”"),
        ({"host": "csv", "path": "x.csv", "tolerance": "some"}, "the tolerance: expected a plain number"),
        ({"host": "csv", "path": "x.csv", "tolerance": "-1"}, "the tolerance: expected a plain number of at least 0"),
        ({"host": "nuke", "path": "x.nk", "tolerance": "0.1"}, "“Tolerance” would have no effect"),
        ({"host": "csv", "path": "jump.bvh", "overwrite": True}, "an input is never overwritten"),
    ],
)
def test_a_curve_that_can_t_be_written_is_refused(exporting, curve, says) -> None:
    page, served, _ = exporting
    page.say("export_curve", **{**CURVE, **curve})
    refused = page.until("exported", "refused")
    assert refused["type"] == "refused"
    assert says in refused["reason"]
    assert not list(served.folder.glob("x.*"))


def test_a_picture_and_the_clips_that_follow_are_what_the_command_line_writes(folder, run, monkeypatch) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(folder)
    with serving(folder, "jump.bvh", "leap.bvh") as served, served.ready_page() as page:
        files = [{**file, "role": "search"} for file in page.document["clips"]]
        page.edit(keys=[KEY], clips=files, options={"length": "80%", "rate": "15"})
        for what, name, clip in (("picture", "page.svg", 0), ("motion", "page.bvh", 1)):
            page.say("export", what=what, path=name, clip=clip, overwrite=False)
            assert page.until("exported", "refused")["type"] == "exported"
    also = ("--also", "leap.bvh=line.bvh", "--group", "--rate", "15")
    run("warp", "jump.bvh", "--length", "80%", "--key", "2=1.5", *also, "--plot", "line.svg", "-q")
    assert (folder / "page.svg").read_bytes() == (folder / "line.svg").read_bytes()
    assert (folder / "page.bvh").read_bytes() == (folder / "line.bvh").read_bytes()


def test_the_picture_of_an_example_that_is_carried_over_is_the_command_line_s(folder, run, monkeypatch) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(folder)
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(
            keys=[{**KEY, "input_time": 1.5, "output_time": 2.0}], method="linear", example={"start": 0, "end": 1.5}
        )
        for what, name in (("picture", "page.svg"), ("motion", "page.bvh")):
            page.say("export", what=what, path=name, clip=0, overwrite=False)
            assert page.until("exported", "refused")["type"] == "exported"
    Warp(np.array([0.0, 2.0]), np.array([0.0, 1.5])).save(folder / "hand.json")
    run("imitate", "jump.bvh", "--example", "0:90", "--warp", "hand.json", "-o", "line.bvh", "--plot", "line.svg", "-q")
    assert (folder / "page.svg").read_bytes() == (folder / "line.svg").read_bytes()
    assert (folder / "page.bvh").read_bytes() == (folder / "line.bvh").read_bytes()


@pytest.mark.parametrize(
    ("what", "path", "says"),
    [
        ("motion", "jump.bvh", "an input is never overwritten"),
        ("motion", "out.csv", "holds a signal, not a motion"),
        ("motion", "out.txt", "known endings"),
        ("motion", "leap.bvh", "exists already"),
        ("warp", "leap.bvh", "ends in .json"),
        ("warp", "out.py", "ends in .json"),
        ("picture", "out.gif", ".svg"),
        ("motion", "none/out.bvh", "No such file"),
    ],
)
def test_an_export_that_would_destroy_something_is_refused(served, what, path, says) -> None:
    before = {place.name: place.read_bytes() for place in served.folder.iterdir()}
    with served.ready_page() as page:
        page.say("export", what=what, path=path, clip=0, overwrite=path == "jump.bvh")
        refused = page.until("exported", "refused")
        assert refused["type"] == "refused"
        assert says in refused["reason"]
    assert {place.name: place.read_bytes() for place in served.folder.iterdir()} == before


def test_a_saved_warp_is_read_back(exporting) -> None:
    page, served, plain = exporting
    page.edit(**{**plain, "options": {"length": "70%"}})
    curve = page.curve()
    page.say("export", what="warp", path="again.json", clip=0, overwrite=True)
    page.until("exported")
    np.testing.assert_array_equal(read_warp(served.folder / "again.json").input_times, curve["input_times"])

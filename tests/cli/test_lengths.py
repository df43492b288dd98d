"""One meaning of a clip's length: what was asked for is what every part of retime calls it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import retime
from tests.cli.figures import curve, figure


@pytest.mark.parametrize(
    ("rate", "asked", "n_output"),
    [
        (Fraction(60), "3s", 180),
        (Fraction(60), "65%", 157),
        (Fraction(24), "100f", 100),
        (Fraction(30000, 1001), "5s", 150),
        (Fraction(120), "1.5s", 180),
    ],
)
def test_one_clip_has_one_length_everywhere(run, rate: Fraction, asked: str, n_output: int) -> None:
    clip = replace(figure(), rate=rate)
    retime.write(clip, "clip.bvh")
    given, wanted = (f"{float(n / rate):.2f} s" for n in (clip.n_frames, n_output))

    summary = run("warp", "clip.bvh", "--length", asked, "-o", "out.bvh", "--save", "w.json", "--plot", "w.svg").stdout
    assert f"{clip.n_frames} frames, {given} at " in summary
    assert f"{n_output} frames, {wanted} (" in summary
    assert f"{n_output} frames, {wanted}, from" in run("apply", "w.json", "clip.bvh", "-o", "again.bvh").stdout

    document = json.loads(run("warp", "clip.bvh", "--length", asked, "--json").stdout)
    assert document["input_seconds"] == pytest.approx(float(clip.n_frames / rate), abs=1e-12)
    assert document["output_seconds"] == pytest.approx(float(n_output / rate), abs=1e-12)

    for name, seconds, n_frames in (("clip.bvh", given, clip.n_frames), ("out.bvh", wanted, n_output)):
        row = re.search(r"^length +(\S+) s$", run("info", name).stdout, re.MULTILINE)
        assert row is not None
        assert f"{float(row[1]):.2f} s" == seconds
        exact = json.loads(run("info", name, "--json").stdout)["seconds"]
        assert exact == retime.read(name).duration == pytest.approx(float(n_frames / rate), abs=1e-12)

    warp = retime.read_warp("w.json")
    assert warp.count_frames(rate) == retime.read("out.bvh").n_frames == n_output
    assert warp.output_end == pytest.approx(retime.read("out.bvh").end_time, abs=1e-9)

    run("plot", "w.json", "--motion", "clip.bvh", "-o", "again.svg")
    for picture, label in (("w.svg", "guided"), ("again.svg", "w")):
        drawn = re.findall(r">([^<>]+)</text>", Path(picture).read_text(encoding="utf-8"))
        heading = next(text for text in drawn if re.match(r"input \d", text))
        assert f"input {given}, " in heading
        assert f"{label} {wanted}." in heading
        # A row says its whole length, or that it shows a part of so much.
        rows = [text for text in drawn if text in (wanted, f"of {wanted}")]
        assert rows
    asked_for = f" into {n_output}f ({n_output / float(clip.rate):.3f} s): "
    with pytest.raises(retime.InfeasibleWarpError, match=re.escape(asked_for)):
        retime.guided_warp(clip, length=asked, max_skip=1, upsample=1)


@pytest.mark.parametrize("rate", [24, 25, 60, 120])
@pytest.mark.parametrize("limits", [{"max_skip": 3, "upsample": 1}, {"max_skip": 5, "upsample": 2}])
@pytest.mark.parametrize("asked", ["12%", "900%"])
def test_a_length_that_an_error_offers_is_one_that_works(rate: int, limits: dict[str, int], asked: str) -> None:
    clip = replace(curve(), rate=Fraction(rate))
    with pytest.raises(retime.InfeasibleWarpError) as caught:
        retime.guided_warp(clip, length=asked, **limits)
    offer = re.search(r"Use a length of at (least|most) (\d+)f \(([\d.]+) s\)", str(caught.value))
    assert offer is not None
    assert float(offer[3]) == pytest.approx(int(offer[2]) / rate, abs=5e-4)
    for length in (f"{offer[2]}f", f"{offer[3]}s"):
        warp = retime.guided_warp(clip, length=length, **limits).warp
        assert warp.count_frames(rate) == int(offer[2])


def test_the_demo_counts_the_last_frame_too(run) -> None:
    said = run("demo", "--out", "demo").stdout
    found = re.findall(r"^(\D+?) +([\d.]+) +([\d.]+) +([\d.]+)$", said, re.MULTILINE)
    *phases, (still, *_), (whole, *lengths) = found
    assert (still, whole) == ("standing still, in all", "the whole clip")
    assert lengths == ["13.60", "8.83", "8.83"]
    for column, length in enumerate(lengths, start=1):
        # The phases make up the clip; each is rounded.
        assert sum(float(phase[column]) for phase in phases) == pytest.approx(float(length), abs=0.005 * len(found))

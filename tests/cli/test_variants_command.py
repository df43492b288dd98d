"""`retime warp --variants`: files of their own, the same again by the same seed."""

from __future__ import annotations

import json

import pytest

from retime import read, read_warp, variants, write


def test_each_variant_has_files_of_its_own(run, clips, tmp_path) -> None:
    options = ("--variants", "10", "--seed", "3", "-o", "take_{n}.csv", "--save", "{n}.json", "--json")
    lines = run("warp", clips.csv, *options).stdout.splitlines()
    documents = [json.loads(line) for line in lines]
    assert [one["variant"] for one in documents] == list(range(1, 11))
    expected = variants(read(clips.csv), 10, seed=3)
    for number, (document, take) in enumerate(zip(documents, expected, strict=True), start=1):
        assert document["output"] == f"take_{number:02d}.csv"
        assert read(tmp_path / f"take_{number:02d}.csv").n_frames == document["output_frames"] == take.apply().n_frames
        assert (read_warp(tmp_path / f"{number:02d}.json").input_times == take.warp.input_times).all()


def test_lengths_are_as_asked(run, clips) -> None:
    lines = run("warp", clips.csv, "--variants", "2", "--lengths", "50%..60%", "--json").stdout.splitlines()
    shares = sorted(one["output_frames"] / one["input_frames"] for one in map(json.loads, lines))
    assert 0.5 < shares[0] < 0.55 < shares[1] < 0.6


def test_each_imitates_a_reference_of_its_own(run, clips, tmp_path) -> None:
    clip = read(clips.csv)
    for name, stop in (("one.csv", 30), ("other.csv", 40)):
        write(clip.frames(0, stop), tmp_path / name)
    given = ("--variants", "4", "--reference", "one.csv", "--reference", "other.csv", "--draw-references", "--json")
    documents = [json.loads(line) for line in run("warp", clips.csv, *given).stdout.splitlines()]
    imitated = [(one["references"], one["n_reference"]) for one in documents]
    assert sorted(imitated) == [(["one.csv"], 30)] * 2 + [(["other.csv"], 40)] * 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--variants", "2", "-o", "take.csv"), "put {n} into take.csv, as in take_{n}.csv"),
        (("--variants", "0"), "--variants"),
        (("--variants", "2", "--key", "1=2", "--length", "50%"), "--key, --length can't be combined"),
        (("--variants", "2", "--method", "linear"), "not with --method linear"),
        (("--seed", "2"), "--seed is for --variants"),
        (("--lengths", "0.8..1"), "--lengths is for --variants"),
        (("--draw-references",), "--draw-references is for --variants"),
        (("--variants", "2", "--draw-references"), "--draw-references needs --reference"),
    ],
)
def test_what_variants_have_no_use_for_is_refused(run, clips, options, message) -> None:
    assert message in " ".join(run("warp", clips.csv, *options, code=2).stderr.split())


def test_no_file_is_replaced_unasked(run, clips, tmp_path) -> None:
    (tmp_path / "take_2.csv").write_text("mine", encoding="utf-8")
    assert "take_2.csv" in run("warp", clips.csv, "--variants", "2", "-o", "take_{n}.csv", code=1).stderr
    assert [place.name for place in tmp_path.iterdir()] == ["take_2.csv"]

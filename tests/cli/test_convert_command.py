"""`retime convert`: from one format to another, cut, and at another rate."""

from __future__ import annotations

import numpy as np
import pytest

from retime import joint_signal, read
from retime.cli import convert
from retime.motion.joint_signal import JOINT_SPACES
from retime.motion.kinematics import global_poses


def test_a_motion_keeps_its_poses(run, clips, tmp_path) -> None:
    result = run("convert", clips.bvh, "jump.amc")
    assert result.stdout == "jump.amc: 241 frames, 4.02 s at 60 Hz, with jump.asf\n"
    run("convert", "jump.amc", "back.bvh", "--fps", "60")
    before, after = (global_poses(read(path)) for path in (clips.bvh, tmp_path / "back.bvh"))
    # The ASF has bones of its own where a joint's children stand apart; the feet are the same.
    np.testing.assert_allclose(before.end_positions, after.end_positions, atol=1e-4)


def test_a_signal_keeps_its_numbers(run, clips, tmp_path) -> None:
    run("convert", clips.csv, "camera.npz", "-q")
    run("convert", "camera.npz", "camera.npy")
    np.testing.assert_array_equal(read(tmp_path / "camera.npz").values, read(clips.csv).values)


def test_cut_and_rate(run, clips, tmp_path) -> None:
    run("convert", clips.bvh, "cut.bvh", "--drop-first", "1", "--frames", "1:100", "--fps", "30")
    cut = read(tmp_path / "cut.bvh")
    assert (cut.n_frames, cut.rate) == (100, 30)
    np.testing.assert_allclose(cut.local_translations, read(clips.bvh).local_translations[1:101], atol=1e-6)


@pytest.mark.parametrize("target", ["x.csv", "x.npz"])
def test_a_motion_becomes_a_table(run, clips, tmp_path, target) -> None:
    motion = read(clips.bvh)
    for options, expected in (
        ((), joint_signal(motion)),
        (("--space", "torso"), joint_signal(motion, space="torso")),
        (("--rotations",), joint_signal(motion, rotations=True)),
        (("--rotations", "--space", "heading"), joint_signal(motion, rotations=True, space="heading")),
    ):
        said = run("convert", clips.bvh, target, *options, "--force").stdout
        assert said == f"{target}: 241 frames, 4.02 s at 60 Hz\n"
        table = read(tmp_path / target)
        assert (table.names, table.rate, table.kinds) == (expected.names, 60, expected.kinds)
        np.testing.assert_array_equal(table.values, expected.values)
    run("convert", clips.bvh, target, "--frames", "10:70", "--rate", "30", "--force")
    np.testing.assert_array_equal(read(tmp_path / target).values, joint_signal(motion).values[10:71:2])


def test_the_options_of_a_table_are_for_tables(run, clips) -> None:
    for options in (("--rotations",), ("--space", "torso")):
        says = run("convert", clips.bvh, "x.bvh", *options, code=2).stderr
        assert f"{options[0]} is for a motion that is written as a table, such as x.csv" in says
        assert options[0] in run("convert", clips.csv, "x.npz", *options, code=2).stderr
    assert "x.csv.gz" in run("convert", clips.bvh, "x.csv.gz", code=1).stderr
    assert convert._SPACES == JOINT_SPACES


def test_elsewhere_a_motion_is_no_signal(run, clips) -> None:
    says = run("warp", clips.bvh, "--length", "50%", "-o", "x.csv", code=1).stderr
    assert f"x.csv: a .csv file holds a signal, not a motion as {clips.bvh}" in says
    assert "a motion is written as .bvh or .amc or .glb" in says


def test_nor_is_a_signal_a_motion(run, clips) -> None:
    says = run("convert", clips.csv, "x.BVH", code=1).stderr
    assert f"x.BVH: a .bvh file holds a motion, not a signal as {clips.csv}" in says
    assert "a signal is written as .csv or .tsv or .npy" in says


def test_only_force_replaces(run, clips, tmp_path) -> None:
    (tmp_path / "old.bvh").write_text("old")
    assert "exists already" in run("convert", clips.bvh, "old.bvh", code=1).stderr
    assert (tmp_path / "old.bvh").read_text() == "old"
    run("convert", clips.bvh, "old.bvh", "--force")
    assert read(tmp_path / "old.bvh").n_frames == 241
    assert "is the input" in run("convert", "old.bvh", "old.bvh", "--force", code=2).stderr

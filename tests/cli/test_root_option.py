"""`--root`: nodes above the body in a file, and naming the joint that carries it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.project.document import ClipFile, Document
from retime.project.solve import DocumentSolver
from tests.motion.test_body import below_node


@pytest.fixture
def both(tmp_path: Path) -> tuple[Path, Path]:
    clip = retime.sample().frames(300, 440)
    retime.write(clip, tmp_path / "without.bvh")
    retime.write(below_node(clip, "joint_Root"), tmp_path / "with.bvh")
    return tmp_path / "with.bvh", tmp_path / "without.bvh"


def told(run, path: Path, *more: str) -> dict[str, object]:
    return dict(json.loads(run("info", path, "--json", *more).stdout))


def test_a_file_with_a_node_is_as_the_file_without(run, both: tuple[Path, Path], tmp_path: Path) -> None:
    one, other = (told(run, path) for path in both)
    assert one["root"] == other["root"] == "Hips"
    for fact in ("flights", "seems_z_up", "feet", "frames_before_capture"):
        assert one[fact] == other[fact]
    assert "Hips (it carries the body; 1 above or beside it)" in run("info", both[0]).stdout
    warps = []
    for more in (["--length", "65%"], ["--length", "100%", "--reference", both[1]]):
        for path in both:
            place = tmp_path / f"{len(warps)}.json"
            run("warp", path, *more, "--save", place)
            warps.append(retime.read_warp(place))
    for with_node, without in zip(warps[::2], warps[1::2], strict=True):
        np.testing.assert_array_equal(with_node.input_times, without.input_times)
        np.testing.assert_array_equal(with_node.output_times, without.output_times)


def test_a_person_names_the_joint(run, both: tuple[Path, Path]) -> None:
    assert told(run, both[0], "--root", "joint_Root")["root"] == "joint_Root"
    # As it was before the node was looked through: it lies on the ground, so nothing flies.
    assert told(run, both[0], "--root", "joint_Root")["flights"] == []
    wrong = run("info", both[0], "--root", "Hip", code=2)
    assert "is called 'Hip'; near to it: 'Hips'" in wrong.stderr


def test_a_reference_without_that_joint_has_its_own(run, both: tuple[Path, Path]) -> None:
    run("warp", both[0], "--root", "joint_Root", "--up", "y", "--reference", both[1], "--length", "90%", "-o", "o.bvh")


def test_a_document_names_the_joint(both: tuple[Path, Path]) -> None:
    found = DocumentSolver().read(Document((ClipFile(str(both[0])),))).clips[0]
    named = DocumentSolver().read(Document((ClipFile(str(both[0]), root="joint_Root", up="y"),))).clips[0]
    assert isinstance(found, retime.Motion)
    assert isinstance(named, retime.Motion)
    assert len(found.flights()) == 1
    assert named.flights() == []

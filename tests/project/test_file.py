"""The project file."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from retime.errors import FormatError
from retime.motion.grammar import parse_speeds
from retime.project.document import ClipFile, Document, ReferenceFile
from retime.project.file import project_bytes, read_project, save_project, warp_id
from tests.project.documents import WARP, document_of


def test_a_project_comes_back_as_it_was(tmp_path) -> None:
    document = document_of(tmp_path)
    place = tmp_path / "p.retime"
    save_project(place, project_bytes(document, {warp_id(WARP): WARP}, tmp_path), overwrite=False)
    project = read_project(place)
    assert project.document == document
    np.testing.assert_array_equal(project.warps[warp_id(WARP)].input_times, WARP.input_times)


def test_a_project_of_version_1_is_read(tmp_path) -> None:
    place = tmp_path / "old.retime"
    reference = {"path": "b.bvh", "first_frame": 3, "weight": 2.0, "mirror": False, "joint_map": "names.csv"}
    document = {"clips": [{"path": "a.bvh", "role": "search"}], "references": [reference]}
    place.write_text(json.dumps({"format": "retime-project", "version": 1, "document": document, "warps": {}}))
    (found,) = read_project(place).document.references
    assert found == ReferenceFile(
        str(tmp_path / "b.bvh"), first_frame=3, weight=2.0, joint_map=str(tmp_path / "names.csv")
    )


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, {}),
        # What every file of version 2 said, whether it was given or not.
        (
            {
                "length": None,
                "free_weight": "neutral",
                "influence": 1,
                "options": {"smoothness": 0.0, "score": "joint", "loop": False, "rate": None, "slowest": None},
            },
            {},
        ),
        (
            {"length": "free", "min_length": "50%", "max_length": "9s", "free_weight": "sum", "influence": 0.5},
            {"length": "free", "min_length": "50%", "max_length": "9s", "free_weight": "sum", "influence": 0.5},
        ),
        (
            {"options": {"smoothness": 2.5, "score": "conditional", "loop": True, "n_neighbors": 3, "smoothing": 5}},
            {"smoothness": 2.5, "score": "conditional", "loop": True, "n_neighbors": 3, "smoothing": 5.0},
        ),
        (
            {"options": {"rate": "29.97", "max_skip": 9, "features": "torso"}},
            {"rate": "29.97", "max_skip": 9, "features": "torso"},
        ),
        ({"options": {"slowest": 0.5, "fastest": 2.0}}, {"speed": "0.5..2"}),
        ({"options": {"slowest": 0.25}}, {"speed": "0.25.."}),
        ({"options": {"slowest": 0.0, "fastest": 20}}, {"speed": "0..20"}),
        ({"options": {"fastest": 1 / 3}}, {"speed": "..0.3333333333333333"}),
    ],
)
def test_the_options_of_version_2_are_read(tmp_path, given, expected) -> None:
    place = tmp_path / "old.retime"
    value = {"format": "retime-project", "version": 2, "document": {"clips": [{"path": "a.bvh"}], **given}}
    place.write_text(json.dumps(value))
    document = read_project(place).document
    assert document == Document((ClipFile(str(tmp_path / "a.bvh")),), options=expected)
    old = given.get("options", {})
    if "speed" in expected:
        slowest, fastest = parse_speeds(document.options["speed"])
        assert (slowest, fastest) == (old.get("slowest", 0.0), old.get("fastest", math.inf))


def test_method_and_averaging_of_version_2_are_the_documents_own(tmp_path) -> None:
    place = tmp_path / "old.retime"
    document = {"clips": [{"path": "a.bvh"}], "options": {"method": "linear", "average": False}}
    place.write_text(json.dumps({"format": "retime-project", "version": 2, "document": document}))
    found = read_project(place).document
    assert (found.method, found.average, found.options) == ("linear", False, {})


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"tempo": 1}, 'document: unknown field "tempo"'),
        ({"options": {"tempo": 1}}, 'document.options: unknown field "tempo"'),
        # Version 3 has these; a file of version 2 that has them is damaged.
        ({"method": "linear"}, 'document: unknown field "method"'),
        ({"options": {"length": "65%"}}, 'document.options: unknown field "length"'),
        ({"options": {"fastest": "2"}}, "document.options.fastest: expected a number"),
        ({"influence": True}, "document.influence: expected a number, found true"),
    ],
)
def test_what_version_2_did_not_know_is_refused_in_it(tmp_path, given, says) -> None:
    place = tmp_path / "old.retime"
    value = {"format": "retime-project", "version": 2, "document": {"clips": [{"path": "a.bvh"}], **given}}
    place.write_text(json.dumps(value))
    with pytest.raises(FormatError, match=re.escape(says)):
        read_project(place)


def test_files_in_the_projects_folder_move_with_it(tmp_path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    document = Document((ClipFile(str(here / "clips" / "a.bvh")),), references=(ReferenceFile("/elsewhere/b.bvh"),))
    (here / "p.retime").write_bytes(project_bytes(document, {}, here))
    here.rename(there)
    moved = read_project(there / "p.retime").document
    assert (moved.clips[0].path, moved.references[0].path) == (str(there / "clips" / "a.bvh"), "/elsewhere/b.bvh")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not JSON"),
        ("{}", "expected a project"),
        ('{"format": "retime-project", "version": 4}', r"version 4 is not one .*\(it reads 1, 2, 3\)"),
        ('{"format": "retime-project", "version": true}', "version True is not one"),
        ('{"format": "retime-project", "version": 1}', "document: expected an object"),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}]}, "x": 1}',
            "unknown field 'x'",
        ),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}], "kept": '
            '[{"id": "w", "name": "n"}]}}',
            "keeps a warp 'w'",
        ),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}]}, "warps": {"w": {}}}',
            "warps.w: expected a warp",
        ),
    ],
)
def test_what_is_no_project_is_refused_with_its_name(tmp_path, text, says) -> None:
    place = tmp_path / "p.retime"
    place.write_text(text)
    with pytest.raises(FormatError, match=says) as found:
        read_project(place)
    assert found.value.path == str(place)


def test_a_project_is_not_saved_under_another_files_name(tmp_path) -> None:
    place = tmp_path / "profile"
    with pytest.raises(FormatError, match=r"ends in \.retime"):
        save_project(place, b"{}", overwrite=True)
    assert not place.exists()

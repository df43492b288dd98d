"""The project file."""

from __future__ import annotations

import json

import numpy as np
import pytest

from retime.errors import FormatError
from retime.project.document import (
    ClipFile,
    Document,
    ReferenceFile,
)
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
        ('{"format": "retime-project", "version": 3}', r"version 3 is not one .*\(it reads 1, 2\)"),
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

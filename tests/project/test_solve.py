"""From a document to its warp: flights put right, in step with a reference, an example carried over."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from retime import RetimeWarning, Warp, align, guided_warp, imitate, linear_warp, read, write
from retime.project.document import (
    ClipFile,
    Document,
    Example,
    FlightMark,
    Key,
    LockedTime,
    Marker,
    ReferenceFile,
    WorkArea,
)
from retime.project.faults import FaultyError
from retime.project.solve import DocumentSolver
from tests.cli.figures import figure


@pytest.fixture
def document(tmp_path: Path) -> Document:
    """Give a document of a clip that jumps."""
    write(figure(), tmp_path / "jump.bvh")
    write(figure("leap", swing=0.9, seconds=3.0), tmp_path / "leap.bvh")
    return Document((ClipFile(str(tmp_path / "jump.bvh")),), options={"length": "60%"})


def clip_of(document: Document, name: str = "jump.bvh"):
    return read(Path(document.clips[0].path).with_name(name))


def test_a_flight_that_is_moved_denied_or_added_is_searched_with(document) -> None:
    solver, clip = DocumentSolver(), clip_of(document)
    rate = float(clip.rate)
    found = [(first / rate, last / rate) for first, last in clip.flights()]
    assert found
    start, end = found[0]
    plain = solver.solve(document)
    corrections = {
        (FlightMark("f", start, end, False),): found[1:],
        (FlightMark("f", start + 0.05, end),): [(start + 0.05, end), *found[1:]],
        (FlightMark("f", 0.2, 0.5),): [(0.2, 0.5), *found],
    }
    for marks, flights in corrections.items():
        solved = solver.solve(replace(document, flights=marks)).warp
        expected = guided_warp(clip, length="60%", flights=flights).warp
        np.testing.assert_array_equal(solved.input_times, expected.input_times)
        assert not np.array_equal(solved.input_times, plain.warp.input_times)
    # Taken back, all is as before.
    np.testing.assert_array_equal(solver.solve(document).warp.input_times, plain.warp.input_times)


def test_markers_and_the_work_area_change_nothing_and_nothing_is_searched_anew_for_them(document) -> None:
    solver = DocumentSolver()
    plain = solver.solve(document)
    marked = replace(document, markers=(Marker("m", 1.0, "beat"),), work_area=WorkArea(0.5, 1.0))
    solved = solver.solve(marked)
    assert solved.document is marked
    assert solved.search is plain.search
    np.testing.assert_array_equal(DocumentSolver().solve(marked).warp.input_times, plain.warp.input_times)
    # What says something of the warp is searched with, whatever is marked.
    keyed = solver.solve(replace(marked, keys=(Key("k", 1.0, 0.5),)))
    assert keyed.search is not plain.search
    assert keyed.warp(0.5) == pytest.approx(1.0)
    assert not np.array_equal(keyed.warp.input_times, plain.warp.input_times)
    back = solver.solve(document)
    np.testing.assert_array_equal(back.warp.input_times, plain.warp.input_times)


def test_a_document_that_can_not_be_solved_leaves_no_solution_behind(document) -> None:
    solver = DocumentSolver()
    plain = solver.solve(document)
    with pytest.raises(FaultyError):
        solver.solve(replace(document, options={"length": "soon"}))
    np.testing.assert_array_equal(solver.solve(document).warp.input_times, plain.warp.input_times)


def test_flights_of_a_group_are_those_of_all_that_is_searched(document) -> None:
    place = Path(document.clips[0].path)
    late = figure("late")
    write(late, place.with_name("late.bvh"))
    group = replace(document, clips=(document.clips[0], ClipFile(str(place.with_name("late.bvh")))))
    clips = [clip_of(document, name) for name in ("jump.bvh", "late.bvh")]
    mark = FlightMark("f", 0.2, 0.5)
    found = [(first / float(clip.rate), last / float(clip.rate)) for clip in clips for first, last in clip.flights()]
    solved = DocumentSolver().solve(replace(group, flights=(mark,)))
    expected = guided_warp(clips, length="60%", flights=[(0.2, 0.5), *found])
    np.testing.assert_array_equal(solved.warp.input_times, expected.warp.input_times)


@pytest.mark.parametrize("repeat", [1.0, 2.0])
@pytest.mark.filterwarnings("ignore:.*does not end as it begins")
def test_in_step_with_a_reference_what_says_nothing_waits(document, repeat) -> None:
    solver = DocumentSolver()
    reference = ReferenceFile(str(Path(document.clips[0].path).with_name("leap.bvh")))
    options = {"length": "60%", "evenness": 2.0, "score": "conditional", "smoothing": 3, "rate": "20"}
    asked = replace(document, references=(reference,), method="align", repeat=repeat, options=options)
    solution = solver.solve(asked)
    expected = align(clip_of(document), clip_of(document, "leap.bvh"), repeat=repeat, smoothing=3, rate="20")
    np.testing.assert_array_equal(solution.warp.input_times, expected.warp.input_times)
    # The other method finds its own options again.
    guided = solver.solve(replace(asked, method="guided"))
    assert guided.search is not None
    assert guided.search.plan.request.evenness == 2.0
    np.testing.assert_allclose(guided.warp.output_end, 0.6 * clip_of(document).duration - 1 / 60, atol=0.02)


def test_in_step_with_a_reference_keys_and_locks_hold(document) -> None:
    reference = ReferenceFile(str(Path(document.clips[0].path).with_name("leap.bvh")))
    solution = DocumentSolver().solve(
        replace(
            document,
            references=(reference,),
            method="align",
            keys=(Key("k", 2.0, 1.5),),
            locks=(LockedTime("l", 0.5, 0.8),),
        )
    )
    assert float(solution.warp(1.5)) == pytest.approx(2.0)
    (start, end) = np.interp([0.5, 0.8], solution.warp.input_times, solution.warp.output_times)
    assert end - start == pytest.approx(0.3, abs=0.02)


def solved_quietly(document: Document):
    with warnings.catch_warnings():
        # What is to be said of an example is in the result: nothing is said beside it.
        warnings.simplefilter("error", RetimeWarning)
        return DocumentSolver().solve(document)


def test_an_example_is_what_the_method_makes_of_its_stretch(document) -> None:
    keys = (Key("a", 1.0, 1.0), Key("b", 2.0, 2.8))
    asked = replace(document, options={}, method="linear", keys=keys, example=Example(1.0, 2.0))
    solution = solved_quietly(asked)
    clip = clip_of(document)
    first, last = round(1.0 * float(clip.rate)), round(2.0 * float(clip.rate))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        expected = imitate(clip, (first, last + 1), Warp([0.0, 1.8], [0.0, 1.0]))
    np.testing.assert_allclose(solution.warp.input_times, expected.warp.input_times, atol=1e-9)
    assert solution.search is not None
    assert solution.search.example is not None
    assert solution.search.example.share == expected.example.share
    # The example as it was made stands at its own times.
    assert solution.hand is not None
    np.testing.assert_allclose(solution.hand.output_times[[0, -1]], [1.0, 2.8])
    np.testing.assert_allclose(solution.hand.input_times[[0, -1]], [1.0, 2.0])
    base = linear_warp(DocumentSolver().solve(replace(asked, example=None)).warp.keytimes)
    np.testing.assert_allclose(solution.hand(np.array([1.5, 2.0])), base(np.array([1.5, 2.0])))


def test_beside_an_example_other_keys_locks_and_the_length_hold(document) -> None:
    asked = replace(
        document,
        method="spline",
        options={"length": "130%", "evenness": 3.0, "search": "heuristic"},
        # The clip's own beginning is a keytime too: the example begins there.
        keys=(Key("b", 1.0, 1.4), Key("c", 3.0, 4.0)),
        locks=(LockedTime("l", 1.5, 1.8),),
        example=Example(0.0, 1.0),
    )
    solution = DocumentSolver().solve(asked)
    clip = clip_of(document)
    assert solution.warp.count_frames(clip.rate) == round(1.3 * clip.n_frames)
    assert float(solution.warp(4.0)) == pytest.approx(3.0)
    (start, end) = np.interp([1.5, 1.8], solution.warp.input_times, solution.warp.output_times)
    assert end - start == pytest.approx(0.3, abs=0.02)


def test_an_example_whose_curve_leaves_it_is_refused(document) -> None:
    keys = (Key("a", 2.0, 1.0), Key("b", 0.5, 2.0), Key("c", 1.5, 3.0))
    asked = replace(document, options={}, method="linear", keys=keys, example=Example(0.8, 1.2))
    with pytest.raises(FaultyError, match=r"the curve shows input 0\.50 to 2\.00 s") as found:
        DocumentSolver().solve(asked)
    assert found.value.fault.field == "example"


@pytest.mark.parametrize(
    ("changes", "field", "says"),
    [
        ({"method": "align"}, "method", "nothing to keep step with"),
        ({"method": "align", "references": (ReferenceFile(), ReferenceFile())}, "method", "there are 2"),
        ({"method": "align", "references": (ReferenceFile(),), "repeat": 0.5}, "repeat", "at least 1, found 0.5"),
        ({"method": "align", "references": (ReferenceFile(),), "repeat": 1e12}, "repeat", "nothing is played"),
        ({"flights": (FlightMark("f", 3.0, 2.0),)}, "flights", "is no stretch of the clip"),
        ({"flights": (FlightMark("f", 3.0, 99.0, False),)}, "flights", "is no stretch of the clip"),
        ({"example": Example(2.0, 2.0)}, "example", "is no stretch of the clip"),
        ({"example": Example(2.0, 99.0)}, "example", "is no stretch of the clip"),
    ],
)
def test_what_can_not_be_is_told_at_its_field(document, changes, field, says) -> None:
    with pytest.raises(FaultyError, match=says) as found:
        DocumentSolver().solve(replace(document, **changes))
    assert found.value.fault.field == field

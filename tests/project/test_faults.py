"""What of a document is at fault, by what was changed since it could be solved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from retime import write
from retime.project.document import ClipFile, Document, Key, LockedTime
from retime.project.faults import Fault, fault_of
from retime.project.solve import DocumentSolver
from tests.cli.figures import figure


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    write(figure(), tmp_path / "jump.bvh")
    return tmp_path / "jump.bvh"


def test_of_the_two_ends_of_a_span_the_one_that_moved_is_at_fault(clip) -> None:
    keys = (Key("a", 1.0, 1.0), Key("b", 2.0, 2.0))
    good = Document((ClipFile(str(clip)),), keys=keys, options={"length": "100%"})
    solver = DocumentSolver()
    solver.solve(good)
    for moved, fault in (((Key("a", 1.0, 1.99), keys[1]), "a"), ((keys[0], Key("b", 2.0, 1.01)), "b")):
        bad = Document(good.clips, keys=moved, options={"length": "100%"})
        with pytest.raises(ValueError, match=r"closer|cannot fit") as found:
            solver.solve(bad)
        assert fault_of(found.value, bad, good).key == fault


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"locks": (LockedTime("l", 0.0, 1.0, 2.0, 2.0),)}, Fault(lock="l")),
        ({"options": {"length": "80%", "speed": "..1.5"}}, Fault(field="options.speed")),
        ({"options": {"length": "80%", "max_skip": 1, "upsample": 1}}, Fault(field="options.max_skip")),
        ({"options": {"length": "20f"}}, Fault(field="options.length")),
    ],
)
def test_what_was_changed_beside_the_keys_is_at_fault(clip, changes, fault) -> None:
    good = Document((ClipFile(str(clip)),), keys=(Key("a", 1.0, 0.6),), options={"length": "80%"})
    solver = DocumentSolver()
    solver.solve(good)
    bad = replace(good, **changes)
    with pytest.raises(ValueError, match=r"cannot fit|beyond the output") as found:
        solver.solve(bad)
    assert fault_of(found.value, bad, good) == fault
    # With nothing to compare with, the keytime that the span ends at is named.
    assert fault_of(found.value, bad, None).key == "a"

"""What can't be done is told with what is at fault."""

from __future__ import annotations

import pytest

from tests.server.serving import KEY


@pytest.mark.parametrize(
    ("changes", "says", "at"),
    [
        ({"keys": [{**KEY, "output_time": 0.001}]}, "closer than one frame", {"key": "k"}),
        (
            {"keys": [KEY, {**KEY, "id": "j", "input_time": 1.0}]},
            "two keytimes stand at output time 1.5 s",
            {"key": "j"},
        ),
        (
            {"keys": [{**KEY, "output_time": 9.0}], "options": {"length": "2s"}},
            "beyond the output's last frame",
            {"key": "k"},
        ),
        ({"keys": [{**KEY, "input_time": 60.0}]}, "asks for input time 60 s", {"key": "k"}),
        ({"keys": [{**KEY, "speed": -1.0}]}, "expected a playback speed", {"key": "k"}),
        ({"keys": [{**KEY, "speed": 6.0}], "options": {"max_skip": 4}}, "asks for speed 6", {"key": "k"}),
        ({"locks": [{"id": "l", "start": 3.0, "end": 2.0}]}, "a lock needs a span", {"lock": "l"}),
        ({"locks": [{"id": "l", "start": 3.0, "end": 9.0}]}, "leaves the clip", {"lock": "l"}),
        (
            {"locks": [{"id": "m", "start": 0.5, "end": 1.0}, {"id": "l", "start": 2.0, "end": 2.001}]},
            "one frame of the search, 33 ms, shows more",
            {"lock": "l"},
        ),
        ({"options": {"length": "1f"}}, "length", {"field": "options.length"}),
        ({"options": {"length": "soon"}}, "expected a length", {"field": "options.length"}),
        ({"options": {"length": "free", "min_length": "0"}}, "at least 2", {"field": "options.min_length"}),
        (
            {"options": {"length": "free", "min_length": "3s", "max_length": "2s"}},
            "is more than the most",
            {"field": "options.max_length"},
        ),
        ({"options": {"length": "90%", "max_length": "2s"}}, "need a free length", {"field": "options.length"}),
        ({"options": {"rate": "often"}}, "expected a frame rate", {"field": "options.rate"}),
        ({"options": {"max_skip": 300}}, "max_skip must be from 1", {"field": "options.max_skip"}),
        ({"options": {"time_scale": -1.0}}, "the time scale must be at least 0", {"field": "options.time_scale"}),
        ({"options": {"low_pass": -1.0}}, "the low pass must be at least 0", {"field": "options.low_pass"}),
        ({"options": {"n_neighbors": 0}}, "n_neighbors must be", {"field": "options.n_neighbors"}),
        ({"options": {"upsample": 0}}, "upsample must be", {"field": "options.upsample"}),
        ({"options": {"speed": "4..2"}}, "has the slowest first", {"field": "options.speed"}),
        ({"options": {"length": "80%", "loop": True, "search": "heuristic"}}, "loop", {"field": "options.search"}),
        (
            {"options": {"length": "free"}, "method": "linear"},
            "a free length needs a search",
            {"field": "options.length"},
        ),
        ({"clips": [{"path": "none.bvh"}]}, "none.bvh: No such file", {"clip": 0}),
        ({"clips": [{"path": "jump.bvh", "first_frame": 900}]}, "900", {"clip": 0}),
        ({"clips": [{"path": "jump.bvh"}, {"path": "camera.csv"}]}, "must last alike", {"clip": 1}),
        ({"references": [{}, {"path": "none.bvh"}]}, "none.bvh: No such file", {"reference": 1}),
        ({"references": [{}, {"weight": 0}]}, "the weight of a reference", {"reference": 1}),
        ({"references": [{"first_frame": 9, "last_frame": 11}]}, "give a longer reference", {"reference": 0}),
        ({"references": [{"path": "camera.csv"}]}, "must be of one kind", {"reference": 0}),
        (
            {"references": [{"path": "leap.bvh", "joints": [{"input": "Hips", "reference": "Tail"}]}]},
            "'Tail', which the reference has not",
            {"reference": 0},
        ),
    ],
)
def test_what_can_not_be_done_names_what_is_at_fault(served, changes, says, at) -> None:
    with served.ready_page() as page:
        page.edit(options={"length": "90%"})
        assert page.curve()["type"] == "curve"
        page.edit(**changes)
        problem = page.curve()
        assert problem["type"] == "problem"
        assert says in problem["message"]
        faults = {name: problem[name] for name in ("key", "lock", "clip", "reference", "field")}
        assert {name: fault for name, fault in faults.items() if fault is not None} == at
        # Who comes later is told too, with the last good curve.
        with served.page() as late:
            assert late.until("problem") == problem
            assert late.until("curve")["revision"] == page.revision - 1
        page.change("undo")
        assert page.curve()["type"] == "curve"

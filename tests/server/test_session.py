"""What a page is told: clips, curves, reasons, problems; undo, files, and recovery."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import signal
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from retime import Reference, guided_warp, read, read_warp, write
from retime.motion.kinematics import flights, global_poses
from retime.project import journal as journals
from retime.project.document import ClipFile, Document, Key, LockedTime, Options
from retime.project.solve import DocumentSolver, Fault, fault_of
from retime.server import messages
from retime.server.messages import BINDINGS
from retime.server.session import Outbox
from tests.cli.conftest import COMMAND
from tests.server.serving import Page, Served, serving

KEY = {"id": "k", "input_time": 2.0, "output_time": 1.5, "speed": None}


def test_a_page_is_told_the_clip_the_document_and_the_curve(served) -> None:
    with served.page() as page:
        why, clip, curve = page.until("why"), page.until("clip"), page.until("curve")
    # The curve is there before it is explained.
    assert page.heard.index("curve") < page.heard.index("why")
    motion = read(served.folder / "jump.bvh")
    poses = global_poses(motion)
    np.testing.assert_allclose(clip["positions"][:, :6], poses.positions, atol=1e-5)
    np.testing.assert_allclose(clip["positions"][:, 6:], poses.end_positions, atol=1e-5)
    assert (clip["n_frames"], clip["n_nodes"], len(clip["names"])) == (241, 9, 9)
    assert clip["parents"] == [-1, 0, 0, 2, 0, 4, 1, 3, 5]
    np.testing.assert_allclose(clip["flights"] * 60, flights(motion))
    result = guided_warp(motion)
    np.testing.assert_array_equal(curve["input_times"], result.warp.input_times)
    assert (curve["n_output"], curve["optimal"], curve["total"]) == (241, True, result.total)
    reasons = result.explain()
    np.testing.assert_array_equal(why["scores"], reasons.scores)
    np.testing.assert_array_equal(why["matched_times"], reasons.reference_times)
    words = ["+".join(word for bit, word in enumerate(BINDINGS) if bits >> bit & 1) for bits in why["binding"]]
    assert words == list(reasons.binding)


def test_a_signal_is_told_by_its_channels(folder) -> None:
    with serving(folder, "camera.csv") as served, served.page() as page:
        clip = page.until("clip")
    assert (clip["holds"], clip["names"], clip["parents"]) == ("signal", ["pan", "tilt"], [])
    np.testing.assert_array_equal(clip["values"], read(folder / "camera.csv").values)
    assert clip["positions"].size == 0


def test_a_drag_is_answered_by_curves_and_is_one_undo_step(served) -> None:
    with served.ready_page() as page:
        page.edit(label="set length", length="75%")
        assert page.told()["undo_label"] == "set length"
        for to in (1.2, 1.3, 1.4):
            page.edit("drag", done=False, label="move key", keys=[{**KEY, "output_time": to}])
            assert page.curve()["type"] == "curve"
        page.edit("drag", label="move key", keys=[{**KEY, "output_time": 1.5}])
        curve = page.curve()
        np.testing.assert_allclose(np.interp(1.5, curve["output_times"], curve["input_times"]), 2.0, atol=1e-9)
        np.testing.assert_allclose(curve["key_output_times"], [0, 1.5, 3.0])
        assert page.told()["undo_label"] == "move key"
        assert page.heard.count("state") == 2

        page.change("undo")
        state = page.told()
        assert (state["document"]["keys"], state["undo_label"], state["redo_label"]) == ([], "set length", "move key")
        page.change("redo")
        assert page.told()["document"]["keys"] == [{**KEY, "output_time": 1.5}]
        assert page.curve()["total"] == curve["total"]


def test_an_edit_of_an_unfinished_gesture_is_acknowledged_when_it_is_on_the_disk(served) -> None:
    with served.ready_page() as page:
        revision = page.edit("drag", done=False, keys=[KEY])
        assert page.until("ack", "state") == {"type": "ack", "revision": revision}
        (journal,) = (served.folder.parent / "state" / "journals").glob("*.journal")
        assert json.loads(journal.read_text().splitlines()[-1].partition(" ")[2])["document"]["keys"] == [KEY]


def test_two_pages_see_the_same_and_the_slower_one_is_told(served) -> None:
    with served.ready_page() as one, served.ready_page() as other:
        revision = one.edit(keys=[KEY])
        assert other.told(revision=revision)["document"]["keys"] == [KEY]
        assert other.curve()["type"] == "curve"
        # Both change revision 2 into 3; the first that comes wins.
        one.edit(length="80%")
        assert one.told()["document"]["length"] == "80%"
        other.edit(length="70%")
        assert "another window" in other.until("notice")["text"]
        assert other.told()["document"]["length"] == "80%"


@pytest.mark.parametrize(
    ("changes", "says", "at"),
    [
        ({"keys": [{**KEY, "output_time": 0.001}]}, "closer than one frame", {"key": "k"}),
        (
            {"keys": [KEY, {**KEY, "id": "j", "input_time": 1.0}]},
            "two keytimes stand at output time 1.5 s",
            {"key": "j"},
        ),
        ({"keys": [{**KEY, "output_time": 9.0}], "length": "2s"}, "beyond the output's last frame", {"key": "k"}),
        ({"keys": [{**KEY, "input_time": 60.0}]}, "asks for input time 60 s", {"key": "k"}),
        ({"keys": [{**KEY, "speed": -1.0}]}, "expected a playback speed", {"key": "k"}),
        ({"keys": [{**KEY, "speed": 6.0}], "options": {"max_skip": 4}}, "asks for speed 6", {"key": "k"}),
        ({"locks": [{"id": "l", "start": 3.0, "end": 2.0}]}, "a lock needs a span", {"lock": "l"}),
        ({"locks": [{"id": "l", "start": 3.0, "end": 9.0}]}, "leaves the clip", {"lock": "l"}),
        (
            {"locks": [{"id": "m", "start": 0.5, "end": 1.0}, {"id": "l", "start": 2.0, "end": 2.001}]},
            "shorter than one step",
            {"lock": "l"},
        ),
        ({"length": "1f"}, "length", {"field": "length"}),
        ({"length": "soon"}, "expected a length", {"field": "length"}),
        ({"length": "free", "min_length": "0"}, "expected a length", {"field": "min_length"}),
        ({"length": "free", "min_length": "3s", "max_length": "2s"}, "is more than the most", {"field": "max_length"}),
        ({"max_length": "2s"}, "need a free length", {"field": "length"}),
        ({"options": {"rate": "often"}}, "expected a frame rate", {"field": "options.rate"}),
        ({"options": {"max_skip": 300}}, "max_skip must be from 1", {"field": "options.max_skip"}),
        ({"options": {"time_scale": -1.0}}, "time scale must be from 0", {"field": "options.time_scale"}),
        ({"options": {"low_pass": -1.0}}, "low-pass cutoff", {"field": "options.low_pass"}),
        ({"options": {"n_neighbors": 0}}, "n_neighbors must be", {"field": "options.n_neighbors"}),
        ({"options": {"upsample": 0}}, "upsample must be", {"field": "options.upsample"}),
        ({"options": {"slowest": 4.0, "fastest": 2.0}}, "speed limits", {"field": "options.fastest"}),
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
        page.edit(length="90%")
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


def test_of_the_two_ends_of_a_span_the_one_that_moved_is_at_fault(folder) -> None:
    keys = (Key("a", 1.0, 1.0), Key("b", 2.0, 2.0))
    good = Document((ClipFile(str(folder / "jump.bvh")),), keys=keys, length="100%")
    solver = DocumentSolver()
    solver.solve(good)
    for moved, fault in (((Key("a", 1.0, 1.99), keys[1]), "a"), ((keys[0], Key("b", 2.0, 1.01)), "b")):
        bad = Document(good.clips, keys=moved, length="100%")
        with pytest.raises(ValueError, match=r"closer|cannot fit") as found:
            solver.solve(bad)
        assert fault_of(found.value, bad, good).key == fault


def test_what_is_no_message_is_told_and_changes_nothing(served) -> None:
    with served.ready_page() as page:
        for text in ("{", '{"type": "fly"}', '{"type": "edit", "revision": 2}'):
            page.socket.send(text)
            assert page.until("notice")["kind"] == "error"
            assert page.told()["revision"] == 1


def test_a_page_of_another_version_is_told_so(served) -> None:
    with served.socket() as socket:
        socket.send('{"type": "hello", "version": 0}')
        assert json.loads(socket.recv(timeout=30))["version"] == messages.VERSION
        with pytest.raises(ConnectionClosed, match="load it again"):
            socket.recv(timeout=30)


def test_a_warp_is_kept_and_compared_and_comes_back_with_undo(served) -> None:
    with served.ready_page() as page:
        page.edit(length="75%")
        curve = page.curve()
        page.change("keep", name="short")
        kept = page.until("kept")
        np.testing.assert_array_equal(kept["input_times"], curve["input_times"])
        (entry,) = page.told()["document"]["kept"]
        assert entry == {"id": kept["id"], "name": "short"}
        page.change("undo")
        assert page.told()["document"]["kept"] == []
        page.change("redo")
        assert page.told()["document"]["kept"] == [entry]
        page.edit(kept=[{"id": "nothing", "name": "no"}])
        assert "no kept warp 'nothing'" in page.until("notice")["text"]
        with served.page() as late:
            assert late.until("kept")["id"] == kept["id"]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"locks": (LockedTime("l", 0.0, 1.0, 2.0, 2.0),)}, Fault(lock="l")),
        ({"options": Options(fastest=1.5)}, Fault(field="options.fastest")),
        ({"options": Options(max_skip=1, upsample=1)}, Fault(field="options.max_skip")),
        ({"length": "20f"}, Fault(field="length")),
    ],
)
def test_what_was_changed_beside_the_keys_is_at_fault(folder, changes, fault) -> None:
    good = Document((ClipFile(str(folder / "jump.bvh")),), keys=(Key("a", 1.0, 0.6),), length="80%")
    solver = DocumentSolver()
    solver.solve(good)
    bad = replace(good, **changes)
    with pytest.raises(ValueError, match=r"cannot fit|beyond the output") as found:
        solver.solve(bad)
    assert fault_of(found.value, bad, good) == fault
    # With nothing to compare with, the keytime that the span ends at is named.
    assert fault_of(found.value, bad, None).key == "a"


def test_a_group_is_searched_together_and_others_follow(folder) -> None:
    with serving(folder, "jump.bvh", "leap.bvh", "camera.csv") as served, served.ready_page() as page:
        page.edit(length="75%")
        first = page.curve()
        jump, leap, camera = page.document["clips"]
        page.edit(clips=[jump, {**leap, "role": "search"}, camera])
        together = page.curve()
    clips = [read(folder / name) for name in ("jump.bvh", "leap.bvh")]
    np.testing.assert_array_equal(first["input_times"], guided_warp(clips[0], length="75%").warp.input_times)
    np.testing.assert_array_equal(together["input_times"], guided_warp(clips, length="75%").warp.input_times)


def test_a_group_imitates_a_group_and_a_stretch_of_itself(folder) -> None:
    jump, leap = (read(folder / name) for name in ("jump.bvh", "leap.bvh"))
    write(leap.frames(0, 200), folder / "a.bvh")
    write(jump.frames(0, 200), folder / "b.bvh")
    with serving(folder, "jump.bvh", "leap.bvh") as served, served.ready_page() as page:
        first, second = page.document["clips"]
        page.edit(clips=[first, {**second, "role": "search"}], length="75%", references=[{"path": "a.bvh"}])
        problem = page.curve()
        assert "needs a counterpart for each" in problem["message"]
        assert problem["reference"] == 0
        page.edit(references=[{"path": "a.bvh", "counterparts": [{"clip": 1, "path": "b.bvh"}], "last_frame": 150}])
        files = page.curve()
        page.edit(references=[{"first_frame": 60, "last_frame": 180}])
        itself = page.curve()
    cuts = [read(folder / name).frames(0, 151) for name in ("a.bvh", "b.bvh")]
    expected = guided_warp([jump, leap], reference=Reference(cuts), length="75%").warp
    np.testing.assert_array_equal(files["input_times"], expected.input_times)
    stretch = Reference([clip.frames(60, 181) for clip in (jump, leap)])
    expected = guided_warp([jump, leap], reference=stretch, length="75%").warp
    np.testing.assert_array_equal(itself["input_times"], expected.input_times)


def test_a_reference_says_which_joint_stands_for_which(folder) -> None:
    leap = read(folder / "leap.bvh")
    own = read(folder / "jump.bvh").skeleton.names
    names = tuple(f"Part{i}" for i in range(len(leap.skeleton.names)))
    other = replace(leap, skeleton=replace(leap.skeleton, names=names))
    write(other, folder / "strange.bvh")
    # The file is wrong about one, and the document has the last word.
    said = dict(zip(own, [names[0], *reversed(names[1:])], strict=True))
    (folder / "map.json").write_text(json.dumps(said))
    pairs = [{"input": name, "reference": to} for name, to in zip(own[1:], names[1:], strict=True)]
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(references=[{"path": "strange.bvh"}], length="80%")
        assert page.until("clip", what="reference")["counterparts"] == [""] * len(own)
        assert "too few of its joints" in page.curve()["message"]
        page.edit(references=[{"path": "strange.bvh", "joint_map": "map.json", "joints": pairs}])
        assert page.until("clip", what="reference")["counterparts"] == list(names)
        found = page.curve()
    reference = Reference(read(folder / "strange.bvh"), joint_map=dict(zip(own, names, strict=True)))
    expected = guided_warp(read(folder / "jump.bvh"), reference=reference, length="80%").warp
    np.testing.assert_array_equal(found["input_times"], expected.input_times)


def test_a_warning_is_told_once_and_to_who_comes_later(folder) -> None:
    steep = {**KEY, "speed": 30.0}
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[steep], options={"method": "spline"})
        assert "without turning back" in page.until("notice")["text"]
        page.edit(keys=[{**steep, "id": "j"}])
        page.curve()
        assert page.heard.count("notice") == 1
        with served.page() as late:
            assert late.until("notice")["kind"] == "warning"


def len_of(served: Served, name: str) -> int:
    return read(served.folder / name).n_frames


def test_another_clip_is_sent_where_the_document_names_it(served) -> None:
    with served.ready_page() as page:
        references = [{"path": "leap.bvh"}, {"first_frame": 60, "last_frame": 180}]
        page.edit(references=references, options={"rate": "12"})
        clips = [page.until("clip") for _ in range(2)]
        assert [(clip["what"], clip["index"], clip["count"]) for clip in clips] == [
            ("reference", 0, 2),
            ("reference", 1, 2),
        ]
        assert (clips[1]["start_time"], clips[1]["n_frames"], clips[1]["n_whole"]) == (
            1.0,
            121,
            len_of(served, "jump.bvh"),
        )
        page.curve()
        why = page.until("why")
        assert (why["sources"], why["mirrored"]) == ([0, 1], [False, False])
        # What is the same is not sent again; who comes later is told all of it, and nothing that is gone.
        page.edit(references=[references[0], {**references[1], "last_frame": 200}])
        page.curve()
        assert [message["index"] for message in page.mail if message["type"] == "clip"] == [1]
        page.edit(references=[])
        page.curve()
        with served.page() as late:
            late.until("curve")
            assert [message["what"] for message in late.mail if message["type"] == "clip"] == ["clip"]


def test_a_dropped_file_can_be_opened(served) -> None:
    data = (served.folder / "leap.bvh").read_bytes()
    answers = [
        served.ask(f"/drop?name={name}", method="POST", body=body, Origin=f"http://{served.host}")
        for name, body in (("my%20leap.bvh", data), ("my%20leap.bvh", data), ("my%20leap.bvh", data + b"\n"))
    ]
    places = [json.loads(answer.body)["path"] for answer in answers]
    assert [Path(place).name for place in places] == ["my leap.bvh", "my leap.bvh", "my leap-2.bvh"]
    assert Path(places[0]).read_bytes() == data
    with served.ready_page() as page:
        page.say("open", path=places[0])
        state = page.told(opened=1)
        assert page.until("clip")["name"] == "my leap"
        assert (state["undo_label"], state["path"]) == (None, None)
        page.edit(length="80%")
        assert page.curve()["type"] == "curve"


def test_a_folder_is_listed(served) -> None:
    (served.folder / "more").mkdir()
    (served.folder / ".hidden.bvh").touch()
    (served.folder / "notes.txt").touch()
    with served.ready_page() as page:
        page.say("browse", folder=None, holds="clip")
        listing = page.until("listing")
        assert (listing["folders"], listing["files"]) == (["more"], ["camera.csv", "jump.bvh", "leap.bvh"])
        assert listing["parent"] is None
        page.say("browse", folder=str(served.folder / "more"), holds="clip")
        assert page.until("listing")["parent"] == str(served.folder)
        (served.folder / "names.json").touch()
        (served.folder / "body.asf").touch()
        for holds, files in (("joint map", ["camera.csv", "names.json"]), ("skeleton", ["body.asf"])):
            page.say("browse", folder=None, holds=holds)
            assert page.until("listing")["files"] == files


def test_a_page_asks_whether_a_file_may_be_used(served, tmp_path) -> None:
    outside = tmp_path / "elsewhere" / "a b.bvh"
    outside.parent.mkdir()
    outside.touch()
    with served.ready_page() as page:

        def asked(path: object, *, writing: bool = False) -> tuple[str, str | None]:
            page.say("find", path=str(path), writing=writing)
            answer = page.until("found", path=str(path))
            # What is there is told of what may be used only.
            assert answer["exists"] == (answer["place"] != "" and Path(answer["place"]).exists())
            return answer["place"], answer["refused"]

        assert asked("leap.bvh", writing=True)[1] is None
        assert asked("leap.bvh") == (str(served.folder / "leap.bvh"), None)
        assert asked("new.bvh", writing=True) == (str(served.folder / "new.bvh"), None)
        for path, says in (("new.bvh", "there is no such file"), (served.folder, "a folder, not a file")):
            place, refused = asked(path)
            assert (place, says in str(refused)) == ("", True)
        assert "name too long" in str(asked(400 * "a" + ".bvh")[1])
        place, refused = asked(outside)
        assert place == ""
        assert str(refused).endswith(f"type: retime edit jump.bvh --folder {outside.parent}")


def saved(page: Page, path: str | None) -> dict:
    page.say("save", path=path, overwrite=False)
    return page.until("saved", "notice")


def test_a_project_is_saved_and_opened(folder) -> None:
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY])
        assert (page.told()["path"], saved(page, None)["text"]) == (
            None,
            "the project has no name yet: say where to save it",
        )
        assert "ends in .retime" in saved(page, "p.txt")["text"]
        assert "is an input" in saved(page, "jump.bvh")["text"]
        assert saved(page, "p.retime")["type"] == "saved"
        assert page.told(saved=True)["path"] == str(folder / "p.retime")
        page.edit(length="80%")
        assert not page.told()["saved"]
        assert saved(page, None)["type"] == "saved"
        assert page.told(saved=True)["revision"] == page.revision
        page.say("open", path="leap.bvh")
        assert page.told(opened=1)["document"]["clips"][0]["path"].endswith("leap.bvh")
        page.say("open", path="p.retime")
        state = page.told(opened=2)
        assert (state["document"]["keys"], state["document"]["length"], state["saved"]) == ([KEY], "80%", True)
        page.say("open", path="none.retime")
        assert "not opened" in page.until("notice")["text"]
    assert {path.name for path in folder.iterdir()} == {"jump.bvh", "leap.bvh", "camera.csv", "p.retime"}


def test_a_clean_end_keeps_what_was_not_saved(folder) -> None:
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY], label="add key")
        page.told()
    with serving(folder, "jump.bvh") as served, served.page() as page:
        state = page.until("state")
        assert (state["recovered"], state["undo_label"], state["document"]["keys"]) == (True, "add key", [KEY])


def test_kill_9_of_the_editor_loses_nothing_that_was_acknowledged(folder, tmp_path) -> None:
    environment = {**os.environ, "RETIME_STATE": str(tmp_path / "state")}
    process = subprocess.Popen(
        [*COMMAND, "edit", str(folder / "jump.bvh"), "--no-browser"], stdout=subprocess.PIPE, text=True, env=environment
    )
    assert process.stdout is not None
    try:
        address = process.stdout.readline().split()[-1]
        host, token = re.fullmatch(r"http://([\d.:]+)/\?token=(.+)", address).groups()
        with _page_at(host, token) as page:
            page.told(revision=1)
            page.edit(length="75%", label="set length")
            page.told()
            for number in range(5):
                page.edit("drag", done=False, label="move key", keys=[{**KEY, "output_time": 1.2 + 0.01 * number}])
            page.until("ack", revision=page.revision)
            process.send_signal(signal.SIGKILL)
    finally:
        process.kill()
        process.communicate()
    with serving(folder, "jump.bvh") as served, served.page() as page:
        state = page.told(revision=1)
        assert (state["recovered"], state["undo_label"]) == (True, "move key")
        assert state["document"]["keys"][0]["output_time"] == 1.24
        page.change("undo")
        state = page.told()
        assert (state["document"]["keys"], state["document"]["length"]) == ([], "75%")


@contextlib.contextmanager
def _page_at(host: str, token: str):
    class Guard:
        hosts = (host,)

    class Server:
        guard = Guard

    Guard.token = token
    with contextlib.suppress(OSError), Served(Server, Path()).page() as page:
        yield page


def test_a_full_disk_is_told_and_the_next_edit_makes_it_good(served, monkeypatch) -> None:
    write_all = journals._write_all

    def full(file, data) -> None:
        write_all(file, data[:100])
        raise OSError(28, "No space left on device")

    with served.ready_page() as page:
        monkeypatch.setattr(journals, "_write_all", full)
        page.edit(keys=[KEY], label="add key")
        assert "not safe: No space left on device" in page.until("notice")["text"]
        assert "state" not in page.heard
        monkeypatch.setattr(journals, "_write_all", write_all)
        page.edit(length="80%", label="set length")
        state = page.told()
        assert (state["document"]["keys"], state["document"]["length"]) == ([KEY], "80%")
        page.change("undo")
        assert page.told()["undo_label"] == "add key"


def test_a_slow_page_is_sent_the_latest_curve_and_every_state() -> None:
    def ack(revision: int) -> messages.Ack:
        return messages.Ack(revision)

    async def check() -> list[str]:
        box = Outbox()
        for revision in (1, 2, 3):
            box.put(ack(revision))
        box.put(messages.Notice("info", "a"))
        box.put(ack(4))
        box.put(messages.Notice("info", "b"))
        return [str(await box.get()) for _ in range(3)]

    told = [json.loads(text) for text in asyncio.run(check())]
    assert [(message["type"], message.get("revision", message.get("text"))) for message in told] == [
        ("notice", "a"),
        ("ack", 4),
        ("notice", "b"),
    ]


# An export is what the command line writes.

LOCK = {"id": "l", "start": 2.5, "end": 3.0, "slowest": 1.0, "fastest": 1.0}
KEPT = {"id": "m", "start": 0.2, "end": 0.5, "slowest": 0.0, "fastest": 1.0}
EXPORTS = {
    "a length": ({"length": "65%"}, "--length 65%"),
    "keys and a tangent": (
        {"keys": [KEY, {"id": "j", "input_time": 3.0, "output_time": 2.75, "speed": 0.5}], "length": "200f"},
        "--key 2=1.5 --key 3.0=2.75@0.5 --length 200f",
    ),
    "locks and limits": (
        {"locks": [LOCK, KEPT], "length": "3s", "options": {"slowest": 0.25, "fastest": 4.0, "smoothness": 0.5}},
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
        {"references": [{"first_frame": 60}], "length": "80%", "options": {"rate": "12"}},
        "--reference-frames 60: --length 80% --rate 12",
    ),
    "a free length": (
        {"length": "free", "min_length": "100f", "max_length": "200f", "free_weight": "sum"},
        "--length free --min-length 100f --max-length 200f --free-weight sum",
    ),
    "frames and a rate": (
        {"clips": [{"path": "jump.bvh", "first_frame": 5, "last_frame": 150, "fps": "30"}], "length": "3s"},
        "--frames 5:150 --fps 30 --length 3s",
    ),
    "half guided, not averaged": (
        {"keys": [KEY], "length": "75%", "influence": 0.5, "options": {"average": False, "score": "conditional"}},
        "--key 2.0=1.5 --length 75% --influence 0.5 --no-average --score conditional",
    ),
    "all settings": (
        {
            "length": "75%",
            "options": {
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
    "z up": ({"clips": [{"path": "jump.bvh", "up": "z"}], "length": "75%"}, "--up z --length 75%"),
    "a loop": ({"length": "150f", "options": {"loop": True}}, "--length 150f --loop"),
    "a spline": ({"keys": [KEY], "options": {"method": "spline"}}, "--key 2=1.5 --method spline"),
    "straight lines": ({"length": "65%", "options": {"method": "linear"}}, "--length 65% --method linear"),
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
        assert page.until("exported", "notice")["type"] == "exported"
    run("warp", "jump.bvh", *arguments.split(), "-o", "line.bvh", "--save", "line.json", "--force", "-q")
    assert (served.folder / "page.json").read_bytes() == (served.folder / "line.json").read_bytes()
    assert (served.folder / "page.bvh").read_bytes() == (served.folder / "line.bvh").read_bytes()


def test_a_picture_and_the_clips_that_follow_are_what_the_command_line_writes(folder, run, monkeypatch) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(folder)
    with serving(folder, "jump.bvh", "leap.bvh") as served, served.ready_page() as page:
        files = [{**file, "role": "search"} for file in page.document["clips"]]
        page.edit(length="80%", keys=[KEY], clips=files, options={"rate": "15"})
        for what, name, clip in (("picture", "page.svg", 0), ("motion", "page.bvh", 1)):
            page.say("export", what=what, path=name, clip=clip, overwrite=False)
            assert page.until("exported", "notice")["type"] == "exported"
    also = ("--also", "leap.bvh=line.bvh", "--group", "--rate", "15")
    run("warp", "jump.bvh", "--length", "80%", "--key", "2=1.5", *also, "--plot", "line.svg", "-q")
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
        notice = page.until("exported", "notice")
        assert notice["type"] == "notice"
        assert says in notice["text"]
    assert {place.name: place.read_bytes() for place in served.folder.iterdir()} == before


def test_a_saved_warp_is_read_back(exporting) -> None:
    page, served, plain = exporting
    page.edit(**{**plain, "length": "70%"})
    curve = page.curve()
    page.say("export", what="warp", path="again.json", clip=0, overwrite=True)
    page.until("exported")
    np.testing.assert_array_equal(read_warp(served.folder / "again.json").input_times, curve["input_times"])

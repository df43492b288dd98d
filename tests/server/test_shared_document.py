"""What a page is told of the document, and how it changes it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from retime import guided_warp, read
from retime.motion.flights import flights
from retime.motion.kinematics import global_poses
from retime.server import messages
from retime.server.messages import BINDINGS
from tests.server.serving import KEY, serving


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
        page.edit(label="set length", options={"length": "75%"})
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
        one.edit(options={"length": "80%"})
        assert one.told()["document"]["options"]["length"] == "80%"
        late = other.edit(options={"length": "70%"})
        # It is told at once that another page was faster, before anything else of that revision, and what holds.
        assert other.until("elsewhere", "state", "ack", revision=late)["type"] == "elsewhere"
        assert other.told()["document"]["options"]["length"] == "80%"
        # Who was faster is told of nothing.
        assert "elsewhere" not in one.heard
        # Its next change builds on that.
        other.edit(options={"length": "60%"})
        assert other.told()["document"]["options"]["length"] == "60%"
        assert one.until("elsewhere", revision=other.revision)


def test_a_file_that_cannot_be_read_is_refused_and_the_document_stays(served, folder) -> None:
    (folder / "broken.bvh").write_text("HIERARCHY\nROOT hips\n{\n")
    with served.ready_page() as page:
        page.edit(keys=[KEY])
        before = page.told()
        page.curve()
        page.say("open", path="broken.bvh")
        refused = page.until("refused", what="open", path="broken.bvh")
        assert "broken.bvh" in refused["reason"]
        page.say("open", path="none.bvh")
        assert page.until("refused", path="none.bvh")
        # Nothing was opened in its place, and editing goes on.
        page.edit(options={"length": "80%"})
        state = page.told()
        assert (state["opened"], state["document"]["keys"]) == (before["opened"], [KEY])
        assert page.curve()["type"] == "curve"


def test_no_search_is_stopped_before_it_was_asked_for(served) -> None:
    with served.ready_page() as page:
        page.say("stop", revision=10**9)
        page.edit(options={"length": "80%"})
        assert page.curve()["type"] == "curve"


def test_one_begins_anew_in_the_page(served) -> None:
    with served.ready_page() as page:
        page.edit(keys=[KEY])
        page.told()
        page.say("anew")
        state = page.told(opened=1)
        assert (state["document"]["keys"], state["undo_label"], state["path"]) == ([], None, None)
        assert "is kept as" in page.until("notice")["text"]
        page.curve()
        page.edit(keys=[KEY])
        assert page.told()["undo_label"] == "edit"


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
        page.edit(options={"length": "75%"})
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

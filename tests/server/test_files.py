"""Files that a page sees: listed, asked for, dropped."""

from __future__ import annotations

import gzip
import json
from pathlib import Path


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
        page.edit(options={"length": "80%"})
        assert page.curve()["type"] == "curve"


def test_a_dropped_project_is_opened_where_it_lies(served) -> None:
    with served.ready_page() as page:
        page.edit(keys=[{"id": "k", "input_time": 2.0, "output_time": 1.5, "speed": None}])
        page.told()
        (served.folder / "shots").mkdir()
        page.say("save", path="shots/limp.retime", overwrite=False)
        page.until("saved")
        place = served.folder / "shots" / "limp.retime"

        def drop(body: bytes):
            return served.ask("/drop?name=limp.retime", method="POST", body=body, Origin=f"http://{served.host}")

        page.say("open", path="leap.bvh")
        page.told(opened=1)
        answer = drop(place.read_bytes())
        assert json.loads(answer.body) == {"path": str(place)}
        page.say("open", path=str(place))
        state = page.told(opened=2)
        assert (state["path"], [key["id"] for key in state["document"]["keys"]]) == (str(place), ["k"])
        # One that lies elsewhere names files that nobody finds.
        answer = drop(place.read_bytes() + b" ")
        assert answer.status == 415
        assert "retime edit --project" in answer.body.decode()
        assert [file.name for file in served.folder.rglob("*.retime")] == ["limp.retime"]


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


def test_a_file_that_is_to_be_a_clip_is_read_before_it_may_be_one(served) -> None:
    (served.folder / "broken.bvh").write_text("HIERARCHY\nROOT hips\n{\n")
    (served.folder / "gaps.csv").write_text("time,x\n0,1\n0.1,\n0.2,4\n0.3,7\n")
    with served.ready_page() as page:

        def asked(path: str) -> str | None:
            page.say("find", path=path, writing=False, as_clip=True)
            answer = page.until("found", path=path)
            assert (answer["place"] == "") == (answer["refused"] is not None)
            return answer["refused"]

        assert asked("leap.bvh") is None
        # How its gaps are filled is said once it is there.
        assert asked("gaps.csv") is None
        assert asked("camera.csv") is None
        assert "there is no such file" in str(asked("new.bvh"))
        assert "broken.bvh:3" in str(asked("broken.bvh"))
        page.say("find", path="broken.bvh", writing=False)
        assert page.until("found", path="broken.bvh")["refused"] is None
        # In the place of all that is open it would leave nothing to see.
        page.say("open", path="gaps.csv")
        reason = page.until("refused")["reason"]
        assert "gaps.csv" in reason
        assert "“Gaps” under How it is read can bridge them" in reason
        assert reason.endswith(". That can be said of a clip which is added under Clips")
        page.say("open", path="broken.bvh")
        assert "Clips" not in page.until("refused")["reason"]
        # The document is as it was, and an edit of it is solved.
        page.edit(options={"length": "80%"})
        assert page.curve()["type"] == "curve"


def test_a_compressed_clip_can_be_dropped_and_opened(served) -> None:
    data = (served.folder / "leap.bvh").read_bytes()
    places = []
    for packed in (gzip.compress(data, mtime=0), gzip.compress(data + b"\n", mtime=0)):
        answer = served.ask("/drop?name=leap.bvh.gz", method="POST", body=packed, Origin=f"http://{served.host}")
        places.append(Path(json.loads(answer.body)["path"]))
    assert [place.name for place in places] == ["leap.bvh.gz", "leap-2.bvh.gz"]
    with served.ready_page() as page:
        page.say("open", path=str(places[0]))
        page.told(opened=1)
        assert page.until("clip")["name"] == "leap"

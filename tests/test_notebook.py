"""The editor as a widget: the page's messages, over the widget's channel."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from retime import ChannelKind, Signal, Warp, guided_warp, read, write
from retime.errors import FormatWarning, MissingPageError, OptionError, RetimeError
from retime.server.messages import VERSION
from tests.cli.figures import figure

pytest.importorskip("anywidget", reason="needs the extra notebook: anywidget is not installed")

from retime import notebook
from tests.server.frames import read as read_frame


@pytest.fixture
def clip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    page = tmp_path / "page"
    page.mkdir()
    (page / "widget.js").write_text("export default {};")
    (page / "widget.css").write_text(".retime {}")
    monkeypatch.setattr(notebook, "PAGE", page)
    monkeypatch.setenv("RETIME_STATE", str(tmp_path / "state"))
    write(figure(), tmp_path / "jump.bvh")
    return tmp_path / "jump.bvh"


class Cell:
    """What a widget's page hears."""

    def __init__(self, widget: notebook.EditorWidget, monkeypatch: pytest.MonkeyPatch) -> None:
        self.widget = widget
        self.heard: list[dict[str, Any]] = []
        self._new = asyncio.Event()
        monkeypatch.setattr(type(widget), "send", lambda widget, *sent, **more: self._hear(*sent, **more))

    def _hear(self, content: dict[str, Any], buffers: list[bytes] | None = None) -> None:
        self.heard.append(read_frame(buffers[0]) if buffers else content)
        self._new.set()

    def say(self, kind: str, **fields: Any) -> None:
        self.widget._handle_custom_msg({"type": kind, **fields}, [])

    async def until(self, kind: str, **fields: Any) -> dict[str, Any]:
        while True:
            for message in self.heard:
                if message["type"] == kind and all(message[name] == value for name, value in fields.items()):
                    return message
            self._new.clear()
            await asyncio.wait_for(self._new.wait(), 30)


def in_a_notebook(check: Callable[[], Any]) -> None:
    async def run() -> None:
        try:
            await check()
        finally:
            await notebook.close_all()

    asyncio.run(run())


def test_the_widget_speaks_as_the_page_does(clip, monkeypatch) -> None:
    async def check() -> None:
        widget = notebook.edit(clip, height=500)
        assert (widget.height, widget._esm, widget._css) == (500, "export default {};", ".retime {}")
        cell = Cell(widget, monkeypatch)
        cell.say("hello", version=VERSION)
        state = await cell.until("state")
        assert (await cell.until("clip"))["n_frames"] == 241
        document = {**state["document"], "options": {"length": "75%"}}
        cell.say("edit", revision=2, gesture="", done=True, label="set length", document=document)
        curve = await cell.until("curve", revision=2)
        assert (await cell.until("state", revision=2))["undo_label"] == "set length"
        expected = guided_warp(read(clip), length="75%").warp.input_times
        np.testing.assert_array_equal(curve["input_times"], expected)
        np.testing.assert_array_equal(widget.warp.input_times, expected)
        assert widget.document.options == {"length": "75%"}
        cell.say("fly")
        assert 'no message is called "fly"' in (await cell.until("notice"))["text"]
        widget.close()

    in_a_notebook(check)


def test_a_cell_that_is_run_again_shows_the_same_document(clip, monkeypatch) -> None:
    async def check() -> None:
        first = Cell(notebook.edit(clip), monkeypatch)
        first.say("hello", version=VERSION)
        document = {**(await first.until("state"))["document"], "options": {"length": "75%"}}
        first.say("edit", revision=2, gesture="", done=True, label="set length", document=document)
        await first.until("state", revision=2)
        again = notebook.edit(clip)
        assert again.document.options == {"length": "75%"}

    in_a_notebook(check)

    async def check_later() -> None:
        assert notebook.edit(clip).document.options == {"length": "75%"}

    in_a_notebook(check_later)


def test_what_can_not_be_edited_is_refused(clip, tmp_path, monkeypatch) -> None:
    with pytest.raises(OptionError, match="needs a notebook"):
        notebook.edit(clip)

    async def check() -> None:
        with pytest.raises(OptionError, match="name a clip"):
            notebook.edit()
        (tmp_path / "there.retime").touch()
        with pytest.raises(OptionError, match="clips of its own"):
            notebook.edit(clip, project=tmp_path / "there.retime")
        (notebook.PAGE / "widget.js").unlink()
        with pytest.raises(MissingPageError, match="make page"):
            notebook.edit(clip)

    in_a_notebook(check)


def test_ready_waits_for_the_warp_without_a_view(clip) -> None:
    async def check() -> None:
        widget = notebook.edit(clip)
        assert widget.warp is None
        warp = await asyncio.wait_for(widget.ready(), 30)
        assert widget.warp is warp
        assert warp.input_times[-1] == read(clip).end_time
        assert "jump.bvh" in repr(widget)
        assert await widget.ready() is warp

    in_a_notebook(check)


def test_ready_waits_for_the_document_as_it_is_now(clip, monkeypatch) -> None:
    async def check() -> None:
        widget = notebook.edit(clip)
        cell = Cell(widget, monkeypatch)
        cell.say("hello", version=VERSION)
        document = (await cell.until("state"))["document"]
        await widget.ready()
        for revision, length in ((2, "90%"), (3, "75%")):
            edited = {**document, "options": {"length": length}}
            cell.say("edit", revision=revision, gesture="", done=True, label="set length", document=edited)
        expected = guided_warp(read(clip), length="75%").warp.input_times
        np.testing.assert_array_equal((await widget.ready()).input_times, expected)
        cell.say(
            "edit",
            revision=4,
            gesture="",
            done=True,
            label="set length",
            document={**document, "options": {"length": "1f"}},
        )
        with pytest.raises(RetimeError, match="a length of 1f is 1 frame"):
            await asyncio.wait_for(widget.ready(), 30)

    in_a_notebook(check)


def test_a_motion_is_edited_as_its_file_is(clip, tmp_path) -> None:
    async def check() -> None:
        motion = read(clip)
        widget = notebook.edit(motion, reference=motion.frames(0, 120))
        warp = await widget.ready()
        assert warp == replace(guided_warp(motion, reference=motion.frames(0, 120)).warp, name=warp.name)
        (file,) = widget.document.clips
        assert file.path.startswith(str(tmp_path / "state" / "notebook"))
        # Run again: the same clip is the same document.
        assert notebook.edit(read(clip), reference=[motion.frames(0, 120)]).document is widget.document
        # Another is another.
        assert notebook.edit(motion.frames(0, 200)).document.clips[0].path != file.path

    in_a_notebook(check)


def test_clips_that_are_no_files_keep_what_they_are(clip, tmp_path) -> None:
    async def check() -> None:
        motion = replace(read(clip), up="z", name="../über all/ .bvh")
        values = np.random.default_rng(0).normal(size=(241, 3))
        values[:, 2] = np.arange(241) // 100
        values[50:60, 1] = np.nan
        said = ChannelKind("label", words=("walk", "run", "stand"))
        signal = Signal(("pan", "tilt", "said"), values, motion.rate, kinds=["angle:rad", "linear", said], gaps="keep")
        widget = notebook.edit(motion, signal)
        await widget.ready()
        first, second = widget.document.clips
        assert (first.up, second.role) == ("z", "follow")
        assert Path(first.path).parent.parent == tmp_path / "state" / "notebook"
        found = read(first.path, up="z")
        np.testing.assert_allclose(found.positions, motion.positions, atol=1e-5)
        assert (first.gaps, second.gaps) == (None, "keep")
        with pytest.warns(FormatWarning, match="kept gaps: tilt frames 50:59"):
            again = read(second.path, gaps=second.gaps)
        assert np.array_equal(again.values, signal.values, equal_nan=True)
        assert (again.names, again.rate, again.kinds) == (signal.names, signal.rate, signal.kinds)

    in_a_notebook(check)


def test_what_is_no_clip_is_refused(clip) -> None:
    async def check() -> None:
        with pytest.raises(OptionError, match="a path, a motion or a signal; found a Warp"):
            notebook.edit(Warp([0, 1], [0, 1]))

    in_a_notebook(check)

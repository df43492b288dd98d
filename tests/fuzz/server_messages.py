"""Hostile messages to the editor's server: each is answered or refused, and every edit after it is solved.

    python -m tests.fuzz.server_messages --count 2000 --seed 1

One trial is ten messages to an editor of its own, by a WebSocket, and then an edit whose curve must come.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed

from retime.formats import write
from tests.fuzz.trials import command, mutated_bytes, mutated_json
from tests.server.serving import KEY, Page, serving
from tests.warp.motions import wandering_motion

MOST_SECONDS = 60
# Seconds in which an edit must be taken.
WAITS = 30
# The clip of the last edit, which no message names: others may have been replaced by an export.
LAST = "last.bvh"


def _message(draw: random.Random, page: Page) -> dict[str, Any]:
    """Make a message that could be meant."""
    document = {**page.document, "keys": [{**KEY, "input_time": 0.5, "output_time": 0.6}]}
    options = draw.choice([{}, {"length": "80%"}, {"length": "free"}, {"speed": "0.5..2"}])
    edit = {"gesture": draw.choice(["", "g"]), "done": draw.random() < 0.7, "label": "edit"}
    place = draw.choice(
        ["walk.bvh", "other.bvh", "new.bvh", "new.retime", "new.json", "new.svg", "..", "link.bvh", "pipe"]
    )
    return draw.choice(
        [
            {"type": "edit", "revision": page.revision + 1, "document": {**document, "options": options}, **edit},
            {"type": "edit", "revision": page.revision + 1, "document": document, **edit},
            {"type": "undo", "revision": page.revision + 1},
            {"type": "redo", "revision": page.revision + 1},
            {"type": "keep", "revision": page.revision + 1, "name": "kept"},
            {"type": "save", "path": place, "overwrite": draw.random() < 0.5},
            {"type": "open", "path": place},
            {
                "type": "export",
                "what": draw.choice(["motion", "warp"]),
                "path": place,
                "clip": draw.choice([0, 0, 1]),
                "overwrite": draw.random() < 0.5,
            },
            {
                "type": "export_curve",
                "host": draw.choice(["nuke", "csv", "maya", "lottie", "ffmpeg", "abacus"]),
                "path": draw.choice([place, "new.nk", "new.csv", "new.ma"]),
                "rate": draw.choice(["", "24", "fast", "1e9", "0"]),
                "start": draw.choice(["", "1001", "-1", "x", "9" * 40]),
                "item": draw.choice(["", "walk", "a\nb", "}"]),
                "tolerance": draw.choice(["", "0.01", "-1", "1e3", "nan"]),
                "overwrite": draw.random() < 0.5,
            },
            {"type": "stop", "revision": draw.choice([0, 1, 5, 10**9])},
            {"type": "anew"},
            {"type": "browse", "folder": draw.choice([None, ".", "d", ".."]), "holds": "clip"},
            {
                "type": "find",
                "path": place,
                "writing": draw.random() < 0.5,
                "as_clip": draw.random() < 0.5,
            },
        ]
    )


def trial(draw: random.Random) -> str:
    """Serve a clip, send messages, and see that it goes on."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        folder = Path(name).resolve() / "clips"
        folder.mkdir()
        for file, seed in (("walk.bvh", 0), ("other.bvh", 1), (LAST, 2)):
            write(wandering_motion(40, seed=seed), folder / file)
        (folder / "d").mkdir()
        (folder / "link.bvh").symlink_to("pipe")
        (folder / "pipe").symlink_to("link.bvh")
        with serving(folder, "walk.bvh") as served:
            closed = 0
            with served.page() as page:
                state = page.until("state")
                page.document, page.revision = state["document"], state["revision"]
                try:
                    for _ in range(10):
                        _send(draw, page)
                    page.say("find", path="the end", writing=False)
                    page.until("found", path="the end")
                except ConnectionClosed:
                    # What is no text ends its page.
                    closed += 1
                _check(page)
            with served.page() as page:
                _goes_on(page)
    return "goes on after a page was closed" if closed else "goes on"


def _send(draw: random.Random, page: Page) -> None:
    """Send a message that is changed in a few places."""
    message = _message(draw, page)
    for _ in range(draw.choice([0, 1, 1, 2])):
        message = mutated_json(draw, message)
    text = json.dumps(message)
    if draw.random() < 0.1:
        page.socket.send(mutated_bytes(draw, text.encode()).decode("utf-8", "replace"))
    elif draw.random() < 0.02:
        page.socket.send(text.encode())
    else:
        page.socket.send(text)
    if isinstance(message, dict) and message.get("type") in ("edit", "undo", "redo", "keep"):
        # If it was taken; if not, all that follow are refused for their revision, until a state is told.
        page.revision += draw.random() < 0.5


def _goes_on(page: Page) -> None:
    """Ask for another clip until the document is the one that was asked for, and wait for its curve."""
    _take(page, page.until("state"))
    # What was opened by the messages before may still be read, and its end is told only to the page that asked.
    until = time.monotonic() + WAITS
    while time.monotonic() < until:
        page.change(
            "edit",
            gesture="",
            done=True,
            label="go on",
            document={"clips": [{"path": LAST}], "options": {"length": "77%"}, "kept": page.document["kept"]},
        )
        answer = page.until("curve", "problem", "notice", "elsewhere")
        while answer["type"] in ("curve", "problem") and answer["revision"] != page.revision:
            answer = page.until("curve", "problem", "notice", "elsewhere")
        _check(page)
        if answer["type"] == "curve":
            return
        assert answer["type"] != "problem", answer
        # What is refused is told with the state; what is only a warning has the state of the edit beside it.
        _take(page, page.until("state"))
        time.sleep(0.01)
    raise AssertionError(f"no edit is taken: {answer}")


def _take(page: Page, state: dict[str, Any]) -> None:
    page.document, page.revision = state["document"], state["revision"]
    page.mail.clear()


def _check(page: Page) -> None:
    for message in page.mail:
        words = message.get("text") or message.get("message") or ""
        assert "fault " not in words or " in retime (" not in words, words


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__, most_seconds=MOST_SECONDS))

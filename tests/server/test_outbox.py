"""What a slow page is sent."""

from __future__ import annotations

import asyncio
import json

from retime.server import messages
from retime.server.outbox import Outbox


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

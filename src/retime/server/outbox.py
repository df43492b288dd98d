"""What is to be sent to one page."""

from __future__ import annotations

import asyncio

from retime.server import messages
from retime.server.message_coding import type_name, write_message
from retime.server.messages import ServerMessage


class Outbox:
    """Messages that wait for one page. A slow page gets the latest curve, not all of them."""

    def __init__(self) -> None:
        self._parts: dict[str, str | bytes] = {}
        self._count = 0
        self._filled = asyncio.Event()

    def put(self, message: ServerMessage, payload: str | bytes | None = None) -> None:
        """Send a message after those that wait; one that tells the same of a newer revision takes its place."""
        self._count += 1
        slot = str(self._count)
        if isinstance(message, messages.Curve | messages.Why | messages.Ack | messages.Progress | messages.Problem):
            slot = type_name(type(message))
        self._parts.pop(slot, None)
        self._parts[slot] = write_message(message) if payload is None else payload
        self._filled.set()

    async def get(self) -> str | bytes:
        """Wait for the next message to send, and take it."""
        while not self._parts:
            self._filled.clear()
            await self._filled.wait()
        return self._parts.pop(next(iter(self._parts)))

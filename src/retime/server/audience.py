"""The pages that look at a document, and what one that comes later has to be told."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from retime.server import messages
from retime.server.message_coding import write_message
from retime.server.messages import ServerMessage
from retime.server.outbox import Outbox


class Audience:
    """The pages that look at one document."""

    def __init__(self) -> None:
        self._pages: set[Outbox] = set()
        # The last message of each kind: the curve, the problem, the clip at each place.
        self._latest: dict[str, tuple[ServerMessage, str | bytes]] = {}

    def join(self, page: Outbox, now: Iterable[ServerMessage]) -> None:
        """Tell a new page the clips, then how the document stands `now`, then all that was found of it."""
        clips = [found for found in self._latest.values() if isinstance(found[0], messages.Clip)]
        others = [found for found in self._latest.values() if not isinstance(found[0], messages.Clip)]
        for message, payload in clips:
            page.put(message, payload)
        for message in now:
            page.put(message)
        for message, payload in others:
            page.put(message, payload)
        self._pages.add(page)

    def leave(self, page: Outbox) -> None:
        """Forget a page."""
        self._pages.discard(page)

    def tell(self, *told: ServerMessage) -> None:
        """Tell the pages that are here now."""
        for message in told:
            payload = write_message(message)
            for page in self._pages:
                page.put(message, payload)

    def tell_others(self, but: Outbox, message: ServerMessage) -> None:
        """Tell all pages but one."""
        payload = write_message(message)
        for page in self._pages - {but}:
            page.put(message, payload)

    def publish(self, found: Mapping[str, tuple[ServerMessage, str | bytes]]) -> None:
        """Tell the pages that are here, and those to come.

        Parameters
        ----------
        found : mapping of str
            Messages and how they are written, by what they are; one of the same name told before is replaced.
        """
        for name, (message, payload) in found.items():
            if name == "curve":
                self._latest.pop("problem", None)
            if name in ("curve", "problem"):
                self._latest.pop("progress", None)
            if isinstance(message, messages.Notice) and name in self._latest:
                # Told before; each position of a drag would tell it again.
                continue
            # How a clip is written is kept, and not once more what was written: of a long take that is much.
            self._latest[name] = _without_arrays(message) if isinstance(message, messages.Clip) else message, payload
            for page in self._pages:
                page.put(message, payload)

    def keep_clips(self, counts: Mapping[str, int]) -> None:
        """Forget clips and references beyond as many as there are, by ``clip`` and ``reference``."""
        for name, (message, _) in list(self._latest.items()):
            if isinstance(message, messages.Clip) and message.index >= counts[message.what]:
                del self._latest[name]

    def forget(self) -> None:
        """Another document is open: what was found of the old one is told to nobody any more."""
        self._latest.clear()


def _without_arrays(clip: messages.Clip) -> messages.Clip:
    return replace(clip, positions=np.zeros((0, 0, 3), dtype=np.float32), values=np.zeros((0, 0)))

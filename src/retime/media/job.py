"""What is to be made of a media file, and what the work on it tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from retime.media.options import MediaOptions
from retime.warp.curve import Warp


@dataclass
class Report:
    """What the work tells: that it lives, how far it is, what a person should know.

    Attributes
    ----------
    tell : function
        Takes one fact at a time, as JSON has it.
    """

    tell: Callable[[dict[str, Any]], None]
    total: float = 1.0
    done: float = 0.0
    warnings: set[str] = field(default_factory=set)

    def beat(self) -> None:
        """Say that something was done."""
        self.tell({"beat": 1})

    def share(self, seconds: float) -> None:
        """Say how many seconds of the output there are."""
        self.done = max(self.done, seconds)
        self.tell({"share": min(1.0, self.done / self.total)})

    def warn(self, text: str) -> None:
        """Say something that a person should know, once."""
        if text not in self.warnings:
            self.warnings.add(text)
            self.tell({"warning": text})


@dataclass(frozen=True)
class OtherSound:
    """Sound of another file, for pictures that have none.

    Parameters
    ----------
    path : Path
        The file; what is heard is its first stream of sound.
    warp : Warp
        From the output's time to the file's own, both of which begin with 0.
    """

    path: Path
    warp: Warp


@dataclass(frozen=True)
class Job:
    """What is to be done.

    Attributes
    ----------
    path, place : Path
        The input, and where the output will be.
    warp : Warp
        From output time to input time.
    options : MediaOptions
        How.
    sound : OtherSound, optional
        Of pictures without sound: what is heard.
    """

    path: Path
    place: Path
    warp: Warp
    options: MediaOptions
    sound: OtherSound | None = None

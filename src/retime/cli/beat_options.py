"""Beats as keytimes on the command line: which accent of the clip met which beat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH
from retime.cli.help_sections import Option
from retime.errors import InfeasibleWarpError

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion
    from retime.search.beats import Beat, Match
    from retime.warp.keytime import Keytime

keys_from_option = click.option(
    "--keys-from",
    cls=Option,
    section="Keytimes",
    metavar="FILE",
    type=PATH,
    help="Put the clip's accents (feet that come down, peaks of speed) on beats: times in a table (beats.csv), or "
    "found in sound (song.wav). What met which is told.",
)

keys_on_option = click.option(
    "--keys-on",
    cls=Option,
    section="Keytimes",
    metavar="WHAT",
    type=click.Choice(["beats", "onsets"]),
    default_text="beats",
    help="Of sound: its regular beats, or whenever something begins in it.",
)


@dataclass
class BeatKeys:
    """Beats, and what of a clip falls on them.

    Attributes
    ----------
    beats : list of Beat
        All that were found.
    matches : list of Match
        Those that are met.
    infeasible : list of Match
        Those that the search could not meet, and were left out.
    """

    beats: list[Beat]
    matches: list[Match]
    infeasible: list[Match] = field(default_factory=list)

    @property
    def keys(self) -> list[Keytime]:
        """The keytimes."""
        return [match.key for match in self.matches]

    def searched(self, search: Callable[[list[Keytime]], Any]) -> Any:
        """Search with these keytimes, and, where no warp meets them, without the weakest of those at fault."""
        while True:
            try:
                return search(self.keys)
            except InfeasibleWarpError as error:
                if not self.matches:
                    raise
                at_fault = [match for match in self.matches if match.beat.time in error.output_times] or self.matches
                weakest = min(at_fault, key=lambda match: match.accent.strength * match.beat.strength)
                self.matches.remove(weakest)
                self.infeasible.append(weakest)

    def facts(self) -> list[dict[str, Any]]:
        """Return for each beat what --json prints."""
        met = {match.beat.time: match.accent for match in self.matches}
        left_out = {match.beat.time for match in self.infeasible}
        return [
            {
                "beat": beat.time,
                "name": beat.name,
                "accent": None if (accent := met.get(beat.time)) is None else accent.time,
                "kind": None if accent is None else accent.kind,
                "infeasible": beat.time in left_out,
            }
            for beat in self.beats
        ]

    def rows(self) -> list[tuple[str, str]]:
        """Return rows for people."""
        met = {match.beat.time: match.accent for match in self.matches}
        rows = [("beats", f"{len(self.matches)} of {len(self.beats)} met")]
        left_out = {match.beat.time for match in self.infeasible}
        for beat in self.beats:
            accent = met.get(beat.time)
            if accent is not None:
                what = f"{accent.kind} at {accent.time:.2f} s of the input"
            else:
                what = "left out: no warp meets it" if beat.time in left_out else "nothing falls on it"
            rows.append((f"  {beat.time:.2f} s", f"{what}{beat.name and f' ({beat.name})'}"))
        return rows


def beat_keys(
    path: Path, on: str | None, clip: AnyMotion, keys: Sequence[Keytime], output_end: float | None
) -> BeatKeys:
    """Read or find beats, and match a clip's accents with them.

    Parameters
    ----------
    path : Path
        The table, or the sound.
    on : {"beats", "onsets"}, optional
        Of sound.
    clip : Motion or Signal
        The input.
    keys : sequence of Keytime
        Keytimes that the user gave, which hold; matches that contradict them are left out.
    output_end : float, optional
        Seconds, of the output's last frame, where it is known.
    """
    from retime.media.beats import read_beats
    from retime.motion.accents import accents
    from retime.search.beats import Beat, match_beats

    beats = [Beat(*one) for one in read_beats(path, on="onsets" if on == "onsets" else "beats")]
    matches = match_beats(accents(clip), beats, input_end=clip.end_time, output_end=output_end)
    agreeing = [
        match
        for match in matches
        if all(
            (match.accent.time - key.input_time) * (match.beat.time - key.output_time) > 0 or match.key == key
            for key in keys
        )
    ]
    if not agreeing:
        raise InfeasibleWarpError(
            f"no accent of {clip.name or 'the clip'} can fall on a beat of {path}: between two of them it would be "
            "played more than three times as fast as life, or as slow; another length may help"
        )
    return BeatKeys(beats, agreeing)

"""Messages in the page's words: whoever edits there has fields, and neither options nor arguments.

A message names what would help as the command line and Python do, once, where it is made: ``(--fps, rate=)``. On its
way to the page such a name becomes that of the page's field. Where the page has none, another command is named.
"""

from __future__ import annotations

import re

from retime.formats.channel_meaning import GAPS_HINT
from retime.hosts.registry import HOSTS
from retime.search.options import BY_NAME

_READ = "under How it is read"
_CSV = next(host.title for host in HOSTS if host.name == "csv")


def _labelled(name: str, value: str = "") -> str:
    """Say what the page calls an option of the search, and a value of one that is chosen from a few."""
    option = BY_NAME[name]
    chosen = [choice.label for choice in option.choices if choice.value == value]
    return f"“{option.label}”" + "".join(f": {label}" for label in chosen)


# What is typed in a terminal, and stays.
_TYPED = re.compile(r"((?:type|start): .*|pip install .*|usdcat --flatten)", re.DOTALL)

# What a message says, as a pattern, and what the page says instead; longer ones first.
_WORDS = [
    # A file may be called walk--fps.bvh.
    (re.compile(pattern.replace("--", r"(?<![\w-])--")), words)
    for pattern, words in (
        # How a clip is read.
        (r"--fps, rate=|--fps; for an array rate=|--fps R\b|--fps\b", f"“Rate, Hz” {_READ}"),
        (r"--skeleton\b", f"“Skeleton” {_READ}"),
        (re.escape(GAPS_HINT), f"“Gaps” {_READ} can bridge them, or keep them"),
        (r"--gaps bridge:SECONDS", f"“Gaps” {_READ}: Bridge"),
        (r"--channel '([^']*)'", rf"“Channels” {_READ}: \1"),
        (r"--channel (\S+=\w+)", rf"“Channels” {_READ}: \1"),
        (r"--also CLIP(\S+)=OUT; in (?:Python on_clock_of|the editor under How it is read)", rf"“Begins” {_READ}: \1"),
        (
            r"(?:--drop-first \d+|--reference-frames \d+:) \(in Python [^;)]*; in the editor use frames from (\d+)\)",
            r"use frames from \1",
        ),
        # How the warp is found.
        (r"rate=, --rate\b", _labelled("rate")),
        (r"search='priced' \(--search priced\)|--search priced\b", _labelled("search", "priced")),
        (r"search='heuristic'", _labelled("search", "heuristic")),
        (r"--method linear; linear_warp", "“Method”: Linear"),
        (r"--speed ([^\s)]+)", rf"{_labelled('speed')}: \1"),
        (r"speed='([^']*)'", rf"{_labelled('speed')}: \1"),
        (r"length='free'|--length free\b", f"{_labelled('length')}: free"),
        (r"paper=True, --paper\b", _labelled("paper")),
        (r" \(Limits\.\w+\)", ""),
        # What is written.
        (r"--rate\b", "“Rate”"),
        (r"--start\b", "“First frame”"),
        (r"--tolerance\b", "“Tolerance”"),
        (r"--item\b", "“For”"),
        (r"--host csv\b", f"“Program”: {_CSV}"),
        (r"--host\b", "“Program”"),
        (r"--force\b", "“Replace the file if it is there”"),
        # What another command does.
        (r"--repair \(repair=True\)", "--repair"),
        (r"--decimal-comma, decimal_comma=True", "--decimal-comma"),
        (
            r"--(repair|decimal-comma|array|animation|confidence|allow-outside)\b",
            r"retime convert with --\1",
        ),
        (r"--(layer|bake|codec|no-deinterlace)\b", r"retime apply with --\1"),
    )
]


def page_words(text: str) -> str:
    """Say a message in the page's words.

    Parameters
    ----------
    text : str
        As the command line and Python say it.

    Returns
    -------
    str
        With the names of the page's fields in place of options and arguments; commands that it says are as they were.

    Examples
    --------
    >>> page_words("the file holds no rate, so it must be given (--fps)")
    'the file holds no rate, so it must be given (“Rate, Hz” under How it is read)'
    """
    parts = _TYPED.split(text)
    # Every other one is typed.
    for place in range(0, len(parts), 2):
        for pattern, words in _WORDS:
            parts[place] = pattern.sub(words, parts[place])
    return "".join(parts)


def of_unopened(words: str) -> str:
    """Say where what a file lacks can be said, where that is asked for and the file was not opened.

    Parameters
    ----------
    words : str
        Why it was not opened, in the page's words.
    """
    return f"{words}. That can be said of a clip which is added under Clips" if _READ in words else words

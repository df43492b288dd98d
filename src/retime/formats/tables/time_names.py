"""Which columns hold times, by their names, and in what they count."""

from __future__ import annotations

import re

from retime.motion.clock import ClockForm

FORM_OF_UNIT: dict[str, ClockForm] = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("us", "µs", "usec", "usecs", "micros", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"), "ns"),
}
_TIMES = {"time", "times", "t", "timestamp", "timestamps", "timecode", "smpte", "datetime", "clock", "epoch"}
# By themselves only these say that a column holds times: "s" and "ms" may be anything.
_UNITS_ALONE = {unit for unit in FORM_OF_UNIT if len(unit) > 5}
_BESIDE = {
    "elapsed",
    "relative",
    "absolute",
    "unix",
    "utc",
    "stamp",
    "sample",
    "capture",
    "recording",
    "media",
    "system",
    "device",
    "local",
    "since",
    "start",
    "code",
    "of",
    "day",
    "in",
}
_FRAMES = {"frame", "frames"}
_BESIDE_FRAMES = {"index", "idx", "number", "num", "no", "nr", "id", "count"}


def _words(name: str) -> list[str]:
    """Take a name apart at signs, and where small letters change to large ones."""
    parted = re.sub(r"(?<=[a-zµ])(?=[A-Z])", " ", name)
    return [word.lower() for word in re.findall(r"[^\W_\d]+", parted)]


def is_time_name(name: str) -> bool:
    """Whether a column of this name holds times.

    Examples
    --------
    >>> [is_time_name(name) for name in ("Time (Seconds)", "time_ms", "# time", "Timecode", "reaction time", "ms")]
    [True, True, True, True, False, False]
    """
    words = _words(name)
    if re.search(r"\d", name) or not words:
        return False
    times = [word for word in words if word in _TIMES or word in _UNITS_ALONE]
    return bool(times) and all(word in _TIMES or word in _BESIDE or word in FORM_OF_UNIT for word in words)


def form_of_name(name: str) -> ClockForm | None:
    """In what a column of times counts, where its name says that.

    Examples
    --------
    >>> form_of_name("time_ms"), form_of_name("Time [s]"), form_of_name("timestamp")
    ('ms', 's', None)
    """
    return next((FORM_OF_UNIT[word] for word in reversed(_words(name)) if word in FORM_OF_UNIT), None)


def is_frame_name(name: str) -> bool:
    """Whether a column of this name numbers frames.

    Examples
    --------
    >>> [is_frame_name(name) for name in ("Frame", "frame_index", "Frame#", "frames dropped")]
    [True, True, True, False]
    """
    words = _words(name)
    return (
        not re.search(r"\d", name)
        and bool(set(words) & _FRAMES)
        and all(word in _FRAMES or word in _BESIDE_FRAMES for word in words)
    )

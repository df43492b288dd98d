"""Marker tables (.trc): two rows of settings, a row of markers and one of axes."""

from __future__ import annotations

from retime.errors import OptionError
from retime.formats.number_text import count_of
from retime.formats.tables.layout import Head, Layout, joined_names
from retime.motion.channels import ChannelKind
from retime.motion.rate import parse_rate


def find(head: Head) -> Layout | None:
    """Read a head that begins with ``PathFileType``; the channels are called ``LASI.x``.

    Raises
    ------
    FormatError
        Rows of the head are missing, or disagree in the count of markers.
    """
    first = head.rows[0]
    if first.fields[0].lower() != "pathfiletype":
        return None
    if len(head.rows) < 5:
        raise head.error(first.line, "a table of markers (TRC) has five rows above its numbers; the file ends before")
    keys, values, markers, axes = head.rows[1:5]
    settings = dict(zip(map(str.lower, keys.fields), values.fields, strict=False))
    try:
        rate = parse_rate(settings["datarate"])
    except (KeyError, OptionError) as error:
        raise head.error(values.line, f"DataRate: {error}") from None
    names = [name for name in markers.fields[2:] if name]
    claimed = settings.get("nummarkers", "")
    if count_of(claimed) != len(names):
        raise head.error(
            markers.line, f"NumMarkers is {claimed[:40] or 'missing'}, and {len(names)} markers have names"
        )
    n_axes = sum(1 for name in axes.fields if name)
    if n_axes != 3 * len(names):
        raise head.error(axes.line, f"{n_axes} axes, where {len(names)} markers have {3 * len(names)}")
    channels = joined_names([(name, axis) for name in names for axis in "XYZ"])
    # The blank line below the axes may have tabs.
    blank = len(head.rows) > 5 and not any(head.rows[5].fields)
    unit = ChannelKind("linear", settings.get("units", ""))
    return Layout(
        "TRC markers",
        ("Frame#", "Time", *channels),
        markers.line,
        head.rows[5].stop if blank else axes.stop,
        head.delimiter,
        rate=rate,
        n_frames=count_of(settings.get("numframes", "")),
        extra=True,
        clock=1,
        clock_form="s",
        kinds=dict.fromkeys(range(2, 2 + len(channels)), unit),
    )

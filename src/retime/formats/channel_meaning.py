"""From columns of numbers that a file holds to a signal: what each channel is, and what is done about gaps."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning, InvalidMotionError
from retime.formats.read_options import ReadOptions
from retime.motion.channels import ChannelKind, find_kinds, with_chosen
from retime.motion.gaps import bridged, gaps_text
from retime.motion.signal import Signal

GAPS_HINT = "--gaps bridge fills gaps, --gaps keep carries them through"


def make_signal(
    path: Path,
    names: Sequence[str],
    values: FloatArray,
    rate: Fraction,
    options: ReadOptions,
    known: Mapping[int, ChannelKind] | None = None,
    **facts: Any,
) -> Signal:
    """Make a signal of columns that were read.

    Parameters
    ----------
    path : Path
        The file, for messages.
    names : sequence of str
        Of the columns.
    values : float array, shape (n_frames, n_channels)
        The columns; not a number where nothing is written.
    rate : Fraction
        Frames a second.
    options : ReadOptions
        Whose channels and gaps are followed.
    known : mapping of int to ChannelKind, optional
        Kinds that the file declares, by column: text is one.
    **facts
        What else a `Signal` has.

    Raises
    ------
    FormatError
        A value is missing and nobody said what to do about gaps, a channel is empty, or values are not what they are
        said to be.
    OptionError
        A kind was chosen for a channel that can't have it.

    Warns
    -----
    FormatWarning
        Gaps were bridged, or kept: which frames of which channels.
    """
    kinds = list(find_kinds(names, values))
    for place, kind in (known or {}).items():
        kinds[place] = kind
    # Files of one command differ: a pattern may be meant for another one. Whether any fits is for the registry to say.
    kinds = list(with_chosen(kinds, names, options.channels, all_fit=False))
    missing = np.isnan(values)
    keep: Any = "refuse"
    if options.gaps is not None and missing.any():
        empty = np.flatnonzero(missing.all(axis=0))
        if len(empty):
            raise FormatError(f"channel {names[int(empty[0])]!r} has no value at all", path=path)
        first_frame = int(facts.get("first_frame", 0))
        values = bridged(values, names, kinds, options.gaps.bridge * float(rate) * (1 + 1e-9))
        left = np.isnan(values)
        if (missing & ~left).any():
            warnings.warn(
                f"{path}: bridged gaps: {gaps_text(missing & ~left, names, first_frame)}", FormatWarning, stacklevel=4
            )
        if left.any():
            keep = "keep"
            longer = f" longer than {options.gaps.bridge:g} s" if options.gaps.bridge else ""
            warnings.warn(
                f"{path}: kept gaps{longer}: {gaps_text(left, names, first_frame)}; the search doesn't look at those "
                "frames",
                FormatWarning,
                stacklevel=4,
            )
    try:
        return Signal(tuple(names), values, rate=rate, name=path.stem, kinds=kinds, gaps=keep, **facts)
    except InvalidMotionError as error:
        hint = f"; {GAPS_HINT}" if options.gaps is None and missing.any() else ""
        raise FormatError(f"{error}{hint}", path=path) from None

"""How a table writes its whole numbers, so that what is not interpolated is written as it was.

Numbers are read fast, and what is left of ``1``, ``1.0`` and ``007`` is a value alone. Here their text is looked up
again: of the first rows of columns that hold nothing but whole numbers, and of all rows where numbers are names of
things (labels, events, ids).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from retime.arrays import FloatArray
from retime.formats.number_text import parse_number
from retime.formats.read_options import ReadOptions
from retime.formats.tables.table_rows import TableRows
from retime.motion.channels import ChannelKind, are_few, find_kinds, matching, text_label, with_chosen

_WHOLE = re.compile(r"[+-]?[0-9]+")
_PADDED = re.compile(r"[+-]?0[0-9]+")
_ROWS_TO_TELL = 1000
# From here on doubles leave whole numbers out: the next one is read as this one.
_EXACT = 2.0**53


def with_numerals(
    rows: TableRows,
    columns: Sequence[int],
    values: FloatArray,
    known: Mapping[int, ChannelKind],
    options: ReadOptions,
) -> dict[int, ChannelKind]:
    """Say of channels of whole numbers how their file writes them.

    Parameters
    ----------
    rows : TableRows
        What was read.
    columns : sequence of int
        The columns that are channels.
    values : float array, shape (n_rows, n_channels)
        Their numbers. Those of a label whose texts differ where its numbers don't (``7`` and ``007``, ids beyond 2**53)
        are replaced: by the places of its words.
    known : mapping of int to ChannelKind
        Kinds that the file declares, by channel.
    options : ReadOptions
        Whose kinds are followed.

    Returns
    -------
    dict of int to ChannelKind
        What was known, with what was found. Whole numbers that are padded with zeros, or too large for a double, are
        labels where they are few and nobody says otherwise.
    """
    names = [rows.text.names[column] for column in columns]
    kinds = list(find_kinds(names, values))
    for place, kind in known.items():
        kinds[place] = kind
    kinds = list(with_chosen(kinds, names, options.channels, all_fit=False))
    told = {place for pattern in options.channels for place in matching(pattern, names)} | set(known)
    with np.errstate(invalid="ignore"):
        whole = ((values == np.round(values)) | np.isnan(values)).all(axis=0)
    places = [place for place in np.flatnonzero(whole).tolist() if not kinds[place].words]
    found = dict(known)
    named = []
    samples = rows.cells([columns[place] for place in places], min(len(values), _ROWS_TO_TELL))
    for place, sample in zip(places, samples, strict=True):
        texts = [text for text, hole in zip(sample, np.isnan(values[: len(sample), place]), strict=True) if not hole]
        if texts and all(map(_WHOLE.fullmatch, texts)):
            kinds[place] = found[place] = replace(kinds[place], form="whole")
            odd = any(map(_PADDED.fullmatch, texts)) or bool(np.nanmax(np.abs(values[:, place])) >= _EXACT)
            if odd and kinds[place].kind == "linear" and place not in told:
                named.append(place)
        if kinds[place].kind in ("label", "event"):
            named.append(place)
    for place, cells in zip(named, rows.cells([columns[place] for place in named], len(values)), strict=True):
        found_kind = _named(kinds[place], cells, values[:, place], decimal_comma=options.decimal_comma)
        if found_kind is not None:
            found[place] = found_kind
    return found


def _named(kind: ChannelKind, cells: Sequence[str], numbers: FloatArray, *, decimal_comma: bool) -> ChannelKind | None:
    """Say how numbers that are names are written; `numbers` may become places of words. None where nothing is odd."""
    known = np.flatnonzero(~np.isnan(numbers))
    texts = [cells[frame].replace(",", ".") if decimal_comma else cells[frame] for frame in known.tolist()]
    different = list(dict.fromkeys(texts))
    if kind.kind == "linear" and not are_few(len(different), len(texts)):
        return None
    # Compared by its text, a zero keeps its sign.
    numbers_of = {text: repr(parse_number(text.encode())) for text in different}
    whole = [number for text, number in numbers_of.items() if _WHOLE.fullmatch(text)]
    if len(set(whole)) < len(whole) and kind.kind != "event":
        numbers[known], words = text_label(texts)
        return words
    written: dict[str, str] = {}
    for text, number in numbers_of.items():
        written.setdefault(number, text)
    label = kind if kind.kind == "event" else replace(kind, kind="label", unit="")
    plain = all(text == str(int(float(number))) for number, text in written.items())
    return replace(label, numerals=() if plain else tuple(written.values()))

"""Names replaced by stand-ins of the same length: the same name always by the same one.

A stand-in has as many bytes as the name, so that lines, columns and places in a binary file stay what they were.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping
from typing import ClassVar

# A number, in any spelling that a reader may stumble over (1_0, 0,5, 0.0-7.5, 1e999), the T and Z of a date, or a word.
_NUMBER = rb"(?:[0-9][0-9_]*|[.,])+(?:[eE][-+]?[0-9]+)?(?![A-Za-z0-9_\x80-\xff])"
_DATE = rb"[0-9]{1,9}(?:T[0-9]{0,9}Z?|Z)(?![A-Za-z0-9_\x80-\xff])"
_WORD = rb"[A-Za-z0-9_\x80-\xff]+"
_TOKEN = re.compile(b"(?:%b|%b)|(%b)" % (_NUMBER, _DATE, _WORD))
_WORDS = re.compile(_WORD)
# What a word is made of, by its case: Left, Foot and X of LeftFootX.
_PARTS = re.compile(rb"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[\x80-\xff]+")
# No vowels, so that no word of a language comes out.
_LETTERS = b"nbcdfghjklmpqrstvwxz"
_ALL_LETTERS = b"nbcdfghjklmpqrstvwxzaeiouy0123456789_"
_LEAST_SWEPT, _MOST_SWEPT = 5, 10**10
# Numbers that are words, and truth.
_VALUES = frozenset((b"nan", b"inf", b"infinity", b"true", b"false", b"null", b"none"))


class StandIns:
    """Which word stands for which name.

    Parameters
    ----------
    keep : frozenset of bytes
        Words in lower case that stay wherever they stand.

    Attributes
    ----------
    of : dict
        The stand-in of each name that was met.
    stayed : set of bytes
        The words that were met and stay.
    """

    def __init__(self, keep: frozenset[bytes] = frozenset()) -> None:
        self.of: dict[bytes, bytes] = {}
        self.stayed: set[bytes] = set()
        self._keep = keep | _VALUES
        self._bases: dict[bytes, bytes] = {}
        self._taken: set[bytes] = set()
        self._free: dict[int, Iterator[bytes]] = {}

    def __getitem__(self, name: bytes) -> bytes:
        r"""Return what stands for a name, of the same length in bytes; names that differ in case do so afterwards.

        Examples
        --------
        >>> names = StandIns()
        >>> names[b"LeftFoot"], names[b"LeftLegs"], names[b"LeftFoot"]
        (b'Nnnnnnnn', b'Nnnnnnnb', b'Nnnnnnnn')
        >>> names[b"leftFOOT"], names[b"LEFTFOOT"], names["größe".encode()].decode()
        (b'nnnnnnnn', b'NNNNNNNN', 'Ąnbbbb')
        """
        found = self.of.get(name)
        if found is None:
            # A program may not care for case: LEFTFOOT is LeftFoot then.
            plain = name.lower()
            if plain not in self._bases:
                self._bases[plain] = self._next(plain)
            found = _in_case_of(name, self._bases[plain])
            if found in self._taken:
                # Names that differ only in the case of some letter inside.
                found = _in_case_of(name, self._next(plain))
            self.of[name] = found
            self._taken.add(found)
            self.of |= dict(_as_shown(name, found))
        return found

    def keeps(self, word: bytes) -> bool:
        """Tell whether a word stays wherever it stands."""
        return word.lower() in self._keep

    def in_words(self, text: bytes, known: frozenset[bytes] = frozenset(), *, by_parts: bool = False) -> bytes:
        """Replace the words of a text, but for those that are `known` (in lower case) and those that are kept.

        With `by_parts` known parts of a word stay too, as the "deg" of ``Ann_deg``, and the "X" of ``AnnX``.
        """
        stays = self._keep | known

        def one(match: re.Match[bytes]) -> bytes:
            word = match[1]
            if word is not None and word.lower() not in stays:
                return self._in_parts(word, stays) if by_parts else self[word]
            if word is not None:
                self.stayed.add(word)
            return match[0]

        return _TOKEN.sub(one, text)

    def in_name(self, text: bytes) -> bytes:
        """Replace every word of a name, numbers too."""
        return self._exchanged(text, lambda word: word if word.lower() in self._keep else self[word])

    def _in_parts(self, word: bytes, stays: frozenset[bytes]) -> bytes:
        def one(match: re.Match[bytes]) -> bytes:
            part = match[0]
            if part.lower() in stays:
                self.stayed.add(part)
                return part
            return self[part]

        # A message quotes the whole of it.
        return self.of.setdefault(word, _PARTS.sub(one, word))

    def swept(self, data: bytes) -> bytes:
        """Replace names that were met wherever else they stand, in the middle of numbers too."""
        # Shorter ones may be numbers by chance; and nobody should wait for it.
        long = [name for name in self.of if len(name) >= _LEAST_SWEPT]
        if len(long) * len(data) > _MOST_SWEPT:
            return data
        for name in sorted(long, key=len, reverse=True):
            if name in data:
                data = data.replace(name, self.of[name])
        return data

    def met_in(self, text: str) -> str:
        """Replace the words of a text that were met before, as in a message or an option."""
        return self._exchanged(text.encode(), lambda word: self.of.get(word, word)).decode("utf-8", "replace")

    @staticmethod
    def _exchanged(text: bytes, exchange: Callable[[bytes], bytes]) -> bytes:
        return _WORDS.sub(lambda match: exchange(match[0]), text)

    def _next(self, name: bytes) -> bytes:
        size = len(name)
        wide = _beyond_ascii(name)
        if wide:
            return wide(len(self.of))
        return next(self._free.setdefault(size, _of_size(size)))


def _as_shown(name: bytes, stand_in: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Pair the words that messages have for a name that is no UTF-8: decoded otherwise, or its bytes written out."""
    try:
        name.decode()
    except UnicodeDecodeError:
        for encoding, errors in (("cp1252", "replace"), ("latin-1", "strict"), ("utf-8", "backslashreplace")):
            ours, theirs = (_WORDS.findall(one.decode(encoding, errors).encode()) for one in (name, stand_in))
            if len(ours) == len(theirs):
                yield from zip(ours, theirs, strict=True)


def _in_case_of(name: bytes, base: bytes) -> bytes:
    return base.upper() if name.isupper() else base.capitalize() if name[:1].isupper() else base


def _of_size(size: int) -> Iterator[bytes]:
    """Count up the stand-ins of a length."""
    for letters in (_LETTERS, _ALL_LETTERS):
        yield from (bytes(parts) for parts in itertools.product(letters, repeat=size))
    # More names of one or two letters than there are letters: from here on they share.
    yield from itertools.repeat(b"n" * size)


class _Wide:
    """Stand-ins of a name with letters beyond ASCII: the first of them counts, so that encodings are met as before."""

    # For letters of so many bytes the first of a block, and how many letters that has.
    _BLOCKS: ClassVar = {2: (0x100, 0x180), 3: (0x4E00, 0x5000), 4: (0x20000, 0xA000)}

    def __init__(self, size: int, letter_bytes: int, undecodable: bytes) -> None:
        self.size, self.letter_bytes, self.undecodable = size, letter_bytes, undecodable

    def __call__(self, k: int) -> bytes:
        if self.undecodable:
            # No UTF-8: the byte that shows it stays, and letters count.
            rest = self.size - len(self.undecodable)
            counted = bytearray(b"n" * rest)
            for place in reversed(range(rest)):
                k, digit = divmod(k, len(_LETTERS))
                counted[place] = _LETTERS[digit]
            return self.undecodable + bytes(counted)
        first, count = self._BLOCKS[self.letter_bytes]
        letter = chr(first + k % count).encode()
        rest = self.size - len(letter)
        return letter + b"n" * (rest > 0) + b"b" * (rest - 1)


def _beyond_ascii(name: bytes) -> _Wide | None:
    if name.isascii():
        return None
    try:
        letters = name.decode("utf-8")
    except UnicodeDecodeError as error:
        return _Wide(len(name), 0, name[error.start : error.start + 1])
    wide = next(len(letter.encode()) for letter in letters if not letter.isascii())
    return _Wide(len(name), wide, b"")


def alike(original: str, stripped: str, stand_ins: Mapping[bytes, bytes], *, numbers_too: bool = True) -> bool:
    """Tell whether two messages are the same but for names and their stand-ins (which may be cut short in a message).

    Parameters
    ----------
    original, stripped : str
        A message about the file, and one about the file without names.
    stand_ins : mapping of bytes to bytes
        What was replaced by what.
    numbers_too : bool
        Whether numbers must agree; they don't where frames were left out.
    """
    ours, theirs = (re.split(rb"([A-Za-z0-9_\x80-\xff]+)", text.encode()) for text in (original, stripped))
    if len(ours) != len(theirs):
        return False
    for index, (a, b) in enumerate(zip(ours, theirs, strict=True)):
        if a == b or (index % 2 and stand_ins.get(a) == b):
            continue
        if index % 2 and not numbers_too and a.isdigit() and b.isdigit():
            continue
        if index % 2 and any(
            name.startswith(a) and stand_in.startswith(b) for name, stand_in in stand_ins.items() if len(a) >= 3
        ):
            continue
        return False
    return True

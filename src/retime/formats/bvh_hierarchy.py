"""The HIERARCHY section of a BVH file, parsed without recursion and within limits.

The section is read token by token, so that braces may stand on lines of their own or not; only a joint's name takes
the rest of its line, since names hold spaces.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NoReturn

from retime.errors import FormatError
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_text import NumberTextError, parse_count, parse_number, show
from retime.formats.read_options import ReadOptions
from retime.formats.text_lines import Lines
from retime.motion.skeleton import EndSite

CHANNELS = ("Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation")
_CANONICAL = {name.lower().encode(): name for name in CHANNELS}
_CHANNEL_LIKE = re.compile(rb"[a-z]+(?:position|rotation|scale)", re.IGNORECASE)

Offset = tuple[float, float, float]


@dataclass(frozen=True)
class Hierarchy:
    """What the HIERARCHY section says.

    Attributes
    ----------
    names : tuple of str
        Joint names in file order.
    parents : tuple of int
        Each joint's parent, -1 for the root.
    offsets : tuple of (float, float, float)
        Each joint's OFFSET.
    channels : tuple of tuple of str
        Each joint's CHANNELS, spelt as in `CHANNELS` above.
    end_sites : tuple of EndSite
        End sites in file order.
    encoding : str
        How the names are written: "utf-8" or "latin-1".
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[Offset, ...]
    channels: tuple[tuple[str, ...], ...]
    end_sites: tuple[EndSite, ...]
    encoding: str

    def column(self, index: int) -> str:
        """Describe a value of a frame by its joint and channel, for messages."""
        for name, channels in zip(self.names, self.channels, strict=True):
            if index < len(channels):
                return f"joint {name!r}, {channels[index]}"
            index -= len(channels)
        return "past the last channel"


@dataclass
class _Block:
    """A joint, or an end site, whose closing brace has not come yet."""

    joint: int
    is_end_site: bool
    line: int
    offset: Offset | None = None
    channels: tuple[str, ...] | None = None


class _Parser:
    def __init__(self, lines: Lines, options: ReadOptions) -> None:
        self.lines = lines
        self.limits = options.limits
        self.decimal_comma = options.decimal_comma
        self.open: list[_Block] = []
        self.names: list[bytes] = []
        self.parents: list[int] = []
        self.offsets: list[Offset] = []
        self.channels: list[tuple[str, ...]] = []
        self.n_channels = 0
        self.end_sites: list[EndSite] = []
        self.root_line = 0

    def parse(self) -> Hierarchy:
        self._heading()
        while True:
            token = self.lines.token()
            if token is None:
                self._fail(f"expected {self._expected()}, found the end of the file")
            word = token.lower()
            if word == b"motion" and self.open:
                self._fail(f"expected {self._expected()}, found MOTION with {self._open_braces()}")
            if word == b"motion" and self.names:
                return self._result()
            if word == b"}":
                self._close()
            elif word == b"root":
                self._root()
            elif self.open and self.open[-1].is_end_site and word != b"offset":
                self._fail(f"expected {self._expected()}, found {show(token)}")
            elif word == b"joint" and self.open:
                self._joint("JOINT", self.open[-1].joint)
            elif word == b"end" and self.open:
                self._end_site()
            elif word == b"offset" and self.open:
                self._offset()
            elif word == b"channels" and self.open:
                self._channels()
            else:
                self._fail(f"expected {self._expected()}, found {show(token)}")

    def _heading(self) -> None:
        token = self.lines.token()
        if token is None:
            raise FormatError("empty; expected HIERARCHY", path=self.lines.path)
        if token.lower() != b"hierarchy":
            kind = foreign_kind(self.lines.data)
            self.lines.fail(f"expected HIERARCHY, found {kind or show(token)}")

    def _expected(self) -> str:
        if not self.names:
            return "ROOT"
        if not self.open:
            return "MOTION"
        block = self.open[-1]
        if block.offset is None:
            return "OFFSET"
        if block.is_end_site:
            return "'}'"
        return "CHANNELS" if block.channels is None else "JOINT, End Site or '}'"

    def _fail(self, problem: str, *, line: int | None = None, column: int | None = None) -> NoReturn:
        """Fail, and where the file ends here say which braces are open: it was probably cut."""
        if self.open and self.lines.at_end():
            problem = f"{problem}; the file ends here with {self._open_braces()}"
        self.lines.fail(problem, line=line, column=column)

    def _open_braces(self) -> str:
        # The innermost ones tell the place; all those of a deep file would fill a screen.
        shown = [f"{self._label(block)} (line {block.line})" for block in self.open[-4:]]
        more = ["..."] if len(self.open) > 4 else []
        plural = "s" if len(self.open) > 1 else ""
        return f"{len(self.open)} brace{plural} open: {', '.join(more + shown)}"

    def _label(self, block: _Block) -> str:
        name = show(self.names[block.joint])
        if block.is_end_site:
            return f"the End Site of {name}"
        return f"ROOT {name}" if block.joint == 0 else f"JOINT {name}"

    def _root(self) -> None:
        line = self.lines.number
        if self.names:
            self._fail(
                f"a second ROOT, {show(self.lines.rest())}: a motion has one (the first is {show(self.names[0])} "
                f"on line {self.root_line})",
                line=line,
            )
        self.root_line = line
        self._joint("ROOT", -1)

    def _joint(self, keyword: str, parent: int) -> None:
        line = self.lines.number
        rest = self.lines.rest()
        following = self.lines.token()
        if following == b"{":
            name = rest
        else:
            if following is not None:
                self.lines.put_back(following)
            if not rest.endswith(b"{"):
                found = "the end of the file" if following is None else show(following)
                self._fail(f"expected '{{' after {keyword} {show(rest)}, found {found}")
            name = rest[:-1].rstrip()
        if not name:
            self._fail(f"expected a name after {keyword}", line=line)
        if len(name) > self.limits.name_bytes:
            self._fail(
                f"the name {show(name)} has {len(name)} bytes, the limit is {self.limits.name_bytes} "
                "(Limits.name_bytes)",
                line=line,
            )
        if len(self.names) >= self.limits.joints:
            self._fail(
                f"joint {show(name)} is one too many; the limit is {self.limits.joints} (Limits.joints)", line=line
            )
        if len(self.open) >= self.limits.depth:
            self._fail(f"joint {show(name)} lies too deep; the limit is {self.limits.depth} (Limits.depth)", line=line)
        self.open.append(_Block(len(self.names), False, line))
        self.names.append(name)
        self.parents.append(parent)
        self.offsets.append((0.0, 0.0, 0.0))
        self.channels.append(())

    def _end_site(self) -> None:
        line = self.lines.number
        # Usually "End Site". Some programs name their end sites, with or without the word Site (End Toe_End); nothing
        # refers to the name.
        word = self.lines.token_on_line()
        while word is not None and not word.endswith(b"{"):
            word = self.lines.token_on_line()
        if word is None:
            following = self.lines.token()
            if following != b"{":
                found = "the end of the file" if following is None else show(following)
                self._fail(f"expected '{{' after End Site, found {found}")
        if len(self.end_sites) >= self.limits.joints:
            self._fail(f"an End Site too many; the limit is {self.limits.joints} (Limits.joints)", line=line)
        self.open.append(_Block(self.open[-1].joint, True, line))

    def _close(self) -> None:
        if not self.open:
            closed = "every joint is closed already" if self.names else "no joint is open yet"
            self._fail(f"a '}}' too many: {closed}")
        block = self.open[-1]
        if block.offset is None:
            self._fail(f"{self._label(block)} (line {block.line}) ends without an OFFSET")
        if block.is_end_site:
            self.end_sites.append(EndSite(block.joint, block.offset))
        elif block.channels is None:
            self._fail(
                f"{self._label(block)} (line {block.line}) ends without CHANNELS (a joint that has none says "
                "CHANNELS 0)"
            )
        else:
            self.offsets[block.joint] = block.offset
            self.channels[block.joint] = block.channels
        self.open.pop()

    def _tokens_on_line(self, most: int) -> list[bytes]:
        """Take tokens of this line up to a brace, and no more than `most`."""
        tokens: list[bytes] = []
        while len(tokens) < most and (token := self.lines.token_on_line()) is not None:
            if token in (b"{", b"}"):
                self.lines.put_back(token)
                break
            tokens.append(token)
        return tokens

    def _offset(self) -> None:
        block = self.open[-1]
        if block.offset is not None:
            self._fail(f"a second OFFSET of {self._label(block)}")
        values: list[float] = []
        while len(values) < 4 and (token := self.lines.token_on_line()) is not None:
            if token == b"}":
                self.lines.put_back(token)
                break
            try:
                values.append(parse_number(token, decimal_comma=self.decimal_comma))
            except NumberTextError as error:
                self._fail(f"OFFSET of {self._label(block)}: {error.problem}", column=self.lines.column_of(token))
        if len(values) != 3:
            found = "more" if len(values) > 3 else str(len(values))
            self._fail(f"OFFSET of {self._label(block)}: expected 3 values, found {found}")
        block.offset = (values[0], values[1], values[2])

    def _channels(self) -> None:
        block = self.open[-1]
        label = self._label(block)
        line = self.lines.number
        if block.channels is not None:
            self._fail(f"a second CHANNELS of {label}")
        if len(self.names) - 1 > block.joint:
            self._fail(
                f"CHANNELS of {label} after its child JOINT {show(self.names[block.joint + 1])}: it is unclear "
                "where its values stand in a frame; expected CHANNELS before the first JOINT"
            )
        count = self._channel_count(label)
        found = self._tokens_on_line(count + 1)
        while len(found) < count:
            following = self.lines.token()
            if following is None:
                break
            self.lines.put_back(following)
            if not _CHANNEL_LIKE.fullmatch(following):
                break
            found += self._tokens_on_line(count + 1 - len(found))
        names: list[str] = []
        for token in found:
            name = _CANONICAL.get(token.lower())
            if name is None:
                self._fail(f"unknown channel {show(token)} of {label}; allowed are {', '.join(CHANNELS)}", line=line)
            if name in names:
                self._fail(f"CHANNELS of {label} names {name} twice", line=line)
            names.append(name)
        if len(names) != count:
            named = "more" if len(names) > count else str(len(names))
            self._fail(f"CHANNELS of {label} declares {count} channels, but names {named}", line=line)
        self.n_channels += count
        if self.n_channels > self.limits.channels:
            self._fail(
                f"{self.n_channels} channels up to here, the limit is {self.limits.channels} (Limits.channels)",
                line=line,
            )
        block.channels = tuple(names)

    def _channel_count(self, label: str) -> int:
        token = self.lines.token_on_line()
        if token is None:
            self._fail(f"CHANNELS of {label}: expected a count, found the end of the line")
        try:
            count = parse_count(token)
        except NumberTextError as error:
            self._fail(f"CHANNELS of {label}: {error.problem}")
        if count > self.limits.joint_channels:
            self._fail(
                f"{label} declares {show(token)} channels, the limit is {self.limits.joint_channels} "
                "(Limits.joint_channels)"
            )
        return count

    def _result(self) -> Hierarchy:
        encoding = "utf-8"
        try:
            names = [name.decode("utf-8") for name in self.names]
        except UnicodeDecodeError:
            # Latin-1 gives every byte a character, so that the names can be written back as they were.
            encoding = "latin-1"
            names = [name.decode("latin-1") for name in self.names]
        return Hierarchy(
            tuple(names),
            tuple(self.parents),
            tuple(self.offsets),
            tuple(self.channels),
            tuple(self.end_sites),
            encoding,
        )


def parse_hierarchy(lines: Lines, options: ReadOptions) -> Hierarchy:
    """Parse a file's beginning up to and with the word MOTION.

    Raises
    ------
    FormatError
        With the line, what was expected and what was found; a file that ends too early also gets its open braces.
    """
    return _Parser(lines, options).parse()

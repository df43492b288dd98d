"""XML from strangers: no entity is expanded, no other file is opened, size and depth are bounded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from retime.errors import FormatError

_MOST_ELEMENTS, _MOST_DEPTH = 4_000_000, 100


@dataclass
class Element:
    """An element of a document.

    Attributes
    ----------
    tag : str
        Its name.
    line : int
        Where it begins.
    attributes : dict of str to str
        As written, entities of XML itself resolved.
    children : list of Element
        The elements in it.
    text : str
        The letters directly in it.
    """

    tag: str
    line: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """Go through the elements of a name, at any depth, in the order of the document."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            if element.tag == tag:
                yield element
            waiting += reversed(element.children)

    def child(self, tag: str) -> Element | None:
        """Return the first child of a name."""
        return next((child for child in self.children if child.tag == tag), None)


def parse_xml(data: bytes) -> Element:
    """Parse a document.

    Raises
    ------
    FormatError
        Not XML, an entity or a document type of its own, or more than the bounds allow; says where.
    """
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    top = Element("", 0, {})
    path = [top]
    count = 0

    def refuse(what: str) -> None:
        raise FormatError(what, line=parser.CurrentLineNumber, column=parser.CurrentColumnNumber + 1)

    def doctype(name: str, system: str | None, public: str | None, internal: bool) -> None:
        if internal:
            refuse(
                "the document declares types or entities of its own, which are not read; remove them from <!DOCTYPE>"
            )

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > _MOST_ELEMENTS or len(path) > _MOST_DEPTH:
            refuse(f"more than {_MOST_ELEMENTS} elements, or {_MOST_DEPTH} inside each other")
        element = Element(tag, parser.CurrentLineNumber, attributes)
        path[-1].children.append(element)
        path.append(element)

    def end(tag: str) -> None:
        path.pop()

    def letters(text: str) -> None:
        path[-1].text += text

    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CharacterDataHandler = letters
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise FormatError(
            f"not XML: {expat.errors.messages[error.code]}", line=error.lineno, column=error.offset + 1
        ) from None
    except (LookupError, ValueError) as error:
        # Of an encoding that Python does not know.
        raise FormatError(f"not XML: {error}") from None
    return top.children[0]


def attribute(text: str) -> str:
    """Write a value of an attribute, with its quotes."""
    return quoteattr(text)


def letters(text: str) -> str:
    """Write what stands between tags."""
    return escape(text)

"""Make the page's message types from src/retime/server/messages.py: ``python tools/make_messages.py``."""

from __future__ import annotations

import dataclasses
import inspect
import types
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints, is_typeddict

from retime.search.options import BY_NAME
from retime.server import messages
from retime.server.message_coding import array_fields, type_name

PAGE = Path(__file__).resolve().parents[1] / "web" / "src" / "messages.ts"

INTRODUCTION = """\
// The messages between the page and its server. Made by tools/make_messages.py from src/retime/server/messages.py,
// which tells what each of them means; a test compares. Times are seconds.
"""

ARRAYS = {"<f8": "Float64Array", "<f4": "Float32Array", "<i4": "Int32Array", "|u1": "Uint8Array"}
PLAIN = {bool: "boolean", int: "number", float: "number", str: "string", type(None): "null"}

DECODE = """\
interface ArrayPlace {
  readonly name: string;
  readonly dtype: keyof typeof ARRAY_TYPES;
  readonly shape: readonly number[];
  readonly offset: number;
}

const ARRAY_TYPES = {
%s
} as const;

/** Read a binary frame: its arrays are views of the frame's own bytes. */
export function readArrays(frame: ArrayBuffer): ArrayMessage {
  const headerBytes = new DataView(frame).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(frame, 4, headerBytes));
  const { arrays, ...message } = JSON.parse(text) as { arrays: ArrayPlace[] } & Record<string, unknown>;
  for (const { name, dtype, shape, offset } of arrays) {
    const length = shape.reduce((product, size) => product * size, 1);
    message[name] = new ARRAY_TYPES[dtype](frame, 4 + headerBytes + offset, length);
  }
  return message as unknown as ArrayMessage;
}
"""


def script_type(hint: Any) -> str:
    """Return the TypeScript type of a Python one."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return " | ".join(script_type(choice) for choice in inner)
    if origin is Literal:
        return " | ".join(f'"{choice}"' for choice in inner)
    if origin is tuple and inner[-1] is Ellipsis:
        one = script_type(inner[0])
        return f"readonly ({one})[]" if "|" in one else f"readonly {one}[]"
    if dataclasses.is_dataclass(hint) or is_typeddict(hint):
        return hint.__name__  # type: ignore[union-attr]
    return PLAIN[hint]


def interface(kind: type, *, message: bool) -> str:
    """Return the interface of a dataclass, with the first line of its docstring."""
    said = (inspect.getdoc(kind) or "").splitlines()[0]
    lines = [f"/** {said} */", f"export interface {kind.__name__} {{"]
    if message:
        lines.append(f'  readonly type: "{type_name(kind)}";')
    arrays, hints = array_fields(kind), get_type_hints(kind)
    for name, hint in hints.items():
        lines.append(f"  readonly {name}: {ARRAYS[arrays[name]] if name in arrays else script_type(hint)};")
    return "\n".join([*lines, "}"]) + "\n"


def given(kind: type) -> str:
    """Return the interface of options, of which any may be left out."""
    lines = ["/** The options of the search that were given. */", f"export interface {kind.__name__} {{"]
    for name, hint in get_type_hints(kind).items():
        lines.append(f"  /** {BY_NAME[name].hint}. */")
        lines.append(f"  readonly {name}?: {script_type(hint)};")
    return "\n".join([*lines, "}"]) + "\n"


def documents() -> list[type]:
    """List the dataclasses that messages hold, and the options, each after those that it holds itself."""
    found: list[type] = []

    def visit(hint: Any) -> None:
        for inner in get_args(hint):
            visit(inner)
        if (dataclasses.is_dataclass(hint) or is_typeddict(hint)) and hint not in found:
            for field in get_type_hints(hint).values():
                visit(field)
            found.append(hint)  # type: ignore[arg-type]

    for kind in (*messages.FROM_PAGE, *messages.FROM_SERVER):
        for hint in get_type_hints(kind).values():
            visit(hint)
    return found


def union(name: str, kinds: tuple[type, ...]) -> str:
    """Return a union of messages."""
    return f"export type {name} =\n" + "\n".join(f"  | {kind.__name__}" for kind in kinds) + ";\n"


def page() -> str:
    """Return the page's module."""
    bits = ", ".join(f'"{word}"' for word in messages.BINDINGS)
    parts = [
        INTRODUCTION,
        f"export const VERSION = {messages.VERSION};\n",
        f"/** The bits of Why.binding, the lowest first. */\nexport const BINDINGS = [{bits}] as const;\n",
        *(given(kind) if is_typeddict(kind) else interface(kind, message=False) for kind in documents()),
        "// From the page to the server.\n",
        *(interface(kind, message=True) for kind in messages.FROM_PAGE),
        union("PageMessage", messages.FROM_PAGE),
        "// From the server to the page.\n",
        *(interface(kind, message=True) for kind in (*messages.FROM_SERVER, *messages.FROM_SERVER_WITH_ARRAYS)),
        union("TextMessage", messages.FROM_SERVER),
        "/** Travels as one binary frame. */\n" + union("ArrayMessage", messages.FROM_SERVER_WITH_ARRAYS),
        "export type ServerMessage = TextMessage | ArrayMessage;\n",
        DECODE % "\n".join(f'  "{dtype}": {name},' for dtype, name in ARRAYS.items()),
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8")

"""Make the fields of the page from src/retime/search/options.py: ``python tools/make_options.py``."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, get_args

from retime.search.options import OPTIONS, Kind, Method, Option, Panel

PAGE = Path(__file__).resolve().parents[1] / "web" / "src" / "options.ts"

INTRODUCTION = """\
// The options of the search, as the page shows them. Made by tools/make_options.py from src/retime/search/options.py,
// which tells what each field of a declaration means; a test compares.

import type {{ Options }} from "./messages";

export type OptionName = keyof Options;
export type OptionKind = {kinds};
export type OptionPanel = {panels};
export type OptionMethod = {methods};

export interface Option {{
  readonly name: OptionName;
  readonly kind: OptionKind;
  /** What holds where nothing is given; null: what `usual` says. */
  readonly default: string | number | boolean | null;
  readonly usual: string;
  /** The same for an empty field, which has less room. */
  readonly inShort: string;
  readonly label: string;
  readonly hint: string;
  /** On the command line. */
  readonly flag: string;
  readonly panel: OptionPanel;
  readonly unit: string;
  /** Bounds of a number, included; null: none. */
  readonly least: number | null;
  readonly most: number | null;
  /** From 0 to the first number, in steps of the second; null: a field. */
  readonly slider: readonly [number, number] | null;
  readonly curve: "straight" | "square";
  readonly choices: readonly {{ readonly value: string; readonly label: string }}[];
  /** Whether it says something only where the length is free. */
  readonly needsFree: boolean;
  /** Where it says something: for which methods, and "hand" where an example is carried over. */
  readonly methods: readonly OptionMethod[];
}}

export const OPTIONS: readonly Option[] = [
"""


def shown(option: Option) -> dict[str, Any]:
    """Return what the page knows of an option."""
    return {
        "name": option.name,
        "kind": option.kind,
        "default": option.default,
        "usual": option.default_words,
        "inShort": option.in_short or option.default_words,
        "label": option.label,
        "hint": option.hint,
        "flag": option.on_command_line,
        "panel": option.panel,
        "unit": option.unit,
        "least": option.least if math.isfinite(option.least) else None,
        "most": option.most if math.isfinite(option.most) else None,
        "slider": option.slider,
        "curve": option.curve,
        "choices": [{"value": choice.value, "label": choice.label} for choice in option.choices],
        "needsFree": option.needs_free,
        "methods": list(option.methods),
    }


def page() -> str:
    """Return the page's module."""
    kinds, panels, methods = (" | ".join(f'"{word}"' for word in get_args(words)) for words in (Kind, Panel, Method))
    lines = [INTRODUCTION.format(kinds=kinds, panels=panels, methods=methods).rstrip("\n")]
    for option in OPTIONS:
        lines.append("  {")
        lines += [f"    {name}: {json.dumps(value, ensure_ascii=False)}," for name, value in shown(option).items()]
        lines.append("  },")
    return "\n".join([*lines, "];"]) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")

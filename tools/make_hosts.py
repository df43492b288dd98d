"""Make the hosts of the page from src/retime/hosts/registry.py: ``python tools/make_hosts.py``."""

from __future__ import annotations

import json
from pathlib import Path

from retime.hosts.registry import HOSTS

PAGE = Path(__file__).resolve().parents[1] / "web" / "src" / "hosts.ts"

INTRODUCTION = """\
// The programs that a warp can be written for, as the page shows them. Made by tools/make_hosts.py from
// src/retime/hosts/registry.py; a test compares.

export interface Host {
  readonly name: string;
  readonly title: string;
  /** Endings of its files, the usual one first. */
  readonly suffixes: readonly string[];
  /** The number that it gives a shot's first frame; null: it counts from the beginning of its clip. */
  readonly firstFrame: number | null;
  /** Whether it does with fewer keys where an error is allowed. */
  readonly thins: boolean;
  /** What can be named in it; empty: nothing. */
  readonly item: string;
}

export const HOSTS: readonly Host[] = [
"""


def page() -> str:
    """Return the page's module."""
    lines = [INTRODUCTION.rstrip("\n")]
    for host in HOSTS:
        shown = {
            "name": host.name,
            "title": host.title,
            "suffixes": list(host.suffixes),
            "firstFrame": host.first_frame,
            "thins": not host.every_frame,
            "item": host.takes_item,
        }
        lines.append("  {")
        lines += [f"    {name}: {json.dumps(value, ensure_ascii=False)}," for name, value in shown.items()]
        lines.append("  },")
    return "\n".join([*lines, "];"]) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")

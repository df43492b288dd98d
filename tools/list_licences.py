"""Write THIRD_PARTY.md: whose work is in the wheels, with its licence, and what else is needed, by whose licence.

Usage: python tools/list_licences.py [PYTHON]

PYTHON is an environment that has all extras (``make licences`` names .venv/extras). The parts inside the wheels are
read from this environment (nanobind) and from web/node_modules (three.js); what stands in the lock of the page and is
no tool of development must be among them.
"""

from __future__ import annotations

import importlib.metadata
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "THIRD_PARTY.md"

# What an environment says of its packages: by name the licence, and what each needs.
_ASK = """
import importlib.metadata, json
found = {}
for one in importlib.metadata.distributions():
    data = one.metadata
    kinds = [line.rpartition(" :: ")[2] for line in data.get_all("Classifier") or () if line.startswith("License ::")]
    found[data["Name"]] = [data.get("License-Expression") or "", data.get("License") or "", kinds, one.requires or []]
print(json.dumps(found))
"""
# What the metadata does not say, or not all of it; read in the package itself.
_SAID = {
    "python-stretch": "MIT",
    "av": "BSD-3-Clause; its wheels carry FFmpeg (LGPL) and x264, x265 (GPL)",
    "opencv-python-headless": "Apache-2.0; its wheels carry FFmpeg (LGPL)",
    "usd-core": "TOST-1.0 (Tomorrow Open Source Technology)",
    "soxr": "LGPL-2.1-or-later",
}
_HEAD = """\
# Work of others

Made by `tools/list_licences.py` (`make licences`); a test compares with what is needed and what is locked. retime
itself is under the MIT licence.

## What retime needs

Nothing of these is in retime's files: pip fetches them. What an extra needs, needs more in turn; all of it is listed,
each where it is needed first. Licences are those that the packages say of themselves.

| package | needed for | licence |
| :-- | :-- | :-- |
{rows}

## What is inside the wheels

| part | where | licence |
| :-- | :-- | :-- |
| three.js | the editor's page, `retime/server/page` | MIT |
| nanobind | the compiled kernels | BSD-3-Clause |
| robin-map, in nanobind | the compiled kernels | MIT |
"""


def locked_of_page() -> list[str]:
    """Name the packages that the editor's page is bundled of, as its lock has them."""
    lock = json.loads((ROOT / "web" / "package-lock.json").read_text(encoding="utf-8"))
    return [
        name.rpartition("node_modules/")[2] for name, one in lock["packages"].items() if name and not one.get("dev")
    ]


def needed() -> dict[str, list[str]]:
    """Name what pyproject.toml asks for, by extra; "" is what is always needed."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = {"": project["dependencies"], **project["optional-dependencies"]}
    return {extra: [_name(one) for one in names] for extra, names in asked.items()}


def closure(asked: dict[str, list[str]], packages: dict[str, Any]) -> dict[str, str]:
    """Say of each package that is needed, directly or not, for which extra it is needed first."""
    by_name = {_plain(name): name for name in packages}
    found: dict[str, str] = {}
    for extra, names in asked.items():
        waiting = list(names)
        while waiting:
            name = by_name.get(_plain(waiting.pop(0)))
            if name is None or name in found:
                continue
            found[name] = extra
            # What a package's own extras need, retime does not ask for.
            waiting += [_name(one) for one in packages[name][3] if "extra ==" not in one]
    return found


def licence_of(name: str, packages: dict[str, Any]) -> str:
    """Say by which licence a package is; raise ValueError where it doesn't say."""
    expression, text, kinds, _ = packages[name]
    short = text.strip().splitlines()[0] if text.strip() else ""
    # Some put the whole text there, or nothing.
    is_name = len(short) <= 60 and not re.search(r"copyright|agreement|unknown|===", short, re.IGNORECASE)
    said = _SAID.get(name) or expression or (short if is_name else "") or ", ".join(kinds)
    if not said:
        raise ValueError(f"{name} does not say its licence: look, and add it to this script")
    return said


def _name(requirement: str) -> str:
    match = re.match(r"[A-Za-z0-9._-]+", requirement)
    assert match is not None
    return match[0]


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def rows(python: str) -> list[str]:
    """Return the table's rows, for the packages of an environment."""
    packages = json.loads(subprocess.run([python, "-c", _ASK], capture_output=True, text=True, check=True).stdout)
    found = closure(needed(), packages)
    missing = {name for names in needed().values() for name in names} - {_plain(name) for name in found}
    if missing:
        raise ValueError(f"{python} lacks {', '.join(sorted(missing))}: make extras")
    order = list(needed())
    return [
        f"| {name} | {f'`{found[name]}`' if found[name] else 'everything'} | {licence_of(name, packages)} |"
        for name in sorted(found, key=lambda name: (order.index(found[name]), name.lower()))
    ]


def texts() -> dict[str, str]:
    """Return the licences of what is inside the wheels."""
    nanobind = importlib.metadata.distribution("nanobind")
    [licence] = [file for file in nanobind.files or () if file.name == "LICENSE"]
    header = Path(str(nanobind.locate_file("nanobind/ext/robin_map/include/tsl/robin_hash.h"))).read_text("utf-8")
    robin = re.match(r"/\*\*\n(.*?)\*/", header, re.DOTALL)
    assert robin is not None
    return {
        "three.js": (ROOT / "web" / "node_modules" / "three" / "LICENSE").read_text(encoding="utf-8"),
        "nanobind": licence.read_text(encoding="utf-8"),
        "robin-map": re.sub(r"^ \* ?", "", robin[1], flags=re.MULTILINE),
    }


def page(python: str) -> str:
    """Return the page."""
    if locked_of_page() != ["three"]:
        raise ValueError(f"the page is made of {', '.join(locked_of_page())}: say so here, with each licence")
    parts = [_HEAD.format(rows="\n".join(rows(python)))]
    parts += [f"### {name}\n\n```text\n{text.strip()}\n```\n" for name, text in texts().items()]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(sys.argv[1] if len(sys.argv) > 1 else sys.executable), encoding="utf-8")

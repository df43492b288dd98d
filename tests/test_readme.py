"""The README's commands run, one after another, in an empty folder, as a reader would type them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"

# These fetch or set up the project itself, which the run of the tests has done already.
SETS_UP = ("git clone", "cd ", "pip install", "python -m pip install", "python -m venv", "python3 -m venv", "make")


class Command(NamedTuple):
    """A command and where the page shows it."""

    line: int
    text: str


def commands_of(page: str) -> list[Command]:
    """Collect the commands of a page: lines that begin with "$ " in its console and sh blocks."""
    commands: list[Command] = []
    inside, continued = False, False
    for number, line in enumerate(page.splitlines(), start=1):
        if line.startswith("```"):
            inside, continued = line.strip() in ("```console", "```sh"), False
        elif inside and continued:
            commands[-1] = commands[-1]._replace(text=f"{commands[-1].text}\n{line}")
            continued = line.endswith("\\")
        elif inside and line.startswith("$ "):
            commands.append(Command(number, line[2:]))
            continued = line.endswith("\\")
    return commands


@pytest.fixture(scope="module")
def commands() -> list[Command]:
    if not README.is_file():
        pytest.skip("there is no README.md")
    return commands_of(README.read_text(encoding="utf-8"))


def test_commands_are_found_with_their_lines() -> None:
    page = (
        "# A\n$ no\n```console\n$ one --flag\nout\n$ two \\\n  more\nout\n```\n```py\n$ no\n```\n```sh\n$ three\n```\n"
    )
    assert commands_of(page) == [(4, "one --flag"), (6, "two \\\n  more"), (14, "three")]


def test_readme_shows_commands(commands) -> None:
    assert commands, "README.md shows no command: lines that begin with '$ ' in ```console or ```sh blocks"


def test_commands_that_set_up_name_what_is_there(commands) -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    extras = set(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"])
    for line, text in commands:
        if text.startswith("make"):
            missing = {word for word in text.split("#")[0].split()[1:] if "=" not in word} - targets
            assert not missing, f"README.md:{line}: the Makefile has no target {', '.join(sorted(missing))}"
        elif "pip install" in text:
            named = {name.strip() for names in re.findall(r"\[([^]]+)\]", text) for name in names.split(",")}
            assert named <= extras, f"README.md:{line}: retime has no extra {', '.join(sorted(named - extras))}"


def test_commands_run(commands, tmp_path) -> None:
    scripts = Path(sys.executable).parent
    if shutil.which("retime", path=str(scripts)) is None:
        pytest.skip("retime is not installed in this environment: make install")
    environment = {**os.environ, "PATH": f"{scripts}{os.pathsep}{os.environ.get('PATH', '')}"}
    for line, text in commands:
        if text.startswith(SETS_UP):
            continue
        run = subprocess.run(
            text, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300, check=False
        )
        assert run.returncode == 0, f"README.md:{line}: {text}\nended with {run.returncode}\n{run.stdout}{run.stderr}"

"""Follow docs/tutorial.md where a wheel of retime is installed and nothing else: ``python tests/tutorial_alone.py``.

`make release-check` runs this in a fresh environment. It ends with an error where a command or an example does
otherwise than the page shows.
"""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
import tempfile
from pathlib import Path

TUTORIAL = Path(__file__).resolve().parents[1] / "docs" / "tutorial.md"
# What a fresh environment has, and what retime itself needs.
EXPECTED = {"pip", "setuptools", "wheel", "retime", "numpy", "click", "colorama"}


def call(arguments: list[str]) -> tuple[int, str]:
    """Call the command that was installed."""
    command = Path(sys.executable).parent / ("retime.exe" if os.name == "nt" else "retime")
    done = subprocess.run([command, *arguments], capture_output=True, text=True, encoding="utf-8", check=False)
    return done.returncode, done.stdout + done.stderr


def main() -> None:
    """Follow the tutorial from start to end."""
    # Of this folder alone: the rest of the tests needs more than there is.
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    from pages import follow, run_examples

    import retime

    there = {found.metadata["Name"].lower() for found in importlib.metadata.distributions()}
    assert there <= EXPECTED, f"{', '.join(sorted(there - EXPECTED))} is installed: this proves nothing"
    assert Path(retime.__file__).is_relative_to(sys.prefix), f"retime comes from {retime.__file__}, not from a wheel"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        n_commands = follow(TUTORIAL, call, Path(folder))
        n_examples = run_examples(TUTORIAL)
        os.chdir(Path(folder).anchor)
    assert n_commands > 5
    assert n_examples > 4
    _, build = call(["info", "--build"])
    backend = next(line for line in build.splitlines() if line.startswith("kernels"))
    print(
        f"The tutorial's {n_commands} commands and {n_examples} examples do what it shows, with retime "
        f"{retime.__version__} and nothing else, on Python {sys.version.split()[0]}; {' '.join(backend.split())}"
    )


if __name__ == "__main__":
    main()

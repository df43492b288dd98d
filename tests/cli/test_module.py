"""`python -m retime` is the command."""

from __future__ import annotations

import subprocess
import sys

from retime import __version__


def test_the_package_runs_as_a_module() -> None:
    found = subprocess.run([sys.executable, "-m", "retime", "--version"], capture_output=True, text=True, check=True)
    assert found.stdout == f"retime, version {__version__}\n"
    wrong = subprocess.run([sys.executable, "-m", "retime", "wrap"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2
    assert wrong.stderr.startswith("error: No such command")

"""What a process is started with that may die of a stranger's file, while this one goes on."""

from __future__ import annotations

import os
import sys


def child_environment() -> dict[str, str]:
    """Return this process's environment, with its own path, so that the child finds the same modules."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}

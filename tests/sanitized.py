"""A pytest plugin: the tests use the compiled kernels of another build, where RETIME_KERNELS says.

python -m pytest -p tests.sanitized tests/kernels        (see `make sanitize`)
"""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import retime.kernels


def use_kernels(path: Path) -> None:
    """Have `retime.kernels` load this file as its compiled module."""
    name = "retime.kernels._kernels"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no extension module")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules[name] = module
    retime.kernels._kernels = module
    if (why := retime.kernels.why_not_compiled()) is not None:
        raise ImportError(f"{path}: {why}")


if named := os.environ.get("RETIME_KERNELS"):
    use_kernels(Path(named))

"""Finds the evaluations: every file v<number>.py of this folder is one."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable
from types import ModuleType

import study.evaluations
from study.clips.library import Library
from study.evaluations.evaluation import Evaluation, PaperRow

_NAME = re.compile(r"v(\d+)([a-z]?)")


def _place(name: str) -> tuple[int, str] | None:
    """Return where an evaluation stands among the others, by its file's name: V6, V6b, V7, ..., V10."""
    found = _NAME.fullmatch(name)
    return (int(found[1]), found[2]) if found else None


def evaluation_files() -> dict[str, ModuleType]:
    """Import every file that is an evaluation, in their order, by key."""
    names = {module.name: _place(module.name) for module in pkgutil.iter_modules(study.evaluations.__path__)}
    found = sorted((place, name) for name, place in names.items() if place is not None)
    modules = [importlib.import_module(f"study.evaluations.{name}") for _, name in found]
    return {module.KEY: module for module in modules}


_FILES = evaluation_files()

EVALUATIONS: dict[str, Callable[[Library, int], Evaluation]] = {key: one.evaluate for key, one in _FILES.items()}
"""By key. Each takes the clips, and how often to repeat what is timed."""

PAPER: dict[str, PaperRow] = {key: one.PAPER for key, one in _FILES.items() if one.PAPER is not None}
"""The paper's own rows of Table 1, by key."""

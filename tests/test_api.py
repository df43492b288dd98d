"""What is promised of the package's names and signatures stays as docs/api.md has it."""

from __future__ import annotations

import ast
import dataclasses
import functools
import importlib
import inspect
import types
from pathlib import Path

import pytest

from tests.tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
make_api = tool("make_api")


def test_the_public_interface_is_the_one_that_is_promised() -> None:
    pytest.importorskip("anywidget", reason="needs the extra notebook")
    promised = make_api.PAGE.read_text(encoding="utf-8").splitlines()
    now = make_api.page().splitlines()
    gone, new = sorted(set(promised) - set(now)), sorted(set(now) - set(promised))
    assert now == promised, (
        f"gone: {gone}\nnew: {new}\nIf that is meant, follow docs/stability.md, run python tools/make_api.py, and say "
        "so in CHANGELOG.md"
    )


def test_a_change_of_any_kind_shows() -> None:
    module = types.ModuleType("retime.example")

    class Clip:
        def cut(self, first: int, *, last: int | None = None) -> Clip:
            raise NotImplementedError

        @property
        def rate(self) -> float:
            raise NotImplementedError

        @functools.cached_property
        def poses(self) -> int:
            raise NotImplementedError

        @classmethod
        def read(cls, path: str) -> Clip:
            raise NotImplementedError

        def __getitem__(self, index: slice) -> Clip:
            raise NotImplementedError

        def __hash__(self) -> int:
            raise NotImplementedError

    Clip.__module__ = "retime.example"

    def speed(clip: Clip, kind: str = "mean", turn: object = lambda: 1) -> float:
        raise NotImplementedError

    speed.__module__ = "retime.example"
    module.Clip, module.speed, module.LIMIT, module._hidden = Clip, speed, 3, 4
    module.__all__ = ["Clip", "LIMIT", "speed"]
    assert list(make_api.lines_of(module)) == [
        "class Clip",
        "    Clip.__getitem__(index: slice) -> Clip",
        "    Clip.cut(first: int, *, last: int | None = None) -> Clip",
        "    Clip.poses: int  (property)",
        "    Clip.rate: float  (property)",
        "    Clip.read(path: str) -> Clip",
        "LIMIT: int",
        "speed(clip: Clip, kind: str = 'mean', turn: object = <function>) -> float",
    ]
    with_more = functools.partial(speed)
    with_more.__module__ = "retime.example"
    del module.__all__
    assert make_api.public_names(module) == ["Clip", "speed"]


def test_what_a_value_holds_is_on_the_page_under_the_names_that_it_has() -> None:
    page = make_api.PAGE.read_text(encoding="utf-8")
    values = []
    for module in map(importlib.import_module, ("retime", "retime.errors", "retime.formats", "retime.batch")):
        values += [getattr(module, name) for name in make_api.public_names(module)]
    values = [value for value in values if inspect.isclass(value) and dataclasses.is_dataclass(value)]
    assert len(values) > 20
    for value in values:
        held = {one.name for one in dataclasses.fields(value)}
        taken = set(inspect.signature(value).parameters)
        assert {one for one in held if f"{value.__name__}.{one}: " in page} == held - taken
        # Keytime takes numbers without names too.
        assert taken <= held | {"output_first", "named"}


def test_a_docstring_that_lists_parameters_lists_all_of_them() -> None:
    listed = 0
    for module in map(importlib.import_module, ("retime", "retime.formats", "retime.batch")):
        for name in make_api.public_names(module):
            value = getattr(module, name)
            section = (inspect.getdoc(value) or "").partition("Parameters\n----------\n")[2]
            # Keytime is made by names, and by others as in 0.1.
            if not section or name == "Keytime":
                continue
            lines = section.partition("\n\n")[0].splitlines()
            named = ",".join(line.partition(" : ")[0] for line in lines if not line.startswith(" "))
            told = {one.strip(" *") for one in named.split(",")}
            assert told == set(inspect.signature(value).parameters), f"{module.__name__}.{name}"
            listed += 1
    assert listed > 30


def test_all_that_warns_of_its_end_is_listed() -> None:
    warned = 0
    for path in (ROOT / "src" / "retime").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                warned += any(isinstance(one, ast.Name) and one.id == "DeprecationWarning" for one in node.args)
    table = (ROOT / "docs" / "stability.md").read_text(encoding="utf-8").partition("On its way out now:")[2]
    rows = [line for line in table.partition("## ")[0].splitlines() if line.startswith("| `")]
    assert warned == len(rows) > 0

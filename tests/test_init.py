"""The package's table of contents: all that the help names is there, when it is asked for and not before."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

import retime


def test_every_name_is_there_and_listed() -> None:
    for name in retime.__all__:
        assert getattr(retime, name) is not None
    assert set(retime.__all__) <= set(dir(retime))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        retime.nothing  # noqa: B018


def test_the_help_names_what_there_is() -> None:
    named = set(re.findall(r"(?<!`)`(?:retime\.)?([A-Za-z_]+)", retime.__doc__ or ""))
    assert set(retime.__all__) - named == {
        "FormatError",
        "FormatWarning",
        "InfeasibleWarpError",
        "InvalidMotionError",
        "MissingExtraError",
        "OptionError",
        "OutputExistsError",
    }, "errors stand in retime.errors; all else is in the table of contents"
    assert all(hasattr(retime, name) for name in named - {"notebook"})


# Modules that a name brings with it.
CODE = """
import sys
import retime
assert not [name for name in sys.modules if name.startswith("retime.")], "nothing is loaded before it is used"
assert retime.errors.RetimeError is retime.RetimeError
sys.modules["anywidget"] = None
try:
    retime.notebook
except retime.MissingExtraError as error:
    assert "retime[notebook]" in str(error)
else:
    raise AssertionError("anywidget is missing")
import pydoc
assert "guided_warp" in pydoc.plain(pydoc.render_doc(retime))
"""


def test_modules_come_when_asked_for_and_help_needs_no_extra() -> None:
    subprocess.run([sys.executable, "-c", CODE], check=True, timeout=120)


UNINSTALLED = """
import importlib
import importlib.metadata


def missing(name):
    raise importlib.metadata.PackageNotFoundError(name)


importlib.metadata.version = missing
for name in ("retime", "retime.batch", "retime.formats", "retime.evaluate", "retime.hosts.registry", "retime.cli.main"):
    importlib.import_module(name)
"""


def test_docs_are_made_of_a_retime_that_is_not_installed() -> None:
    subprocess.run([sys.executable, "-c", UNINSTALLED], check=True, timeout=120)


def test_the_notebook_comes_with_its_extra() -> None:
    pytest.importorskip("anywidget", reason="needs the extra notebook")
    assert retime.notebook.edit.__module__ == "retime.notebook"

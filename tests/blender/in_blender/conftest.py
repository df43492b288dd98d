"""Blender without a window, with the extension installed as a person installs it: from its zip, into an empty home."""

from __future__ import annotations

import os
import tempfile
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
HERE = find_spec("bpy") is not None
# No test; and where it is looked through for examples there may be no Blender to import.
collect_ignore = ["rigs.py"]
if HERE:
    # Blender reads these once, when bpy is imported: nothing of this machine's user is seen or touched.
    home = tempfile.mkdtemp(prefix="blender-home-")
    os.environ.update(HOME=home, BLENDER_USER_RESOURCES=home)


def the_zip() -> Path:
    """Return the zip to install: RETIME_EXTENSION, else the one of this platform."""
    if "RETIME_EXTENSION" in os.environ:
        return Path(os.environ["RETIME_EXTENSION"])
    found = sorted((ROOT / "build" / "extension").glob("retime-*.zip"), key=lambda path: (len(path.name), path.name))
    assert found, "build the extension first: make extension"
    return found[-1]


@pytest.fixture(scope="session")
def installed() -> None:
    """Install the extension from its zip."""
    import bpy

    bpy.ops.extensions.package_install_files(filepath=str(the_zip()), repo="user_default", enable_on_install=True)
    assert hasattr(bpy.types.Scene, "retime"), "the extension did not register"


@pytest.fixture
def scene(installed: None):
    """Give an empty scene at 24 frames a second."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True)
    assert hasattr(bpy.types.Scene, "retime")
    return bpy.context.scene

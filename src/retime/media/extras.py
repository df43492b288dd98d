"""The packages behind the extras ``video`` and ``beats``, imported when they are used."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

from retime.errors import MissingExtraError

_PACKAGES = {
    "av": ("work on video, pictures or sound", "PyAV", "video"),
    "cv2": ("mixing frames", "opencv-python-headless", "video"),
    "python_stretch": ("sound that keeps its pitch", "python-stretch", "video"),
    "librosa": ("finding beats in sound", "librosa", "beats"),
}


def needed(module: str) -> Any:
    """Import a module of an extra.

    Parameters
    ----------
    module : {"av", "cv2", "python_stretch", "librosa"}
        Which one.

    Raises
    ------
    MissingExtraError
        It is not installed.
    """
    what, package, extra = _PACKAGES[module]
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingExtraError(what, package=package, extra=extra) from error


def refuse_without(*modules: str) -> None:
    """Raise MissingExtraError where a module of an extra is not installed; it is not imported, which takes time.

    Parameters
    ----------
    *modules : str
        As of `needed`.
    """
    for module in modules:
        if importlib.util.find_spec(module) is None:
            what, package, extra = _PACKAGES[module]
            raise MissingExtraError(what, package=package, extra=extra)

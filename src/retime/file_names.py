"""Names of files by the rules of the system at hand: which two are one file, and which are none at all."""

from __future__ import annotations

import os
import re
import sys
import unicodedata

# What Windows takes for a device, in any folder and with any ending.
_DEVICES = re.compile(r"(?:con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³]|conin\$|conout\$)", re.IGNORECASE)


def name_key(name: str) -> str:
    """Return what two names have in common that are one file on this system.

    Windows and macOS do not care for case, nor macOS for how an accent is written. (A volume may be set up otherwise;
    names that differ in case alone are then told to be one, and no file is lost.)

    Parameters
    ----------
    name : str
        A name, or a path.
    """
    if os.name == "nt" or sys.platform == "darwin":
        return unicodedata.normalize("NFC", name).casefold()
    return name


def usable_name(name: str) -> str:
    """Return a name that a file can have here, the name itself where it can.

    On Windows ``con.bvh`` is the console, and a dot or a blank at the end is left out.

    Parameters
    ----------
    name : str
        A name without folders.
    """
    if os.name != "nt":
        return name
    plain = name.rstrip(". ") or "_"
    return f"_{plain}" if _DEVICES.fullmatch(plain.partition(".")[0].rstrip()) else plain

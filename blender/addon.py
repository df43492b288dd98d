"""What Blender is told of: settings, buttons and panels."""

from __future__ import annotations

from . import operators, panels, settings

_PARTS = (settings, operators, panels)


def register() -> None:
    """Add everything."""
    for part in _PARTS:
        part.register()


def unregister() -> None:
    """Take everything away again."""
    for part in reversed(_PARTS):
        part.unregister()

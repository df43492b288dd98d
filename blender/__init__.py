"""Retime for Blender: new timing for a motion where it is edited.

Nothing here imports bpy until Blender registers the extension, so that what is not Blender's is tested without it.
"""

from __future__ import annotations


def register() -> None:
    """Add panels, operators and settings; Blender calls this."""
    from . import addon

    addon.register()


def unregister() -> None:
    """Take them away again."""
    from . import addon

    addon.unregister()

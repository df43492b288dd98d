"""The editor's document: what it holds, its undo, its autosave, its file, and the warp that it asks for."""

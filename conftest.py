"""Which files of the checkout hold examples to run."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

# Without a compiler there are no compiled kernels to import.
collect_ignore = [] if find_spec("retime.kernels._kernels") else ["src/retime/kernels/compiled.py"]
# Nor is there a server to import without the extra "edit", nor a widget without "notebook".
if not find_spec("starlette"):
    collect_ignore += ["src/retime/server/app.py", "src/retime/server/guard.py"]
if not find_spec("anywidget"):
    collect_ignore += ["src/retime/notebook.py"]
# The examples of Parquet need the extra "parquet", and a library's manifest is one.
if not find_spec("pyarrow"):
    collect_ignore += ["docs/batch.md", "docs/parquet.md"]
# What runs USD's own libraries needs the extra "usd".
if not find_spec("pxr"):
    room = Path(__file__).parent / "src" / "retime" / "formats" / "curves" / "usd"
    collect_ignore += [str(path) for path in room.glob("*.py") if "\nfrom pxr import" in path.read_text("utf-8")]

"""A usdz package: a zip file whose members are not compressed, and begin at multiples of 64 bytes.

Source: the usdz file format specification of OpenUSD.
"""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

from retime.errors import FormatError
from retime.formats.read_options import Limits

_ALIGNMENT = 64
# A field of an entry that says nothing, and only fills; its head has four bytes.
_FILLER, _FILLER_HEAD = 0x1986, 4
_LAYERS = (".usda", ".usdc", ".usd")


def unpacked(data: bytes, limits: Limits) -> dict[str, bytes]:
    """Read a package's files in their order; the first one is its root layer.

    Raises
    ------
    FormatError
        It is no package, or damaged, or a name in it leaves it, or what it holds is past the limits.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            members = archive.infolist()
            if not members:
                raise FormatError("a usdz package with no file in it")
            if len(members) > 65535 or sum(one.file_size for one in members) > limits.inflated_bytes:
                raise FormatError("a usdz package that claims more than Limits.inflated_bytes, or 65535 files")
            files: dict[str, bytes] = {}
            for one in members:
                name = one.filename
                parts = name.split("/")
                if name.startswith("/") or "\\" in name or ":" in name or not {"", ".", ".."}.isdisjoint(parts):
                    raise FormatError(f"a file of the usdz package has a name that may leave it: {name[:100]!r}")
                if name in files:
                    raise FormatError(f"the usdz package holds {name[:100]!r} twice")
                if one.compress_type != zipfile.ZIP_STORED or one.file_size != one.compress_size:
                    raise FormatError(f"{name[:100]} is compressed, which no usdz package may be")
                files[name] = archive.read(one)
    except FormatError:
        raise
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, struct.error, ValueError) as error:
        raise FormatError(f"expected a usdz package (a zip file): {str(error)[:200]}") from None
    root = next(iter(files))
    if Path(root).suffix.lower() not in _LAYERS:
        raise FormatError(f"the first file of a usdz package is its root layer; found {root[:100]!r}")
    return files


def packed(files: Mapping[str, bytes]) -> bytes:
    """Make a package of files, in their order.

    Examples
    --------
    >>> data = packed({"a.usda": b"#usda 1.0", "b/c.png": b"..."})
    >>> data.index(b"#usda") % 64, data.index(b"...") % 64, list(unpacked(data, Limits()))
    (0, 0, ['a.usda', 'b/c.png'])
    """
    out = BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, content in files.items():
            # No date: the same files make the same package.
            entry = zipfile.ZipInfo(name)
            begins = out.tell() + 30 + len(name.encode()) + _FILLER_HEAD
            fill = -begins % _ALIGNMENT
            entry.extra = struct.pack("<HH", _FILLER, fill) + bytes(fill)
            archive.writestr(entry, content)
    return out.getvalue()

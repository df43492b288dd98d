"""What a file is, told by its first bytes: messages name it where a picture is called .bvh, or a web page was saved."""

from __future__ import annotations

_STARTS = (
    (b"\x89PNG\r\n\x1a\n", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"\x1f\x8b", "gzip-compressed data"),
    (b"BZh", "bzip2-compressed data"),
    (b"\xfd7zXZ\x00", "xz-compressed data"),
    (b"(\xb5/\xfd", "zstd-compressed data"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (b"Rar!\x1a\x07", "a RAR archive"),
    (b"PK\x03\x04", "a zip archive (or a format made of one, such as NPZ or USDZ)"),
    (b"PK\x05\x06", "an empty zip archive"),
    (b"PAR1", "a Parquet table"),
    (b"\x93NUMPY", "a NumPy array (NPY)"),
    (b"Kaydara FBX Binary", "a binary FBX scene"),
    (b"; FBX", "an FBX scene in text"),
    (b"glTF", "a binary glTF scene (GLB)"),
    (b"BLENDER", "a Blender file"),
    (b"PXR-USDC", "a binary USD scene"),
    (b"#usda", "a USD scene in text"),
    (b"#!OML:ASF", "an AMC motion"),
    (b"RIFF", "a RIFF file (AVI, WAV or WebP)"),
    (b"\x7fELF", "a program"),
    (b"version https://git-lfs", "a Git LFS pointer, which stands for a file that was not fetched (git lfs pull)"),
    (b"\x02P", "a C3D capture"),
)
_TEXT_STARTS = (
    (b"<!doctype html", "a web page (HTML)"),
    (b"<html", "a web page (HTML)"),
    (b"<?xml", "an XML document"),
    (b"{", "a JSON document"),
    (b":version", "an ASF skeleton"),
    (b"hierarchy", "a BVH motion"),
)


def foreign_kind(data: bytes) -> str | None:
    """Name what a file is by its first bytes; None where they are nothing well known.

    Examples
    --------
    >>> foreign_kind(b"Kaydara FBX Binary")
    'a binary FBX scene'
    """
    for start, kind in _STARTS:
        if data.startswith(start):
            return kind
    if data[4:8] == b"ftyp":
        return "an MP4 or MOV video"
    head = data[:64].lstrip().lower()
    for start, kind in _TEXT_STARTS:
        if head.startswith(start):
            return kind
    return None

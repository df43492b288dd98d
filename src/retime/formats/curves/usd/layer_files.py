"""Layers copied, given samples, and written as files: text or crate. Runs in the child process (`usd.child`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pxr import Sdf

from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.curves.usd.text import spliced_samples
from retime.formats.curves.usd.timing import Samples


@dataclass(frozen=True)
class Rewritten:
    """A scene made anew.

    Attributes
    ----------
    files : dict of str to bytes
        "" is the root; other names are of layers beside it.
    left : list of str
        What has time samples that stayed as they were, as no prim of the scene shows them.
    """

    files: dict[str, bytes]
    left: list[str]

    __repr__ = brief_repr


def copy_of(layer: Any) -> Any:
    """Copy a layer in memory."""
    copy = Sdf.Layer.CreateAnonymous(".usda")
    copy.TransferContent(layer)
    return copy


def set_samples(layer: Any, path: Any, samples: Samples) -> None:
    """Give an attribute of a layer these time samples and no others."""
    spec = layer.GetAttributeAtPath(path)
    spec.ClearInfo("timeSamples")
    for code, value in samples:
        layer.SetTimeSample(path, code, Sdf.ValueBlock() if value is None else value)


def layer_file(before: bytes, source: Any, layer: Any, work: Path, assets: Mapping[str, str]) -> bytes:
    """Write a layer as the file was that it comes from: text, or crate; `assets` are names of files that changed."""
    if before.startswith(b"#usda"):
        return spliced_samples(before, source.ExportToString(), layer, assets)
    return layer_bytes(layer, work, text=False)


def layer_bytes(layer: Any, work: Path, *, text: bool) -> bytes:
    """Return a layer's file."""
    if text:
        written: str = layer.ExportToString()
        return written.encode("utf-8", "surrogateescape")
    place = work / "written.usdc"
    if not layer.Export(str(place)):
        raise FormatError("USD could not write the layer")
    return place.read_bytes()

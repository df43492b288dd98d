"""Guided time warping for motion editing: new timing for a motion, its poses untouched.

Read and write
    `sample` (the clip that ships with retime), `read`, `write`, `read_warp`, `write_warp`, `Limits`
What moves
    `Motion`, `Signal`, `ChannelKind`, `Skeleton`, `EndSite`; `joint_signal` (a motion's joints as channels)
Find a warp
    `guided_warp` (the one call most people need), `GuidedWarp`, `Session` (solve again and again),
    `align` (in step with a reference), `imitate` (a retimed example, the rest follows), `Reference`, `PoseOptions`,
    `Lock`, `Keytime`, `variants` (other timings of one clip), `linear_warp`, `spline_warp`
Use a warp
    `Warp`, `apply_warp`; `resample` (another rate, the same timing); `export_curve`, `ExportedCurve` and `import_curve`
    (the retime curves of Nuke, Maya, After Effects and more)
Many clips
    `batch.run` (a whole library, on Dask), `batch.retime_clip` (one of them, for another engine)
Feet that stand
    `contacts`, `Contacts` (when they do), `retimed_slip`, `SlipReport` (how far they slide, before and after)
Look at it
    `plot_warps` (needs the extra ``plot``), `compare_warps`; in a notebook every value shows itself, and
    `retime.notebook.edit` is the editor (extra ``notebook``)
When something is wrong
    `RetimeError` and its children, `RetimeWarning`; see `retime.errors`
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from retime import batch as batch
    from retime import errors as errors
    from retime import notebook as notebook
    from retime.data import sample
    from retime.errors import (
        FormatError,
        FormatWarning,
        InfeasibleWarpError,
        InvalidMotionError,
        MissingExtraError,
        OptionError,
        OutputExistsError,
        RetimeError,
        RetimeWarning,
    )
    from retime.evaluate.compare import compare_warps
    from retime.evaluate.plot.warps import plot_warps
    from retime.formats.read_options import Limits
    from retime.formats.registry import read, write
    from retime.formats.warp_file import read_warp, write_warp
    from retime.hosts.exporting import ExportedCurve, export_curve
    from retime.hosts.importing import import_curve
    from retime.motion.channels import ChannelKind
    from retime.motion.contacts import Contacts, contacts
    from retime.motion.joint_signal import joint_signal
    from retime.motion.motion import Motion
    from retime.motion.signal import Signal
    from retime.motion.skeleton import EndSite, Skeleton
    from retime.search.align import align
    from retime.search.guided import guided_warp
    from retime.search.imitate import imitate
    from retime.search.poses.references import Reference
    from retime.search.poses.spaces import PoseOptions
    from retime.search.result import GuidedWarp
    from retime.search.session import Session
    from retime.search.variants import variants
    from retime.search.wishes.locks import Lock
    from retime.warp.apply import apply_warp
    from retime.warp.curve import Warp
    from retime.warp.keytime import Keytime
    from retime.warp.resampling import resample
    from retime.warp.slip import SlipReport, retimed_slip
    from retime.warp.spline import linear_warp, spline_warp

# Modules that people name by themselves.
_MODULES = ("batch", "errors", "notebook")
# Imported when first used: `retime info` should not wait for the search, nor the search for the plots.
_HOMES = {
    "FormatError": "retime.errors",
    "FormatWarning": "retime.errors",
    "InfeasibleWarpError": "retime.errors",
    "InvalidMotionError": "retime.errors",
    "MissingExtraError": "retime.errors",
    "OptionError": "retime.errors",
    "OutputExistsError": "retime.errors",
    "RetimeError": "retime.errors",
    "RetimeWarning": "retime.errors",
    "sample": "retime.data",
    "compare_warps": "retime.evaluate.compare",
    "plot_warps": "retime.evaluate.plot.warps",
    "Limits": "retime.formats.read_options",
    "read": "retime.formats.registry",
    "write": "retime.formats.registry",
    "read_warp": "retime.formats.warp_file",
    "write_warp": "retime.formats.warp_file",
    "ExportedCurve": "retime.hosts.exporting",
    "export_curve": "retime.hosts.exporting",
    "import_curve": "retime.hosts.importing",
    "ChannelKind": "retime.motion.channels",
    "Contacts": "retime.motion.contacts",
    "contacts": "retime.motion.contacts",
    "joint_signal": "retime.motion.joint_signal",
    "Motion": "retime.motion.motion",
    "Signal": "retime.motion.signal",
    "EndSite": "retime.motion.skeleton",
    "Skeleton": "retime.motion.skeleton",
    "SlipReport": "retime.warp.slip",
    "apply_warp": "retime.warp.apply",
    "resample": "retime.warp.resampling",
    "retimed_slip": "retime.warp.slip",
    "Keytime": "retime.warp.keytime",
    "Warp": "retime.warp.curve",
    "GuidedWarp": "retime.search.result",
    "Lock": "retime.search.wishes.locks",
    "PoseOptions": "retime.search.poses.spaces",
    "align": "retime.search.align",
    "imitate": "retime.search.imitate",
    "Reference": "retime.search.poses.references",
    "Session": "retime.search.session",
    "guided_warp": "retime.search.guided",
    "linear_warp": "retime.warp.spline",
    "spline_warp": "retime.warp.spline",
    "variants": "retime.search.variants",
}

__version__ = "1.0.0"
__all__ = [
    "ChannelKind",
    "Contacts",
    "EndSite",
    "ExportedCurve",
    "FormatError",
    "FormatWarning",
    "GuidedWarp",
    "InfeasibleWarpError",
    "InvalidMotionError",
    "Keytime",
    "Limits",
    "Lock",
    "MissingExtraError",
    "Motion",
    "OptionError",
    "OutputExistsError",
    "PoseOptions",
    "Reference",
    "RetimeError",
    "RetimeWarning",
    "Session",
    "Signal",
    "Skeleton",
    "SlipReport",
    "Warp",
    "align",
    "apply_warp",
    "compare_warps",
    "contacts",
    "export_curve",
    "guided_warp",
    "imitate",
    "import_curve",
    "joint_signal",
    "linear_warp",
    "plot_warps",
    "read",
    "read_warp",
    "resample",
    "retimed_slip",
    "sample",
    "spline_warp",
    "variants",
    "write",
    "write_warp",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"retime.{name}")
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'retime' has no attribute {name!r}")


def __dir__() -> list[str]:
    # Not `notebook`: whoever looks at all there is (help does) would need its extra.
    return sorted([*__all__, "batch", "errors"])

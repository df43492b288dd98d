"""What the module of a format offers, by what its files hold."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO, Protocol

from retime.formats.read_options import ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.skin import Skin
from retime.warp.curve import Warp


class FormatModule(Protocol):
    """What a format's module offers."""

    def read(self, path: Path, data: bytes, options: ReadOptions) -> AnyMotion:
        """Read the bytes of a file; `path` is for messages and for files that belong to it."""

    def write(self, motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
        """Write a file, all or nothing."""


class CurveModule(FormatModule, Protocol):
    """What the module of a format offers whose animation is curves."""

    def animation_names(self, path: Path, data: bytes, options: ReadOptions) -> list[str]:
        """Name the animations that are meant."""

    def retime(
        self, path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions
    ) -> dict[str, bytes]:
        """Cut the curves of animations by warps; "" is the new file, other names are of files beside it."""

    def bake(
        self, path: Path, data: bytes, warps: Warp | Mapping[str, Warp], options: ReadOptions, *, average: bool
    ) -> dict[str, bytes]:
        """Put a key on every frame instead."""

    def layer(
        self,
        path: Path,
        data: bytes,
        warps: Warp | Mapping[str, Warp],
        options: ReadOptions,
        *,
        kind: str,
        place: Path,
    ) -> dict[str, bytes]:
        """Make a file for `place` that shows this one with new timing, where the format has such (`Format.layers`)."""


class TellingModule(FormatModule, Protocol):
    """What the module of a format offers that has more to tell of a file than what is read."""

    def facts(self, path: Path, data: bytes, options: ReadOptions) -> dict[str, str]:
        """Say what a file holds beside the clip that is read."""


class ManyFilesModule(FormatModule, Protocol):
    """What the module of a format offers whose clips may be many files."""

    def is_many_files(self, path: Path) -> bool:
        """Tell whether a path stands for several files: a folder, or a pattern of names."""


class SkinModule(FormatModule, Protocol):
    """What the module of a format offers whose files may hold meshes that follow the joints."""

    def skin(self, path: Path, data: bytes, options: ReadOptions) -> Skin | None:
        """Read what follows the joints of the motion that is read."""


class FramesModule(FormatModule, Protocol):
    """What the module of a format offers whose files are given other frames in place."""

    def retime_frames(
        self,
        path: Path,
        data: bytes,
        warp: Warp,
        options: ReadOptions,
        *,
        frames: tuple[int, int] | None,
        average: bool,
        held: int,
    ) -> bytes:
        """Make the file anew with the frames that a warp shows; see `retime_file`."""

    def claims(self, file: BinaryIO) -> bool:
        """Tell whether a file with the ending of the format that it is `among` is one of its own."""

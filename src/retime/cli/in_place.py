"""Writing a retimed clip: resampled, or, where its format's animation is curves, its file with other keys."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from retime.cli.clip_options import ClipOptions, retimed
from retime.cli.terminal import Stages
from retime.errors import OptionError

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion
    from retime.motion.contacts import Contacts
    from retime.warp.curve import Warp


@dataclass(frozen=True)
class Writing:
    """How clips are written.

    Attributes
    ----------
    average : bool
        Average where sped up (of curves, where baked).
    held : int
        For how many frames each pose is held.
    bake : bool
        Of curves: put a key on every frame.
    tolerance : float, optional
        Of curves: seconds; None is the default of `retime.formats.registry.retime_file`.
    force : bool
        Replace what is there.
    """

    average: bool
    held: int
    bake: bool
    tolerance: float | None
    force: bool

    def write(
        self,
        source: Path,
        options: ClipOptions,
        clip: AnyMotion | None,
        warp: Warp,
        place: Path,
        stages: Stages,
        *,
        feet: Contacts | None = None,
    ) -> AnyMotion | None:
        """Give a clip a warp and write it; return what was written, where it was resampled.

        `clip` is what `options` read from `source`; a file that is retimed in place does without.
        `feet` are its contacts, where they are known.
        """
        from retime.formats.registry import write

        if keeps_curves(source, place):
            offset = 0.0
            if clip is not None:
                # Frames that were left out at the start: the file's clock goes on from its first key.
                offset = clip.first_frame / float(clip.rate)
            moved = replace(warp, input_times=warp.input_times + offset, keytimes=()) if offset else warp
            with stages.stage("write", "writing"):
                self.write_curves(source, options, moved, place)
            return None
        assert clip is not None
        with stages.stage("apply", "resampling"):
            result = retimed(clip, warp, average=self.average, feet=feet, held=self.held)
        with stages.stage("write", "writing"):
            write(result, place, overwrite=self.force)
        return result

    def write_curves(self, source: Path, options: ClipOptions, warps: Warp | dict[str, Warp], place: Path) -> None:
        """Write a file with the keys of its animations retimed."""
        from retime.formats.registry import retime_file

        if self.held > 1:
            raise OptionError(
                f"--on-twos and --on hold frames, and {place} keeps its curves; set them to step in the program that "
                "made it, or write another format"
            )
        more = {} if self.tolerance is None else {"tolerance": self.tolerance}
        retime_file(
            source,
            place,
            warps,
            animation=options.animation,
            rate=options.fps,
            bake=self.bake,
            average=self.average,
            overwrite=self.force,
            **more,
        )


def keeps_curves(source: Path, place: Path) -> bool:
    """Tell whether a file is retimed in place: its animation is curves, and the output is a file of its kind."""
    from retime.formats.registry import format_of

    return format_of(source).curves and format_of(place) == format_of(source)

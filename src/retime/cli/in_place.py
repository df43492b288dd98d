"""Writing a retimed clip: resampled, or its file with other keys or frames and all else in it kept."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retime.cli.clip_options import ClipOptions
from retime.cli.media_options import MediaChoices
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
        Of curves: seconds; None is the default of `retime.formats.in_place.retime_file`.
    layer : str, optional
        Of USD: the kind of layer that shows the file, in place of the file retimed.
    force : bool
        Replace what is there.
    media : MediaChoices
        How video, pictures and sound are retimed.
    beside : list of Path
        What was written beside the places that were named: the layers of a scene, the buffer of a .gltf, a skeleton.
    """

    average: bool
    held: int
    bake: bool
    tolerance: float | None
    layer: str | None
    force: bool
    media: MediaChoices = MediaChoices()  # noqa: RUF009
    beside: list[Path] = field(default_factory=list, compare=False)

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
        from retime.formats.registry import stays_in_place, write
        from retime.media.kinds import is_media

        if is_media(source):
            # Of footage that was looked at frames may have been left out; of that beside another clip none was.
            begun = 0.0 if clip is None else clip.first_frame / float(clip.rate)
            self.write_media(source, warp, place, stages, fps=options.fps, offset=-begun)
            return None
        known = stays_in_place(source, place, arrays=options.array)
        if self.layer is not None and not (known is not None and known.layers):
            raise OptionError(
                f"--layer {self.layer} shows a USD scene, in a .usda, .usdc or .usd; {place} would be none of {source}"
            )
        if known is not None and known.frames:
            with stages.stage("write", "writing"):
                self._write_frames(source, options, clip, warp, place)
            return None
        if known is not None:
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
            from retime.warp.retimed import retimed

            result = retimed(clip, warp, average=self.average, feet=feet, held=self.held)
        with stages.stage("write", "writing"), self._noting(place):
            write(result, place, overwrite=self.force)
        return result

    @contextlib.contextmanager
    def _noting(self, place: Path) -> Iterator[None]:
        """Keep which files are written beside a place."""
        from retime.files import noting_writes

        with noting_writes() as written:
            yield
        self.beside.extend(one for one in written if one != place)

    def write_media(
        self, source: Path, warp: Warp, place: Path, stages: Stages, *, fps: Fraction | None, offset: float
    ) -> None:
        """Give a video, pictures or sound a warp; they begin at `offset` seconds of its input time."""
        from retime.media.apply import retime_media
        from retime.progress import watching

        if self.held > 1:
            raise OptionError(
                f"--on-twos and --on hold poses, and {source} has none; --output-rate makes it of fewer frames"
            )
        options = self.media.options(average=self.average, fps=fps, offset=offset)
        with stages.stage("apply", f"retiming {source.name}"), watching(stages.tell):
            retime_media(source, place, warp, options, overwrite=self.force)

    def _write_frames(
        self, source: Path, options: ClipOptions, clip: AnyMotion | None, warp: Warp, place: Path
    ) -> None:
        """Write a capture with other frames; those that were left out at its ends stay out."""
        from retime.formats.in_place import retime_file

        frames = None
        if clip is not None and (options.frames or options.drop_first):
            if options.array:
                raise OptionError(
                    f"--frames and --drop-first cut {source} by its points, and --array counts other frames; leave one "
                    "of them out"
                )
            frames = (clip.first_frame, clip.first_frame + clip.n_frames - 1)
        retime_file(
            source,
            place,
            warp,
            rate=options.fps,
            average=self.average,
            frames=frames,
            held=self.held,
            kinds=dict(options.channels),
            repair=options.repair,
            overwrite=self.force,
        )

    def write_curves(self, source: Path, options: ClipOptions, warps: Warp | dict[str, Warp], place: Path) -> None:
        """Write a file with the keys of its animations retimed."""
        from retime.formats.in_place import retime_file

        if self.held > 1:
            raise OptionError(
                f"--on-twos and --on hold frames, and {place} keeps its curves; set them to step in the program that "
                "made it, or write another format"
            )
        more: dict[str, Any] = {} if self.tolerance is None else {"tolerance": self.tolerance}
        with self._noting(place):
            retime_file(
                source,
                place,
                warps,
                animation=options.animation,
                rate=options.fps,
                bake=self.bake,
                average=self.average,
                layer=self.layer,
                outside=options.allow_outside,
                overwrite=self.force,
                **more,
            )


def keeps_curves(source: Path, place: Path) -> bool:
    """Tell whether a file's curves are cut: its animation is curves, and the output is a file of its kind."""
    from retime.formats.registry import format_of, stays_in_place
    from retime.media.kinds import is_media

    if is_media(source):
        return False
    return format_of(source).curves and stays_in_place(source, place) is not None

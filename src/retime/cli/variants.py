"""`retime warp --variants N`: several timings of one clip, each with files of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retime.cli.output_options import OutputOptions
from retime.errors import OptionError
from retime.motion.grammar import parse_number, parse_speeds

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion
    from retime.search.result import GuidedWarp

# What stands in a name for a variant's number.
_NUMBER = "{n}"
LENGTHS = (0.8, 1.2)


def read_count(text: str) -> int:
    """Read how many variants are asked for."""
    return int(parse_number(text, least=1, whole=True))


def read_seed(text: str) -> int:
    """Read a seed."""
    return int(parse_number(text, whole=True))


@dataclass(frozen=True)
class VariantOptions:
    """What was asked for.

    Attributes
    ----------
    n : int
        How many.
    seed : int
        As `retime.variants` has it.
    lengths : (float, float)
        The shortest and the longest, as shares.
    """

    n: int
    seed: int = 0
    lengths: tuple[float, float] = LENGTHS

    def outputs(self, outputs: OutputOptions) -> list[OutputOptions]:
        """Return the places of each variant; raise OptionError where they would be the same."""
        for place in outputs.places:
            if self.n > 1 and _NUMBER not in place.name:
                raise OptionError(
                    f"--variants {self.n} needs a name for each: put {_NUMBER} into {place}, as in "
                    f"{place.stem}_{_NUMBER}{place.suffix}"
                )

        def named(place: Path | None, number: int) -> Path | None:
            # Numbers of equal width sort as they count.
            text = f"{number:0{len(str(self.n))}d}"
            return None if place is None else place.with_name(place.name.replace(_NUMBER, text))

        return [
            replace(
                outputs,
                output=named(outputs.output, i),
                save=named(outputs.save, i),
                plot=named(outputs.plot, i),
                explain=named(outputs.explain, i),
            )
            for i in range(1, self.n + 1)
        ]

    def find(self, clip: AnyMotion, draw_references: bool, given: dict[str, Any]) -> tuple[GuidedWarp, ...]:
        """Find them."""
        from retime.search.variants import variants

        return variants(clip, self.n, lengths=self.lengths, seed=self.seed, draw_references=draw_references, **given)

    def drawn_references(self, references: Sequence[Path]) -> list[Path]:
        """Return which reference each of them imitates, where one is drawn."""
        from retime.search.variants import drawn_references

        return [references[place] for place in drawn_references(self.n, len(references), self.seed)]


def read_lengths(text: str) -> tuple[float, float]:
    """Read two shares of a length, such as 80%..120%."""
    return parse_speeds(text)

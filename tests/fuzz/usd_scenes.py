"""Mutants of USD scenes, in text, crate and package: each is read, and some are retimed, or refused as FormatError."""

from __future__ import annotations

import random
import tempfile
from functools import cache
from pathlib import Path

from retime.errors import FormatError
from retime.formats.curves.usd import format as usd
from retime.formats.curves.usd.package import packed
from retime.formats.read_options import Limits, ReadOptions
from retime.warp.curve import Warp
from tests.formats.curves.usd.scenes import DrawnScene
from tests.fuzz import trials

_LIMITS = Limits(frames=2_000, joint_poses=20_000, inflated_bytes=256 << 20)
_OPTIONS = ReadOptions(limits=_LIMITS)
_WARP = Warp([0.0, 0.5, 0.7, 1.5], [0.0, 1.0, 1.0, 0.2])
_CLIPS = """def "Played" (
    clips = {
        dictionary default = {
            double2[] active = [(0, 0), (30, 1)]
            asset[] assetPaths = [@./one.usda@, @./two.usda@]
            string primPath = "/A"
            double2[] times = [(0, 0), (24, 24), (48, 36)]
        }
    }
    references = @./one.usda@</A>
)
{
    double x
    double curve.spline = {
        bezier,
        1: 5; post curve (1, 3),
        4: 7; pre (1, 2); post held,
        8: 3,
    }
    variantSet "v" = {
        "a" {
            double q.timeSamples = {
                1: 3,
                4: 5,
            }
        }
    }
}
"""


@cache
def _seeds() -> list[bytes]:
    return [
        DrawnScene(i, authored=i % 2 > 0).text().encode() + (_CLIPS.encode() if i % 3 == 0 else b"") for i in range(8)
    ]


@cache
def _crates() -> list[bytes]:
    """The same as crate files."""
    from pxr import Sdf

    found = []
    with tempfile.TemporaryDirectory() as folder:
        for number, text in enumerate(_seeds()):
            layer = Sdf.Layer.CreateAnonymous(".usda")
            assert layer.ImportFromString(text.decode())
            place = Path(folder) / f"{number}.usdc"
            layer.Export(str(place))
            found.append(place.read_bytes())
    return found


class Mutants:
    """Trials, with a process that serves them until it dies."""

    def __init__(self) -> None:
        self.decoder: usd.Decoder | None = None

    def close(self) -> None:
        if self.decoder is not None:
            self.decoder.close()

    def __call__(self, draw: random.Random) -> str:
        """Try one."""
        if self.decoder is None or self.decoder.is_dead:
            self.close()
            self.decoder = usd.Decoder(_LIMITS, seconds=20)
        name, data = mutant(draw)
        # In a folder that holds nothing else: nothing that a scene refers to is there.
        path = Path(tempfile.gettempdir(), "no-such-folder", name)
        end = "refused"
        try:
            usd.read_by(self.decoder, path, data, _OPTIONS)
            # Retiming takes as long as ten readings.
            if draw.random() < 0.9:
                return "read"
            end = "read, not retimed"
            how = draw.randrange(4)
            if how < 2:
                more = {"bake": how == 1, "average": True, "home": ".", "name": f"new-{name}"}
                new = usd.changed_by(self.decoder, "retime", path, data, _WARP, _OPTIONS, **more)
                # What was written is read again.
                usd.read_by(self.decoder, path, new[""], _OPTIONS)
            else:
                kind = ("clips", "over")[how - 2]
                more = {"kind": kind, "asset": f"./{name}", "text": draw.random() < 0.5}
                usd.changed_by(self.decoder, "layer", path, data, _WARP, _OPTIONS, **more)
            end = "retimed"
        except FormatError as error:
            if self.decoder.is_dead:
                return "died" if "not read after" not in str(error) else "too long"
        return end


def mutant(draw: random.Random) -> tuple[str, bytes]:
    """Make one: its name, and what is in it."""
    kind = draw.choice(["usda", "usda", "usdc", "usdc", "usdz"])
    which = draw.randrange(len(_seeds()))
    binary = kind == "usdc" or (kind == "usdz" and draw.random() < 0.5)
    data = _crates()[which] if binary else _seeds()[which]
    for _ in range(draw.choice([0, 1, 1, 1, 2, 4])):
        data = trials.mutated_bytes(draw, data) if binary else trials.mutated_text(draw, data)
    if kind == "usdz":
        data = packed({f"root.{'usdc' if binary else 'usda'}": data, "a.png": b"picture", "b.usda": _seeds()[0]})
        if draw.random() < 0.3:
            data = trials.mutated_bytes(draw, data)
    return f"mutant.{kind}", data


mutants = Mutants()
KINDS: dict[str, trials.Trial] = {"usd": mutants}

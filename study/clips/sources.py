"""Which clips the study reads from the data folder, and how: one entry a clip."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

# "multiplied by this scale to convert to meters" (CMU's FAQ); the BVH conversions keep the unit.
_CMU_METRES = 2.54 / 45


@dataclass(frozen=True)
class Source:
    """Where a clip comes from.

    Attributes
    ----------
    path : str
        Inside the data folder.
    drop_first : int
        Rows in front that are no capture: the T-pose of the cgspeed conversions. 07_12 has a second one.
    frames : int, optional
        Frames to keep after those; left out, all.
    rate : int
        Frames a second, for files that don't say.
    metres_per_unit : float, optional
        Where the file doesn't say.
    """

    path: str
    drop_first: int = 1
    frames: int | None = None
    rate: int = 120
    metres_per_unit: float | None = _CMU_METRES


def _cmu(trial: str, drop_first: int = 1) -> Source:
    return Source(f"cmu-bvh/{trial}.bvh", drop_first)


FIRST = {
    trial: _cmu(trial)
    for trial in (
        *("01_01", "02_04", "05_08", "05_15", "05_16", "05_18", "07_01", "07_09", "07_10", "29_01"),
        *("49_02", "49_04", "49_05"),
    )
} | {
    "07_12": _cmu("07_12", drop_first=2),
    # Walk, jump, walk: the punches and kicks come later.
    "86_01": Source("cmu-asfamc/86_01.amc", drop_first=0, frames=1980),
    "mocapbank": Source("bvh-other/test_mocapbank.bvh", drop_first=0, rate=30, metres_per_unit=None),
    "boxing": Source("bvh-other/Boxing_Toes.bvh", drop_first=0, rate=100, metres_per_unit=None),
}
"""The first set: the clips that defaults are chosen on."""

SECOND = {
    trial: _cmu(trial)
    for trial in ("05_03", "08_01", "08_08", "08_10", "49_20", *(f"35_{trial}" for trial in range(17, 27)))
} | {
    "17_10": Source("cmu-asfamc/17_10.amc", drop_first=0),
    "86_01, later": Source("cmu-asfamc/86_01.amc", drop_first=1980),
    "dab": Source("bvh-other/dab.bvh", drop_first=0, rate=30, metres_per_unit=None),
    "freebvh": Source("bvh-other/test_freebvh.bvh", drop_first=0, rate=30, metres_per_unit=None),
}
"""The second set: clips that no default is chosen on; each choice is checked on them once.

The rule: every capture of a whole body that lay in the folder when the set was named (30 November 2026), in a format of
motion that is read, from one second to one minute long, and in no use by the study before. All takes that there are of
one person and one action are in it, good ones and bad ones alike.
"""

SOURCES = FIRST | SECOND
"""By name."""


def missing_files(folder: Path) -> list[Path]:
    """List the files of `SOURCES` that a folder lacks."""
    return [folder / source.path for source in SOURCES.values() if not (folder / source.path).is_file()]

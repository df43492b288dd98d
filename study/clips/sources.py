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


SOURCES = {
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


def missing_files(folder: Path) -> list[Path]:
    """List the files of `SOURCES` that a folder lacks."""
    return [folder / source.path for source in SOURCES.values() if not (folder / source.path).is_file()]

"""Draw the README's picture: the sample clip at 65 %, evenly and guided.

Usage: python tools/make_readme_picture.py
"""

from __future__ import annotations

from pathlib import Path

import retime
from retime.search.keytimes import as_keytimes

PLACE = Path(__file__).resolve().parents[1] / "docs" / "images" / "jump.svg"


def main() -> None:
    """Write docs/images/jump.svg."""
    clip = retime.sample()
    guided = retime.guided_warp(clip, length="65%").warp
    warps = {"linear": retime.linear_warp(as_keytimes(clip, "65%", ())), "guided": guided}
    PLACE.parent.mkdir(parents=True, exist_ok=True)
    retime.plot_warps(warps, motion=clip, path=PLACE, title="The sample clip, shortened to 65 %", overwrite=True)


if __name__ == "__main__":
    main()

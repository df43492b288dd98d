"""Which slider does what: the pictures of docs/choosing.md, each with a check of what it shows.

Usage: python examples/choosing.py [FOLDER] (default: docs/images/choosing)
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import retime
from retime.evaluate.metrics.flights import flight_spans, flight_timing
from retime.evaluate.metrics.walking import step_spread, walk_speeds, walked_steps, walking_spans

ROOT = Path(__file__).resolve().parents[1]
CLIP = retime.sample()
FLIGHTS, WALKS = flight_spans(CLIP), walking_spans(walked_steps(CLIP))
# Nothing but walking: nothing in it can give way.
WALK = CLIP.frames(round(WALKS[0][0] * 60) - 6, round(WALKS[0][1] * 60))


def evenness() -> dict[str, retime.Warp]:
    """Share the hurry: half the length, with evenness 0 and 4."""
    found = {
        f"evenness {weight:g}": retime.guided_warp(CLIP, length="50%", evenness=weight).warp for weight in (0.0, 4.0)
    }
    fastest = [walks.high for warp in found.values() if (walks := walk_speeds(warp, WALKS)) is not None]
    # Without it some of the walk runs at more than three times its speed.
    assert fastest[0] > 3 > 2.5 > fastest[1]
    return found


def keep_jumps() -> dict[str, retime.Warp]:
    """Keep jumps: two fifths of the length, with 0 and 24."""
    found = {
        f"keep jumps {weight:g}": retime.guided_warp(CLIP, length="40%", keep_flights=weight).warp
        for weight in (0.0, 24.0)
    }
    hurried, kept = (flight_timing(warp, FLIGHTS) for warp in found.values())
    assert hurried.slowest > 1.5
    assert abs(kept.fastest - 1) < 0.02
    return found


def fine_steps() -> dict[str, retime.Warp]:
    """Slow a walk that never rests: quarters of its speed, or twelfths."""
    found = {
        name: retime.guided_warp(WALK, length="125%", upsample=upsample).warp
        for name, upsample in (("upsample 4", 4), ("as it is", None))
    }
    quarters, twelfths = (step_spread(warp, walked_steps(WALK)) for warp in found.values())
    assert quarters is not None
    assert twelfths is not None
    assert twelfths < quarters / 2
    return found


PICTURES: dict[str, tuple[Callable[[], dict[str, retime.Warp]], retime.Motion]] = {
    "evenness": (evenness, CLIP),
    "keep-jumps": (keep_jumps, CLIP),
    "fine-steps": (fine_steps, WALK),
}


def main() -> None:
    """Draw all of them."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "choosing"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (draw, motion) in PICTURES.items():
        title = (draw.__doc__ or name).splitlines()[0].rstrip(".")
        retime.plot_warps(draw(), motion=motion, path=folder / f"{name}.svg", title=title, overwrite=True)
        print(f"{name}: {title}")


if __name__ == "__main__":
    main()

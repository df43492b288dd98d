"""``python -m study.footage``: measures what a warp from footage alone does, and draws it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from retime.errors import RetimeError
from study.footage.ball import spans, write_ball
from study.footage.measure import LENGTHS, measure_ball, measure_take, tables
from study.footage.picture import draw

_SHOWN = "65%"


def main() -> None:
    """Measure, print the tables, and write the pictures."""
    parser = argparse.ArgumentParser(prog="python -m study.footage", description=__doc__)
    parser.add_argument("--take", metavar="VIDEO", type=Path, help="a real clip, beside the made one")
    parser.add_argument("--out", metavar="DIR", type=Path, default=Path("out/footage"), help="folder for the pictures")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    try:
        made = write_ball(given.out / "ball.mp4")
        ball = measure_ball(made)
        take = [] if given.take is None else measure_take(given.take)
        print(tables(ball, take))
        place = LENGTHS.index(_SHOWN)
        draw(given.out / "footage_ball.png", made, ball[place].warp, spans(), f"A ball, at {_SHOWN} of its length")
        if take:
            title = f"A man on a balance beam, at {_SHOWN} of its length"
            draw(given.out / "footage_take.png", given.take, take[place].warp, (), title)
    except RetimeError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()

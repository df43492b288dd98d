"""Make the sample clip: a figure that stands, walks, pauses, crouches and jumps with true ballistic flight, twice.

``python tools/make_sample.py OUT.bvh`` writes the clip, and beside it its phases, ``OUT_phases.json``; without a name,
the files that retime ships. Its parts are in `sample_clip/`.

Nothing here is captured, or posed by hand frame by frame. The plan (`sample_clip/plan.py`) says when and where the
feet stand. From it follow:

1. the feet: a sole rolls over its heel, stands flat, rolls over its ball, and swings to its next place;
2. the height of the centre of mass: in a jump, pieces whose force never leaps, and an exact parabola in flight;
   elsewhere the height at which the knees bend as knees do in walking;
3. its path over the ground: a pendulum over the centre of pressure (`pendulum`), one linear system for the whole clip,
   so that the shift of weight before a step, braking, and the lean into a jump come out by themselves;
4. trunk, head and arms: curves over the plan's times, swings that answer the feet, a little sway and breath;
5. the root: moved in each frame until the whole body's centre of mass is where 2 and 3 want it, the legs reaching for
   the feet; in flight the legs tuck, and the body turns so that its angular momentum stays put.

1 to 5 depend on each other, so `solve` goes round a few times. Work is done at four times the clip's rate, in
centimetres, degrees and seconds; Y is up, the figure faces +Z, left is +X. Feet pitch with the toes up, the trunk
pitches forward.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from sample_clip.body import NAMES, SKELETON
from sample_clip.plan import FINE, JUMPS, N_FRAMES, RATE, WALKS
from sample_clip.solve import solve

from retime.formats.registry import write
from retime.motion.motion import Declaration, Motion

SHIPPED = Path(__file__).resolve().parents[1] / "src" / "retime" / "data" / "sample.bvh"


def phases() -> list[dict[str, str | int]]:
    """Return what happens from which frame to which, both included; in flight both feet are off the ground."""
    starts: list[tuple[str, float]] = [("stand", 0.0)]
    for walk, jump in zip(WALKS, JUMPS, strict=True):
        starts.append(("walk", walk[0].lift - walk[0].roll))
        if jump.dip - walk[-1].strike > 0.3:
            starts.append(("pause", walk[-1].strike + 0.15))
        # Take-off is the last frame on the ground, touchdown the first.
        starts += [("crouch", jump.dip), ("push", jump.bottom), ("flight", jump.takeoff + 1 / RATE)]
        starts += [("land", jump.touchdown), ("pause" if jump is not JUMPS[-1] else "stand", jump.stand)]
    first = [round(t * RATE) for _, t in starts]
    last = [frame - 1 for frame in first[1:]] + [N_FRAMES - 1]
    return [
        {"name": name, "first_frame": a, "last_frame": b} for (name, _), a, b in zip(starts, first, last, strict=True)
    ]


def main(argv: Sequence[str]) -> None:
    """Write the clip and its phases."""
    path = Path(argv[0]) if argv else SHIPPED
    fine, angles = solve()
    rotations = ("Zrotation", "Yrotation", "Xrotation")
    moves = ("Xposition", "Yposition", "Zposition")
    clip = Motion(
        SKELETON,
        fine.rotations[::FINE],
        fine.local_translations[::FINE],
        rate=Fraction(RATE),
        name="sample",
        declaration=Declaration("bvh", ((*moves, *rotations), *[rotations] * (len(NAMES) - 1))),
        declared_angles=np.radians(np.stack([angles[name][::FINE] for name in NAMES], axis=1)),
    )
    write(clip, path, overwrite=True)
    lines = ",\n".join(f"  {json.dumps(phase)}" for phase in phases())
    path.with_name(f"{path.stem}_phases.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])

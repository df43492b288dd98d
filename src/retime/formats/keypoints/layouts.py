"""The points of a body, and the order in which programs write them; all by names in words, sides first."""

from __future__ import annotations


def _sided(text: str) -> tuple[str, ...]:
    """Write out names: ``R.`` and ``L.`` stand for the sides."""
    return tuple(name.replace("R.", "right_").replace("L.", "left_") for name in text.split())


BODY_25 = _sided(
    "nose neck R.shoulder R.elbow R.wrist L.shoulder L.elbow L.wrist mid_hip R.hip R.knee R.ankle L.hip L.knee L.ankle "
    "R.eye L.eye R.ear L.ear L.big_toe L.small_toe L.heel R.big_toe R.small_toe R.heel"
)
COCO_18 = _sided(
    "nose neck R.shoulder R.elbow R.wrist L.shoulder L.elbow L.wrist R.hip R.knee R.ankle L.hip L.knee L.ankle R.eye "
    "L.eye R.ear L.ear"
)
COCO_17 = _sided(
    "nose L.eye R.eye L.ear R.ear L.shoulder R.shoulder L.elbow R.elbow L.wrist R.wrist L.hip R.hip L.knee R.knee "
    "L.ankle R.ankle"
)
MPI_15 = _sided(
    "head neck R.shoulder R.elbow R.wrist L.shoulder L.elbow L.wrist R.hip R.knee R.ankle L.hip L.knee L.ankle chest"
)
MEDIAPIPE_33 = _sided(
    "nose L.eye_inner L.eye L.eye_outer R.eye_inner R.eye R.eye_outer L.ear R.ear mouth_left mouth_right L.shoulder "
    "R.shoulder L.elbow R.elbow L.wrist R.wrist L.pinky R.pinky L.index R.index L.thumb R.thumb L.hip R.hip L.knee "
    "R.knee L.ankle R.ankle L.heel R.heel L.foot_index R.foot_index"
)
HAND_21 = (
    "wrist",
    *(f"{finger}_{part}" for finger, parts in (
        ("thumb", ("cmc", "mcp", "ip", "tip")),
        ("index", ("mcp", "pip", "dip", "tip")),
        ("middle", ("mcp", "pip", "dip", "tip")),
        ("ring", ("mcp", "pip", "dip", "tip")),
        ("pinky", ("mcp", "pip", "dip", "tip")),
    ) for part in parts),
)  # fmt: skip

OPENPOSE = {25: ("BODY_25", BODY_25), 18: ("COCO", COCO_18), 17: ("COCO", COCO_17), 15: ("MPI", MPI_15)}
"""What OpenPose calls its models, and their points, by their count."""

MEDIAPIPE = {33: ("pose", MEDIAPIPE_33), 21: ("hand", HAND_21), 17: ("COCO", COCO_17)}
"""The same of MediaPipe, and of those that write as it does."""


def names_of(layouts: dict[int, tuple[str, tuple[str, ...]]], n_points: int) -> tuple[str, tuple[str, ...]]:
    """Return what a body of so many points is called, and its points; of one that nobody knows, numbers.

    Examples
    --------
    >>> names_of(OPENPOSE, 25)[0], names_of(OPENPOSE, 25)[1][:3], names_of(OPENPOSE, 2)
    ('BODY_25', ('nose', 'neck', 'right_shoulder'), ('2 points', ('point0', 'point1')))
    """
    return layouts.get(n_points, (f"{n_points} points", tuple(f"point{number}" for number in range(n_points))))

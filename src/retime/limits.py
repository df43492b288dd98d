"""The most there can be of things, for those who must know it without loading NumPy, as the help does."""

MAX_STEP = 255
"""The longest step of a path, in frames: kernels keep a step's place in a byte, and a path that is as short as its
longest step in a few arrays."""

MOST_SECONDS = 1e7
"""No time of a clip, an output or a warp is further from 0: four months."""

LEAST_GAP = 1e-9
"""Seconds between two knots of a warp; the speed between closer ones would be made of rounding errors."""

MOST_FRAMES = 10_000_000
"""Frames of a motion or signal."""

MOST_JOINT_POSES = 1 << 26
"""Frames times joints of a motion that is read."""

MOST_NUMBERS = 1 << 28
"""Of an output that a warp makes, where it is not of a clip of that size: so many doubles are 2.1 GB."""

LEAST_WEIGHT, MOST_WEIGHT = 1e-9, 1e9
"""Of references, joints and channels, and of their scales: beyond, scores would overflow, or be all the same."""

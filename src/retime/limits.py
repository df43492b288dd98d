"""What the kernels can hold, for those who must know it without loading them (or NumPy), as the help does."""

MAX_STEP = 255
"""The longest step of a path, in frames: kernels keep a step's place in a byte, and a path that is as short as its
longest step in a few arrays."""

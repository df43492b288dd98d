"""What means over windows of frames weigh."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray, IntArray


def window_weights(frames: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Weight of frames in the means over windows: the areas, inside the window, of the hats that stand on them."""
    a, b = np.clip(low - frames, -1.0, 1.0), np.clip(high - frames, -1.0, 1.0)
    # From a to b: 1 + x where x < 0, 1 - x where x > 0. Each side is a width times its middle's height.
    left, right = np.minimum(b, 0.0) - np.minimum(a, 0.0), np.maximum(b, 0.0) - np.maximum(a, 0.0)
    area = left * (1.0 + (np.minimum(a, 0.0) + np.minimum(b, 0.0)) / 2)
    area += right * (1.0 - (np.maximum(a, 0.0) + np.maximum(b, 0.0)) / 2)
    return np.asarray(area / (high - low))

"""Whether a warp does what its keytimes say."""

from __future__ import annotations

from retime.evaluate.metrics.keytimes import match_keytimes
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime


def keys(*pairs: tuple[float, float]) -> list[Keytime]:
    """Keytimes by input and output time."""
    return [Keytime(input_time=a, output_time=b) for a, b in pairs]


def test_keytimes_are_met_or_missed_by_seconds() -> None:
    warp = Warp([0.0, 2.0], [0.0, 4.0])
    met = match_keytimes(warp, keys((0.0, 0.0), (2.0, 1.0), (4.0, 2.0)))
    assert (met.n_keytimes, met.largest_error) == (3, 0.0)
    assert match_keytimes(warp, keys((0.0, 0.0), (2.5, 1.0), (4.0, 2.0))).largest_error == 0.5
    assert match_keytimes(warp, keys((0.0, 0.0), (4.0, 2.5))).largest_error == 0.5

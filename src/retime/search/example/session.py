"""The search that follows a hand's speeds: the session's own, with another price and no scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.kernels import StepPairs
from retime.motion.any_motion import AnyMotion
from retime.search.example.prices import hand_prices
from retime.search.example.reading import ExampleReading
from retime.search.grid import hand_grid
from retime.search.plan import Request, SearchPlan
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.search.score import Model
from retime.search.session import Session
from retime.search.wishes.locks import Lock


class HandSession(Session):
    """A motion that should play as a hand played a stretch of it.

    Keytimes, locks, limits and lengths are the session's; what a path costs is how far its speeds are from the hand's.

    Parameters
    ----------
    motion : Motion, Signal, array, or sequence of clips
        The input.
    example : Reference
        The stretch, at its own timing: what output frames are matched with in `GuidedWarp.explain`.
    reading : ExampleReading
        What it says of the input.
    **given
        Options of the stage "analysis" in `retime.search.options`.
    """

    def __init__(
        self,
        motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
        *,
        example: Reference,
        reading: ExampleReading,
        **given: Any,
    ) -> None:
        super().__init__(motion, reference=example, **given)
        self._reading = reading

    def solve(
        self, *, keys: Sequence[str | Sequence[float | str | None]] = (), locks: Sequence[Lock | str] = (), **given: Any
    ) -> GuidedWarp:
        """Find the warp; see `Session.solve`."""
        found = super().solve(keys=keys, locks=locks, **given)
        # Nothing is hurried evenly or kept in flight here: the price is the hand's.
        return replace(found, example=self._reading, tempo=None)

    def _request(
        self, keys: Sequence[str | Sequence[float | str | None]], locks: Sequence[Lock | str], chosen: dict[str, Any]
    ) -> Request:
        grid = hand_grid(self._reading.log_speeds, self.motion.end_time)
        return replace(super()._request(keys, locks, chosen), hand=grid, evenness=0.0, keep_flights=0.0)

    def _triples(self, poses: FloatArray, steps: StepPairs, model: Model) -> FloatArray:
        # The example says how fast; nothing is left for scores to say.
        return np.zeros((len(poses), steps.n_pairs))

    def _score_seconds(self, n_input: int, n_pairs: int) -> float:
        return 0.0

    def _step_prices(self, plan: SearchPlan, steps: StepPairs) -> FloatArray:
        return hand_prices(self._reading, self.tempo, plan.reduction, steps)

    def _smoothness_unit(self) -> float:
        return self.tempo.scale or 1.0

    def _is_neutral(self, plan: SearchPlan, free_weight: str) -> bool:
        # The price counts input time already: it favours neither short results nor long ones.
        return False

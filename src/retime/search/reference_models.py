"""The references of a search as models, at each rate that it looks at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.errors import OptionError
from retime.search.poses.references import PoseTracks
from retime.search.poses.spaces import timing_features
from retime.search.reference_tempo import at_tempo, tempo_ratio
from retime.search.score import Model, build_model, without_copies


class ReferenceModels:
    """The references as a search sees them, built once for each rate.

    Parameters
    ----------
    references : sequence of PoseTracks
        What is learned from.
    alike : PoseTracks, optional
        The input, to whose tempo the references are brought; left out, they keep their own.
    rate : float
        Analysis rate, Hz.
    time_scale : float
        Seconds, at that rate.
    low_pass : float
        Hz; 0 is none.
    n_neighbors : int
        Frames that a triple is compared with.
    own_name : str
        The name of the input, where it is its own reference.

    Attributes
    ----------
    tempo_ratio : float
        How many times as fast the input moves as its reference, by the model that was built last; 1 where that was not
        asked for.
    """

    def __init__(
        self,
        references: Sequence[PoseTracks],
        *,
        alike: PoseTracks | None,
        rate: float,
        time_scale: float,
        low_pass: float,
        n_neighbors: int,
        own_name: str,
    ) -> None:
        self._references, self._alike = references, alike
        self._rate, self._time_scale, self._low_pass = rate, time_scale, low_pass
        self._n_neighbors, self._own_name = n_neighbors, own_name
        self.tempo_ratio = 1.0
        self._models: dict[float, Model] = {}

    def at(self, rate: float) -> Model:
        """Return the references as they are seen at a rate (Hz); raise OptionError where they have too few frames."""
        if rate not in self._models:
            # The paper's features count in frames: at a lower rate its time scale is as much longer.
            time_scale = self._time_scale if rate == self._rate else self._time_scale * self._rate / rate
            every = build_model(
                [track.at_rate(rate, self._low_pass) for track in self._references],
                rate=rate,
                time_scale=time_scale,
                n_neighbors=self._n_neighbors,
                weights=[track.weight for track in self._references],
                own_name=self._own_name,
            )
            every = self._without_lost(every, rate)
            if self._alike is not None:
                own = self._alike.at_rate(rate, self._low_pass) - every.origin
                if len(own) > 2:
                    features = timing_features(own, rate=rate, time_scale=time_scale)
                    self.tempo_ratio = tempo_ratio(features, every)
                    every = at_tempo(every, self.tempo_ratio)
            self._models[rate] = without_copies(every, self._n_neighbors)
        return self._models[rate]

    def coarse(self, rate: float) -> Model:
        """Return the references as the heuristic's coarse search sees them; raise OptionError as `at`."""
        try:
            return self.at(rate)
        except OptionError:
            # There are frames enough at the analysis rate, or this would not be reached.
            raise OptionError(
                f"too few frames for the heuristic search, which looks at {rate:g} Hz first: take search='priced' "
                "(--search priced)",
                option="search",
            ) from None

    def _without_lost(self, model: Model, rate: float) -> Model:
        """Leave out frames of references of which something is lost, and those whose speed would be told by one."""
        lost = np.zeros(len(model.weights), dtype=bool)
        for place, track in enumerate(self._references):
            if track.has_gaps:
                rows = np.flatnonzero(model.reference == place)
                for beside in (-1, 0, 1):
                    lost[rows] |= track.missing_at((model.frame[rows] + beside) / rate)
        if not lost.any():
            return model
        if len(lost) - lost.sum() < self._n_neighbors:
            raise OptionError("too few frames of the reference are without gaps: bridge them (--gaps bridge:SECONDS)")
        return model.only(np.flatnonzero(~lost))

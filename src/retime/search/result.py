"""What a search gives back: the warp, and how it came about."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.contacts import Contacts
from retime.motion.signal import Signal
from retime.search.example.reading import ExampleReading
from retime.search.explain import Explanation, explain_path
from retime.search.path import FramePath
from retime.search.plan import SearchPlan
from retime.search.reduction import Reduction
from retime.search.score import Model, ScoreName
from retime.search.wishes.tempo import Tempo
from retime.svg import facts_html, stacked
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp


@dataclass(frozen=True, eq=False)
class GuidedWarp:
    """A guided warp, and how it came about.

    Attributes
    ----------
    warp : Warp
        The result: output time to input time, smooth.
    staircase : Warp
        The guided warp before smoothing and blending: the polyline through the frames of the path.
    path : FramePath
        The selected frames of the unrolled input, their scores and total.
    plan : SearchPlan
        What the search was offered, and the steps that it was allowed.
    tempo : Tempo or None
        How much the input moves and when it flies (`retime.search.wishes.tempo`); None where tempo had no price.
    tempo_prices : float array, shape (n_input, n_steps), or None
        The price of each step from each unrolled frame; where a hand's speeds were followed, what it costs to differ
        from them.
    reduction : Reduction
        The unrolled input; of a free length with the length that was found.
    model : Model
        The reference frames.
    references : tuple of str
        Names of the references.
    input_poses : float array, shape (n_input, n_numbers)
        Pose vectors of the unrolled input; their numbers are in no order of joints (`ModelPoses.in_own_order`).
    n_reference : int
        Reference frames at the analysis rate, of all references.
    n_neighbors : int
        As used.
    time_scale, low_pass : float
        As used; seconds and Hz.
    score : str
        Which local score: "joint" or "conditional".
    clips : tuple of Motion or Signal
        The input; more than one where it was a group. An array is a signal here.
    loop : bool
        Whether it was searched as a cycle.
    end_costs : (float, float)
        What the first and the last step cost by themselves, beside the scores of triples.
    example : ExampleReading, optional
        What an example said of the input, where `retime.imitate` carried over the speeds of a hand.
    given_up : tuple of str
        What the warp could not quite keep of what was asked for, in words: where keytimes, locks and limits leave no
        room, by no more than lengths and times are rounded. What is farther off is refused.
    excess : float, optional
        For the heuristic search: by what share its total exceeds the optimum.
    matched : int array, shape (n_output - 2,), optional
        Row of `model` that each inner frame was compared with, where it is not the score that chose: the warp keeps
        step with its reference.
    seconds : dict of str to float
        Time spent in each stage.
    """

    warp: Warp
    staircase: Warp
    path: FramePath
    plan: SearchPlan
    tempo: Tempo | None
    tempo_prices: FloatArray | None
    reduction: Reduction
    model: Model
    references: tuple[str, ...]
    input_poses: FloatArray
    n_reference: int
    n_neighbors: int
    time_scale: float
    low_pass: float
    score: ScoreName
    clips: tuple[AnyMotion, ...]
    loop: bool = False
    end_costs: tuple[float, float] = (0.0, 0.0)
    example: ExampleReading | None = None
    given_up: tuple[str, ...] = ()
    excess: float | None = None
    matched: IntArray | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        proof = "proved optimal" if self.path.optimal else "not proved optimal"
        return (
            f"GuidedWarp({self.n_output} of {self.n_input} frames at {self.rate:g} Hz, total {self.total:.6g}, "
            f"{proof}, warp={self.warp!r})"
        )

    @property
    def n_input(self) -> int:
        """Frames offered to the search."""
        return self.reduction.n_input

    @property
    def n_output(self) -> int:
        """Frames selected."""
        return self.reduction.n_output

    @property
    def max_skip(self) -> int:
        """Largest step that the search was allowed, in unrolled frames."""
        return self.plan.max_skip

    @property
    def upsample(self) -> int:
        """Unrolled input frames per analysis period, where there are most (`reduction.upsamples` has all spans)."""
        return self.reduction.upsample

    @property
    def rate(self) -> float:
        """Analysis rate, Hz."""
        return self.reduction.rate

    @property
    def total(self) -> float:
        """The objective (Eq. 1): sum of the path's scores."""
        return self.path.total

    @property
    def path_speeds(self) -> FloatArray:
        """Playback speed of each step of the path, shape (n_output - 1,); 0 in a hold, below 0 backward."""
        frames = self.path.frames
        change = np.diff(self.reduction.input_times[frames])
        moved = np.sign(change) * np.diff(frames) / self.reduction.upsample_at[frames[:-1]]
        return np.where(self.reduction.held[frames[:-1]], change * self.rate, moved)

    def apply(
        self,
        motion: AnyMotion | None = None,
        *,
        average: bool = True,
        contacts: Contacts | Literal["find"] | None = "find",
        keep_root_path: bool = True,
    ) -> AnyMotion:
        """Show the input, or another clip, with the timing that was found: `retime.apply_warp`.

        Parameters
        ----------
        motion : Motion or Signal, optional
            Left out, the input. Where that is a group, each of `clips` is to be named.
        average, contacts, keep_root_path
            As of `retime.apply_warp`. A loop stays one.

        Returns
        -------
        Motion or Signal
            A signal where the input was an array: its ``values`` are that array's, retimed.

        Raises
        ------
        OptionError
            The input is a group, and no clip is named.

        Examples
        --------
        >>> import numpy as np
        >>> from retime import guided_warp
        >>> shorter = guided_warp(np.sin(np.arange(120) ** 2 / 900), rate=30, length="75%").apply()
        >>> shorter.values.shape
        (90, 1)
        """
        if motion is None:
            if len(self.clips) > 1:
                raise OptionError(
                    f"the input was a group of {len(self.clips)} clips; name one: "
                    "[result.apply(clip) for clip in result.clips]"
                )
            (motion,) = self.clips
        # Two calls that look alike, so that types tell: apply_warp makes a motion of a motion, a signal of a signal.
        if isinstance(motion, Signal):
            return apply_warp(motion, self.warp, average=average, loop=self.loop)
        return apply_warp(
            motion,
            self.warp,
            average=average,
            contacts=contacts,
            keep_root_path=keep_root_path,
            loop=self.loop,
        )

    def explain(self) -> Explanation:
        """Say for each output frame what it scored, what it was matched with, and what was binding."""
        return explain_path(
            self.reduction,
            self.path,
            self.model,
            self.input_poses,
            self.plan.allowed,
            locked=self.plan.locked,
            references=self.references,
            n_neighbors=self.n_neighbors,
            score=self.score,
            step_prices=self._step_prices(),
            flying=self._flying(),
            matched=self.matched,
            end_costs=self.end_costs,
        )

    def _step_prices(self) -> FloatArray | None:
        """Return the price of each step of the path, shape (n_output - 1,); None where tempo had no price."""
        if self.tempo_prices is None:
            return None
        frames = self.path.frames
        return np.asarray(self.tempo_prices[frames[:-1], np.searchsorted(self.plan.steps.steps, np.diff(frames))])

    def _flying(self) -> BoolArray | None:
        """Say which steps of the path pass a flight that is to keep its speed, shape (n_output - 1,)."""
        if self.tempo is None:
            return None
        if not self.plan.request.keep_flights:
            return np.zeros(len(self.path.frames) - 1, dtype=np.bool_)
        flying = self.tempo.flying(self.reduction.input_times[self.path.frames]) > 0
        return flying[:-1] & flying[1:]

    def _repr_html_(self) -> str:
        facts = {
            "n_input": self.n_input,
            "n_output": self.n_output,
            "n_reference": self.n_reference,
            "max_skip": self.max_skip,
            "upsample": self.upsample,
            "rate": f"{self.rate:g} Hz",
            "total": f"{self.total:.6g}",
            "optimal": "proved" if self.path.optimal else "no",
            "seconds": f"{sum(self.seconds.values()):.3f}",
        }
        return stacked(self.warp._repr_html_(), facts_html(facts))

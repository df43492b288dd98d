"""The best path that there is, proved (§3.3)."""

from __future__ import annotations

from dataclasses import dataclass

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.kernels import StepPairs
from retime.search.path import FramePath, shortest_path
from retime.search.plan import SearchPlan
from retime.search.wishes.allowed import end_costs


@dataclass(frozen=True, eq=False)
class PathTask:
    """What a method is to find.

    Attributes
    ----------
    plan : SearchPlan
        The unrolled input, and the steps through it.
    costs : float array, shape (n_input, n_pairs)
        The scores of triples with all prices; inf where a wish forbids one.
    steps : StepPairs
        The pairs.
    first, last : float arrays, shape (n_steps,)
        Prices of the first step, which no triple holds, and of the last one.
    search : {"priced", "layered"}
        Which of the two exact searches.
    """

    plan: SearchPlan
    costs: FloatArray
    steps: StepPairs
    first: FloatArray
    last: FloatArray
    search: str = "priced"

    __repr__ = brief_repr

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """What the first and the last step cost; each of shape (n_steps,)."""
        start, end = end_costs(self.plan.allowed, self.steps)
        return start + self.first, end + self.last

    def through(
        self,
        anchors: tuple[tuple[int, int], ...] | None = None,
        *,
        start_cost: FloatArray | None = None,
        end_cost: FloatArray | None = None,
        band: IntArray | None = None,
    ) -> FramePath:
        """Find the best path through anchors (the plan's, where none are given), and within a band where there is one.

        Raises
        ------
        InfeasibleWarpError
            There is none.
        """
        start, end = self.ends
        return shortest_path(
            self.costs,
            steps=self.steps,
            n_output=self.plan.n_output,
            anchors=self.plan.anchors if anchors is None else anchors,
            start_cost=start if start_cost is None else start_cost,
            end_cost=end if end_cost is None else end_cost,
            search=self.search,
            band=band,
        )


def exact_path(task: PathTask) -> FramePath:
    """Find the best path; see `PathTask.through`."""
    return task.through()

"""The steps that a path may take, and which of them may follow which: what scores and searches are laid out by."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from retime.arrays import IntArray
from retime.errors import OptionError
from retime.limits import MAX_STEP


@dataclass(frozen=True, eq=False)
class StepPairs:
    """Steps in rising order, and the pairs of a step into a frame and one out of it that a path may take there.

    The scores of a frame stand one after another: by the step before, then by the step after. With `up_to(s)` that is
    the layout of an array (s, s).

    Attributes
    ----------
    steps : int array, shape (n_steps,)
        In frames, the shortest first.
    first, end : int arrays, shape (n_steps,)
        After step ``steps[a]`` come ``steps[first[a]:end[a]]``. Neither goes down.

    Examples
    --------
    >>> pairs = StepPairs.of([1, 2, 4, 8], ratio=2)
    >>> list(zip(pairs.steps[pairs.before].tolist(), pairs.steps[pairs.after].tolist()))
    [(1, 1), (1, 2), (2, 1), (2, 2), (2, 4), (4, 2), (4, 4), (4, 8), (8, 4), (8, 8)]
    """

    steps: IntArray
    first: IntArray
    end: IntArray

    @classmethod
    def up_to(cls, max_skip: int) -> StepPairs:
        """Return all steps from 1 to `max_skip`, each of which may follow each."""
        return cls.of(range(1, max_skip + 1))

    @classmethod
    def of(cls, steps: Iterable[int], ratio: float = math.inf) -> StepPairs:
        """Return steps of which neighbours differ by no more than a ratio.

        Parameters
        ----------
        steps : iterable of int
            In frames, in rising order, from 1 to 255.
        ratio : float
            The longer of two neighbours may be so many times the shorter; at least 1.

        Raises
        ------
        OptionError
            No step, steps out of range or order, or a ratio below 1.
        """
        rising = [int(step) for step in steps]
        if not rising or rising[0] < 1 or rising[-1] > MAX_STEP or sorted(set(rising)) != rising:
            raise OptionError(f"steps must rise, from 1 or more to at most {MAX_STEP}; found {rising}")
        if not ratio >= 1:
            raise OptionError(f"the ratio of neighbouring steps must be at least 1, found {ratio:g}")
        array = np.array(rising, dtype=np.int64)
        # A ratio that is meant exactly is not missed by a rounding.
        wide = ratio * (1 + 1e-12)
        first = np.searchsorted(array * wide, array, side="left")
        end = np.searchsorted(array, array * wide, side="right")
        return cls(array, first.astype(np.int64), end.astype(np.int64))

    @property
    def n_steps(self) -> int:
        """How many steps there are."""
        return len(self.steps)

    @cached_property
    def n_pairs(self) -> int:
        """How many pairs there are, and so scores a frame."""
        return int((self.end - self.first).sum())

    @property
    def shortest(self) -> int:
        """The shortest step."""
        return int(self.steps[0])

    @property
    def longest(self) -> int:
        """The longest step."""
        return int(self.steps[-1])

    @cached_property
    def every(self) -> bool:
        """Whether these are all steps from 1 on, each of which may follow each."""
        return self.longest == self.n_steps and self.n_pairs == self.n_steps**2

    @cached_property
    def before(self) -> IntArray:
        """For each pair the place of its first step, shape (n_pairs,)."""
        return np.repeat(np.arange(self.n_steps), self.end - self.first)

    @cached_property
    def after(self) -> IntArray:
        """For each pair the place of its second step, shape (n_pairs,)."""
        return np.concatenate([np.arange(*ends) for ends in zip(self.first, self.end, strict=True)]).astype(np.int64)

    @cached_property
    def table(self) -> IntArray:
        """What the compiled kernels take, shape (3, n_steps)."""
        return np.ascontiguousarray([self.steps, self.first, self.end])

    def pair_of(self, before: IntArray, after: IntArray) -> IntArray:
        """Return the places among the pairs of steps given in frames; -1 where there is no such pair."""
        places = np.full((self.longest + 1, self.longest + 1), -1)
        places[self.steps[self.before], self.steps[self.after]] = np.arange(self.n_pairs)
        inside = (before >= 1) & (before <= self.longest) & (after >= 1) & (after <= self.longest)
        return np.where(inside, places[np.where(inside, before, 0), np.where(inside, after, 0)], -1)

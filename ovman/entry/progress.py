"""Lines on how far runs have come."""

from __future__ import annotations

import time
from collections.abc import Callable

from ovman.progress import clock
from ovman.records.run import Score


class Progress:
    """Lines on how far an evaluation of `total` runs is: runs done, success so far, time left as runs have taken until now."""

    def __init__(self, total: int, say: Callable[[str], None]) -> None:
        self.done, self._total, self._say = 0, total, say
        self._successes, self._made, self._begun = 0, 0, time.monotonic()

    def had(self, run: Score) -> None:
        """A run that was there."""
        self.done, self._successes = self.done + 1, self._successes + run.success

    def resumed(self) -> None:
        """All runs that were there are counted."""
        if self.done:
            self._say(f"{self.done} of {self._total} runs are there already")

    def made(self, run: Score) -> None:
        """A run that was made now."""
        self.had(run)
        self._made += 1
        left_s = (time.monotonic() - self._begun) / self._made * (self._total - self.done)
        ended = f"{run.outcome} after {run.actions} actions, {'success' if run.success else 'failure'}"
        so_far = f"success so far {self._successes / self.done:.3f}, {clock(left_s)} left"
        self._say(f"{self.done}/{self._total} {run.episode} seed {run.seed}: {ended}; {so_far}")

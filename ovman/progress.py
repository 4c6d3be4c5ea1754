"""Progress lines in the log of a job."""

from __future__ import annotations

import time
from collections.abc import Callable

KEPT_S = 0.01
"""An item that took less was read from the cache and does not count in the mean time."""


class Units:
    """Progress lines of a job: the number of a finished work item, its result, and the remaining time.

    total: number of items. The remaining time counts the mean time of computed items for each item that is left. clock: seconds.
    """

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._total, self._clock = total, clock
        self._done, self._made, self._spent_s, self._last = 0, 0, 0.0, clock()

    def done(self, said: str) -> None:
        """Print the line of one more item."""
        now = self._clock()
        took_s, self._last = now - self._last, now
        self._done += 1
        if took_s >= KEPT_S:
            self._made, self._spent_s = self._made + 1, self._spent_s + took_s
        left_s = self._spent_s / max(self._made, 1) * (self._total - self._done)
        print(f"{self._done}/{self._total} {said}; {clock(left_s)} left", flush=True)


def clock(seconds: float) -> str:
    """Return hours, minutes and seconds: 0:01:05."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"

"""Progress lines in the log of a job."""

from __future__ import annotations

import time
from datetime import timedelta

KEPT_S = 0.01
"""An item that took less was read from the cache and does not count in the mean time."""


class Units:
    """Progress lines of a job: the number of a finished work item, its result, and the remaining time.

    The remaining time counts the mean time of computed items for each item that is left of `total`.
    """

    def __init__(self, total: int) -> None:
        self._total, self._done, self._made, self._spent_s, self._last = total, 0, 0, 0.0, time.monotonic()

    def done(self, said: str) -> None:
        """Print the line of one more item."""
        took_s, self._last = time.monotonic() - self._last, time.monotonic()
        self._done += 1
        if took_s >= KEPT_S:
            self._made, self._spent_s = self._made + 1, self._spent_s + took_s
        left_s = self._spent_s / max(self._made, 1) * (self._total - self._done)
        print(f"{self._done}/{self._total} {said}; {clock(left_s)} left", flush=True)


def clock(seconds: float) -> str:
    """Return hours, minutes and seconds: 0:01:05."""
    return str(timedelta(seconds=round(seconds)))

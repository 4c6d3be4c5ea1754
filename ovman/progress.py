"""Lines in a job's log on how far it is."""

from __future__ import annotations

import time
from collections.abc import Callable

KEPT_S = 0.01
"""A unit that took less was read from where it was kept, and says nothing of how long others take."""


class Units:
    """A line for each unit of a job when it is done: its number, what became of it, and the time that is left.

    total: how many there are. The time left is that of the units that were made, each as long as the mean until now. clock: in
    seconds, from any moment.
    """

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._total, self._clock = total, clock
        self._done, self._made, self._spent_s, self._last = 0, 0, 0.0, clock()

    def done(self, said: str) -> None:
        """Print the line of one more unit."""
        now = self._clock()
        took_s, self._last = now - self._last, now
        self._done += 1
        if took_s >= KEPT_S:
            self._made, self._spent_s = self._made + 1, self._spent_s + took_s
        left_s = self._spent_s / max(self._made, 1) * (self._total - self._done)
        print(f"{self._done}/{self._total} {said}; {clock(left_s)} left", flush=True)


def clock(seconds: float) -> str:
    """Hours, minutes and seconds: 0:01:05."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"

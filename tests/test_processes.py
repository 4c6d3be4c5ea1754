"""Work shared out among processes."""

from __future__ import annotations

import os
import signal
from functools import partial

import pytest

from ovman.processes import WorkerDied, map_items


def double(number: int) -> tuple[int, int]:
    return 2 * number, os.getpid()


def fail(number: int, at: int) -> int:
    if number == at:
        raise ValueError(f"{number} is wrong")
    return number


def die(number: int, at: int) -> int:
    if number == at:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("workers", [1, 2, 9])
def test_results_have_the_order_of_the_items(workers: int) -> None:
    found = map_items(double, [3, 1, 2], workers)
    assert [value for value, _ in found] == [6, 2, 4]
    assert (os.getpid() in {process for _, process in found}) == (workers == 1)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_is_raised_as_it_was(workers: int) -> None:
    with pytest.raises(ValueError, match="2 is wrong"):
        map_items(partial(fail, at=2), [1, 2, 3], workers)


def test_a_killed_worker_is_one_line() -> None:
    with pytest.raises(WorkerDied, match="was killed"):
        map_items(partial(die, at=2), [1, 2, 3], 2)

"""Map the work items of a job over processes, and print its progress."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from datetime import timedelta
from typing import TypeVar

HOST = re.sub(r"[^A-Za-z0-9-]", "-", os.uname().nodename)
"""The name of this machine, in letters that a file's name may have and without a full stop."""

WATCH_S = 0.2
"""Seconds between two looks at whether the parent of a process lives."""

Item = TypeVar("Item")
Result = TypeVar("Result")


class WorkerDied(RuntimeError):
    """A worker process was killed, by the system for its memory or by the code that it ran."""

    says_all = True


def map_items(function: Callable[[Item], Result], items: Sequence[Item], workers: int) -> list[Result]:
    """Return `function(item)` of each item, in the order of the items. Arguments and errors as for `iter_items`."""
    return list(iter_items(function, items, workers))


def iter_items(function: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Iterator[Result]:
    """Yield `function(item)` of each item, in the order of the items, each as soon as it and those before it are done.

    Args:
        function: Picklable, as are items and results if there are several workers.
        items: What to work on, such as scenes. A worker takes the next one when it is done with one.
        workers: Number of processes. One worker, or one item, is done in this process.

    Raises:
        WorkerDied: A worker was killed. Other exceptions are those of `function`.
    """
    workers = min(workers, len(items))
    if workers < 2:
        yield from map(function, items)
        return
    context = multiprocessing.get_context("fork")  # a spawned process would run the script of the job again
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin) as pool:
        try:
            yield from pool.map(function, items)
        except BrokenProcessPool:
            says = "a worker process was killed; the log's last lines name its work"
            raise WorkerDied(f"{says}; finished work is kept, and the same command goes on") from None
        except BaseException:
            for process in multiprocessing.active_children():  # else the end waits for items that are under way
                process.terminate()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _begin() -> None:
    """Prepare a worker: Ctrl-C is meant for its parent, and it ends when its parent does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


def end_with_parent() -> None:
    """End this process soon after its parent: what a killed Snakemake or job has started must not write any more."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH_S)
        os._exit(1)

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()


def alive(process: int) -> bool:
    """Return whether a process of that id runs on this machine."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


KEPT_S = 0.01
"""An item that took less was read from the cache and does not count in the mean time."""


class Step(str):
    """A line of progress that also knows how far the work is: `done` of `total`, and what it says without these numbers."""

    done: int
    total: int
    said: str

    def __new__(cls, done: int, total: int, said: str) -> Step:
        """Return the line "done/total said"."""
        made = str.__new__(cls, f"{done}/{total} {said}")
        made.done, made.total, made.said = done, total, said
        return made


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

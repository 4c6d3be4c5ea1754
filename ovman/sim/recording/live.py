"""Replays a recorded session on a running simulator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.comparison import Difference, differences
from ovman.sim.recording.file import Call, Recording
from ovman.sim.recording.recorder import called


def replayed(recording: Recording, backend: str, begin: controller.Start | None = None) -> Iterator[Difference]:
    """The differences between the recorded answers and those of `backend` to the same calls.

    An exception that ends the simulator is raised.
    """
    made: Any = None
    try:
        for line, recorded in recording.calls():
            if recorded.call == "start":
                if made is not None:
                    made.stop()
                asked = recorded.arguments
                made = (begin or controller.start)(backend, asked["scene"], Embodiment(**asked["embodiment"]))
            yield from differences(line, recorded, _answer(made, recorded))
    finally:
        if made is not None:
            with suppress(OSError):
                made.stop()


def _answer(made: Any, recorded: Call) -> Call:
    arguments = dict(recorded.arguments)
    entry, answer = called(
        recorded.call,
        arguments,
        lambda: made.last_event if recorded.call == "start" else getattr(made, recorded.call)(**arguments),
    )
    if isinstance(answer, Exception) and controller.ended(made):
        raise answer
    return entry

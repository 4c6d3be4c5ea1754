"""A recorded session asked again of a simulator that runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.comparison import Difference, differences
from ovman.sim.recording.file import Call, Tape
from ovman.sim.recording.recorder import called


def replayed(tape: Tape, backend: str, begin: controller.Start | None = None) -> Iterator[Difference]:
    """What `backend` answers otherwise than recorded, when it is asked the same. What ends the simulator ends the replay."""
    made: Any = None
    try:
        for line, recorded in tape.calls():
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

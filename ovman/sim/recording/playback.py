"""A Controller without a simulator: it answers from a recorded session.

A call that equals the next recorded call gets its recorded answer. A recording has no pictures: frames are black, depth images
have the recorded depth of the centre everywhere, and masks have the recorded sizes but not the shapes.
"""

from __future__ import annotations

import builtins
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.file import Call, Recording, RecordingError
from ovman.sim.recording.recorder import plain


class Playback:
    """Replaces the Controller of a recorded session.

    RecordingError, in one line, for a call that differs from the recorded one.
    """

    def __init__(self, recording: Recording) -> None:
        self._calls = recording.calls()
        self.last_event: Any = None

    def start(self, backend: str, scene: str, embodiment: Embodiment) -> Playback:
        """Replaces `controller.start`: answers the recorded start. backend: ignored, the recording has its own."""
        self._answer("start", {"scene": scene, "embodiment": asdict(embodiment)})
        return self

    def reset(self, scene: str, **arguments: Any) -> Any:
        """The recorded event of this reset."""
        return self._answer("reset", {"scene": scene, **arguments})

    def step(self, action: str, **arguments: Any) -> Any:
        """The recorded event of this step."""
        return self._answer("step", {"action": action, **arguments})

    def stop(self) -> None:
        """Do nothing: no simulator runs."""

    def rest(self) -> int:
        """Number of recorded calls that were not made."""
        return sum(1 for _ in self._calls)

    def _answer(self, call: str, arguments: Mapping[str, Any]) -> Any:
        asked = Call(call, plain(arguments), None, {})
        line, recorded = next(self._calls, (0, None))
        if recorded is None:
            raise RecordingError(f"the recording ends before {asked.asked}; record it anew with this version")
        if (recorded.call, recorded.arguments) != (asked.call, asked.arguments):
            raise RecordingError(f"line {line}: {recorded.asked} was recorded and {asked.asked} is asked; record it anew")
        if recorded.error is not None:
            kind, message = recorded.error
            raise _exception(kind)(message)
        self.last_event = event(recorded)
        return self.last_event


def _exception(kind: str) -> type[Exception]:
    known = getattr(builtins, kind, RuntimeError)
    return known if isinstance(known, type) and issubclass(known, Exception) else RuntimeError


def event(recorded: Call) -> Any:
    """The client's own event of a recorded answer."""
    from ai2thor.server import Event

    made = Event(plain(recorded.metadata))
    if recorded.pictures:
        shape = made.screen_height, made.screen_width
        made.frame = np.zeros((*shape, 3), np.uint8)
        if "depth" in recorded.pictures:
            made.depth_frame = np.full(shape, recorded.pictures["depth"][1], np.float32)
        made.instance_masks = Masks(shape, recorded.pictures.get("masks", {}))
    return made


class Masks(Mapping[str, np.ndarray]):
    """Masks of given sizes, one after the other along the rows of the picture. Has the method `mask` of the client's masks."""

    def __init__(self, shape: tuple[int, int], sizes: Mapping[str, int]) -> None:
        self._shape, self._sizes = shape, sizes
        self._begins = dict(zip(sizes, np.cumsum([0, *sizes.values()]).tolist(), strict=False))

    def __getitem__(self, name: str) -> np.ndarray:
        mask = np.zeros(self._shape[0] * self._shape[1], bool)
        begin = self._begins[name]
        mask[begin : begin + self._sizes[name]] = True
        return mask.reshape(self._shape)

    def __iter__(self) -> Iterator[str]:
        return iter(self._sizes)

    def __len__(self) -> int:
        return len(self._sizes)

    def mask(self, name: str, default: np.ndarray | None = None) -> np.ndarray | None:
        """The mask (H, W) of an object, or `default` where it has none; as in the client."""
        return self.get(name, default)

"""A Controller that records every call and its answer."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.file import Call, Writer


class Recorder:
    """Wraps a Controller and records every call with its answer. Has the methods that `ovman.sim.session.Session` calls."""

    def __init__(self, made: Any, writer: Writer) -> None:
        self._made, self._writer = made, writer
        self.server = made.server

    @staticmethod
    def start(writer: Writer, begin: controller.Start | None = None) -> controller.Start:
        """A function that starts a simulator like `controller.start`, or like `begin`, and records its calls."""

        def start(backend: str, scene: str, embodiment: Embodiment) -> Recorder:
            made = (begin or controller.start)(backend, scene, embodiment)
            writer.write(called("start", {"scene": scene, "embodiment": asdict(embodiment)}, lambda: made.last_event)[0])
            return Recorder(made, writer)

        return start

    @property
    def last_event(self) -> Any:
        """The last event of the Controller."""
        return self._made.last_event

    def reset(self, scene: str, **arguments: Any) -> Any:
        """The event of a recorded reset."""
        return self._written("reset", {"scene": scene, **arguments}, lambda: self._made.reset(scene, **arguments))

    def step(self, action: str, **arguments: Any) -> Any:
        """The event of a recorded step."""
        return self._written("step", {"action": action, **arguments}, lambda: self._made.step(action=action, **arguments))

    def stop(self) -> None:
        """Stop the simulator; not recorded."""
        self._made.stop()

    def _written(self, call: str, arguments: dict[str, Any], do: Callable[[], Any]) -> Any:
        entry, answer = called(call, arguments, do)
        self._writer.write(entry)
        if isinstance(answer, Exception):
            raise answer
        return answer


def called(call: str, arguments: dict[str, Any], do: Callable[[], Any]) -> tuple[Call, Any]:
    """The entry of a call, and its event or the exception that it raised."""
    try:
        event = do()
    except Exception as error:
        # A ValueError has the simulator's message; the messages of others may contain paths of this machine.
        message = str(error) if isinstance(error, ValueError) else str(error).partition("\n")[0]
        return Call(call, plain(arguments), None, {}, (type(error).__name__, message)), error
    return Call(call, plain(arguments), plain(dict(event.metadata)), pictures(event)), event


def pictures(event: Any) -> dict[str, Any]:
    """Statistics of an event's images: mean colour, depth (metres: least, at the centre, largest), sizes of masks (pixels)."""
    if event.frame is None:
        return {}
    known: dict[str, Any] = {"rgb": [round(float(mean), 3) for mean in event.frame.mean(axis=(0, 1))]}
    depth = event.depth_frame
    if depth is not None:
        high, wide = depth.shape
        known["depth"] = [float(depth.min()), float(depth[high // 2, wide // 2]), float(depth.max())]
    if event.instance_segmentation_frame is not None:
        masks = event.instance_masks
        known["masks"] = {name: int(np.count_nonzero(masks[name])) for name in sorted(masks.keys())}
    return known


def plain(value: Any) -> Any:
    """A value after a round trip through JSON."""
    return json.loads(json.dumps(value, default=_number))


def _number(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{value!r} is no JSON")

"""ultralytics' trainer with the network in reduced precision (`ovman.training.precision`) and channels last, also on a CPU."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from ultralytics.models.yolo.segment import SegmentationTrainer
from ultralytics.nn.tasks import SegmentationModel

from ovman.training.precision import reduced


class HalfNetwork(SegmentationModel):
    """A network that computes in reduced precision during training; weights and losses stay in single precision."""

    def predict(self, x: torch.Tensor, *arguments: Any, **options: Any) -> Any:
        """The output for pictures (N, 3, S, S), in single precision."""
        base: Any = super()  # ultralytics has no types
        if not self.training:
            return base.predict(x, *arguments, **options)
        with reduced(x.device.type):
            found = base.predict(x.contiguous(memory_format=torch.channels_last), *arguments, **options)
        return _single(found)


_NETWORK: Any = HalfNetwork


class HalfTrainer(SegmentationTrainer):
    """Trains a HalfNetwork, from the weights `start` if given (tensors by name)."""

    def __init__(self, overrides: dict[str, Any], start: Mapping[str, torch.Tensor] | None = None) -> None:
        self._start = start
        super().__init__(overrides=overrides)

    def get_model(self, cfg: Any = None, weights: Any = None, verbose: bool = True) -> HalfNetwork:
        """The network of the configuration, with the weights `start`."""
        network: Any = _NETWORK(cfg, nc=self.data["nc"], ch=self.data["channels"], verbose=verbose)
        network.names = self.data["names"]
        if self._start is not None:
            network.load_state_dict({name: value.float() for name, value in self._start.items()})
        made: HalfNetwork = network.to(memory_format=torch.channels_last)
        return made

    def validate(self) -> tuple[dict[str, float], float]:
        """Nothing: this project evaluates on the held-out scenes between steps."""
        return {}, 0.0

    def final_eval(self) -> None:
        """See `validate`."""


def _single(found: Any) -> Any:
    if isinstance(found, torch.Tensor):
        return found.float()
    if isinstance(found, dict):
        return {name: _single(value) for name, value in found.items()}
    if isinstance(found, (list, tuple)):
        return type(found)(_single(value) for value in found)
    return found

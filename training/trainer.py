"""ultralytics' trainer with a network in reduced precision and channels last, also on a processor. Needs the extra `networks`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from ultralytics.models.yolo.segment import SegmentationTrainer
from ultralytics.nn.tasks import SegmentationModel

MULTIPLIES_IN_BFLOAT16 = ("avx512_bf16", "amx_bf16", "bf16")
"""Abilities of a processor, by torch's names. Without one bfloat16 is emulated, in ten times the time of single precision."""


def reduced_precision(device: str, of_processor: Mapping[str, Any] | None = None) -> torch.autocast:
    """Return a context for the forward pass: bfloat16, or single precision on a processor that has no such products.

    Args:
        device: "cpu" or "cuda".
        of_processor: The abilities of the processor, those of this one if not given.
    """
    known: Mapping[str, Any] = torch.cpu.get_capabilities() if of_processor is None else of_processor
    enabled = device != "cpu" or any(known.get(name) for name in MULTIPLIES_IN_BFLOAT16)
    return torch.autocast(device, torch.bfloat16, enabled=enabled)


class ReducedNetwork(SegmentationModel):
    """A network that computes in reduced precision during training; weights and losses stay in single precision."""

    def predict(self, x: torch.Tensor, *arguments: Any, **options: Any) -> Any:
        """Return the output for pictures (N, 3, S, S), in single precision."""
        base: Any = super()  # ultralytics has no types
        if not self.training:
            return base.predict(x, *arguments, **options)
        with reduced_precision(x.device.type):
            found = base.predict(x.contiguous(memory_format=torch.channels_last), *arguments, **options)
        return _to_single(found)


_NETWORK: Any = ReducedNetwork


class Trainer(SegmentationTrainer):
    """Trains a ReducedNetwork, from the weights `start` if given (tensors by name)."""

    def __init__(self, overrides: dict[str, Any], start: Mapping[str, torch.Tensor] | None = None) -> None:
        self._start = start
        super().__init__(overrides=overrides)

    def get_model(self, cfg: Any = None, weights: Any = None, verbose: bool = True) -> ReducedNetwork:
        """Return the network of the configuration, with the weights `start`."""
        network: Any = _NETWORK(cfg, nc=self.data["nc"], ch=self.data["channels"], verbose=verbose)
        network.names = self.data["names"]
        if self._start is not None:
            network.load_state_dict({name: value.float() for name, value in self._start.items()})
        last: ReducedNetwork = network.to(memory_format=torch.channels_last)
        return last

    def validate(self) -> tuple[dict[str, float], float]:
        """Do nothing: `training.detector` evaluates on the held-out scenes between steps."""
        return {}, 0.0

    def final_eval(self) -> None:
        """Do nothing, as `validate`."""


def _to_single(found: Any) -> Any:
    if isinstance(found, torch.Tensor):
        return found.float()
    if isinstance(found, dict):
        return {name: _to_single(value) for name, value in found.items()}
    if isinstance(found, (list, tuple)):
        return type(found)(_to_single(value) for value in found)
    return found

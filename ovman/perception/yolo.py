"""Detectors of ultralytics: what loads them, and what of them runs. Needs the extra `networks`."""

from __future__ import annotations

import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

from ovman.perception.detector import AT_MOST, KEY, DetectorFacts
from ovman.perception.weights import WeightsError, fitting, state

_SCORES = re.compile(r"model\.\d+\.cv3\.0\.2\.bias")
"""The bias of the class scores; its length is the number of classes."""
_MOST = 300
"""Boxes that a network which suppresses overlaps itself gives at least, as ultralytics has it."""


def empty_network(architecture: str, classes: int = 1) -> Any:
    """A network of an architecture of ultralytics with random weights: "yolov8n-seg". WeightsError for an unknown one."""
    from ultralytics.nn.tasks import SegmentationModel

    try:
        made: Callable[..., Any] = SegmentationModel  # ultralytics has no types
        return made(f"{architecture}.yaml", nc=classes, verbose=False)
    except (FileNotFoundError, KeyError, AttributeError):
        raise WeightsError(f"{KEY}.architecture is {architecture}, which ultralytics does not have; yolov8n-seg is one") from None


def network_of(weights: Path, architecture: str, trust_pickles: bool = False) -> Any:
    """The network with the weights of a file, which determine its number of classes. WeightsError if they do not fit."""
    tensors = state(weights, trust_pickles, KEY)
    scores = [value for name, value in tensors.items() if _SCORES.fullmatch(name)]
    return fitting(empty_network(architecture, len(scores[0]) if scores else 1), tensors, weights.name, KEY)


def facts_of(network: Any) -> DetectorFacts:
    """The facts of a network."""
    end2end = bool(getattr(network, "end2end", False))
    return DetectorFacts(max(int(network.stride.max()), 32), end2end, int(network.model[-1].nc))


def running(network: Any) -> Any:
    """A copy of a network as it runs: layers fused, for frames of any size, with the outputs that `Detector` reads."""
    import torch

    class Boxes(torch.nn.Module):
        def __init__(self, network: Any) -> None:
            super().__init__()
            self.network = network

        def forward(self, pictures: Any) -> Any:
            given = self.network(pictures)
            return given[0] if isinstance(given[0], tuple) else given[:2]

    fused = deepcopy(network).float().eval().fuse(verbose=False)
    if facts_of(fused).end2end:
        fused.set_head_attr(max_det=max(AT_MOST, _MOST), agnostic_nms=True)
    fused.model[-1].dynamic = True  # places of the boxes are computed for each frame, not kept from the first one
    return Boxes(fused).eval()

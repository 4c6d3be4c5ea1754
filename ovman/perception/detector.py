"""Class-agnostic instance masks of pictures, by ultralytics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

AT_MOST = 100
"""Instances that are looked for in a picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """The N instances of one picture, the surest first. masks: (N, H, W) bool; confidence: (N,) in [0, 1]."""

    masks: np.ndarray
    confidence: np.ndarray


class Detector:
    """A segmentation network of ultralytics and what is asked of it.

    side_px: pictures are scaled to this side; confidence: what is less sure is no instance.
    """

    def __init__(self, network: Any, side_px: int, confidence: float, device: str = "cpu") -> None:
        from ultralytics.models.yolo.segment import SegmentationPredictor

        network = network.to(device).float().eval()
        network.pt_path = None
        options = {
            "imgsz": side_px,
            "conf": confidence,
            "max_det": AT_MOST,
            "agnostic_nms": True,
            "retina_masks": True,
            "device": device,
            "verbose": False,
            "save": False,
            "mode": "predict",
        }
        self._predict = SegmentationPredictor(overrides=options)
        self._predict.setup_model(network, verbose=False)

    def detect(self, pictures: Sequence[np.ndarray]) -> list[Detections]:
        """The instances of pictures (H, W, 3) uint8 RGB."""
        if not pictures:
            return []
        found = []
        for result in self._predict([np.ascontiguousarray(picture[..., ::-1]) for picture in pictures], stream=False):
            masks = np.zeros((0, *result.orig_shape), bool)
            if result.masks is not None:
                masks = result.masks.data.cpu().numpy() > 0.5
            found.append(Detections(masks, result.boxes.conf.cpu().numpy()))
        return found


def empty_network(architecture: str) -> Any:
    """A network of an architecture of ultralytics with one class and random weights: "yolov8n-seg"."""
    from ultralytics.nn.tasks import SegmentationModel

    return SegmentationModel(f"{architecture}.yaml", nc=1, verbose=False)


def network_of(weights: Path, architecture: str) -> Any:
    """The network of a .safetensors file, of one class."""
    from safetensors.torch import load_file

    network = empty_network(architecture)
    network.load_state_dict({name: value.float() for name, value in load_file(weights).items()})
    return network

"""Class-agnostic instance masks of pictures, by ultralytics."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception import predictor
from ovman.perception.network_cache import NetworkCache
from ovman.perception.weights import WeightsError, fitting, state

KEY = "perception.detector"
AT_MOST = 100
"""Most instances of a picture."""
TOGETHER = 8
"""Batch size; larger batches do not fit the processor's cache."""
_SCORES = re.compile(r"model\.\d+\.cv3\.0\.2\.bias")
"""The bias of the class scores; its length is the number of classes."""


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """The N instances of one picture by descending confidence. masks: (N, H, W) bool; confidence: (N,) in [0, 1]."""

    masks: np.ndarray
    confidence: np.ndarray


class Detector:
    """A segmentation network of ultralytics, used class-agnostically.

    load: returns the network; on a processor it is called only to export a graph that the cache does not have. side_px: pictures
    are scaled to this side; confidence: threshold of an instance. Non-maximum suppression runs over all classes together.
    options: of ultralytics' predictor.
    """

    def __init__(
        self, load: Callable[[], Any], side_px: int, confidence: float, device: str = "cpu", kept: NetworkCache | None = None
    ) -> None:
        self._load, self._confidence, self._device, self._kept = cache(load), confidence, device, kept or NetworkCache(None)
        self._at = {side_px: self}
        self.options = {
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
        if device == "cpu":
            self._predict = predictor.with_graphs(self.options, self._load, self._kept)
        else:
            self._predict = predictor.with_network(self.options, self._load())

    @property
    def network(self) -> Callable[[Any], Any]:
        """The network as it runs, for pictures (N, 3, side_px, side_px) in [0, 1]."""
        inference: Callable[[Any], Any] = self._predict.inference
        return inference

    def at(self, side_px: int) -> Detector:
        """The same network with pictures scaled to another side, a multiple of 32."""
        if side_px not in self._at:
            self._at[side_px] = Detector(self._load, side_px, self._confidence, self._device, self._kept)
        return self._at[side_px]

    def detect(self, pictures: Sequence[np.ndarray]) -> list[Detections]:
        """The instances of pictures (H, W, 3) uint8 RGB."""
        found = []
        for start in range(0, len(pictures), TOGETHER):
            blue_first = [np.ascontiguousarray(picture[..., ::-1]) for picture in pictures[start : start + TOGETHER]]
            for result in self._predict(blue_first, stream=False):
                masks = np.zeros((0, *result.orig_shape), bool)
                if result.masks is not None:
                    masks = result.masks.data.cpu().numpy() > 0
                found.append(Detections(masks, result.boxes.conf.cpu().numpy()))
        return found


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

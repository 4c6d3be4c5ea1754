"""Class-agnostic instance masks of pictures, by ultralytics."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception.graph import Graph
from ovman.perception.weights import WeightsError, fitting, state

KEY = "perception.detector"
AT_MOST = 100
"""Instances that are looked for in a picture."""
TOGETHER = 8
"""Pictures that go through the network at a time; more of them leave the processor's cache."""
_SCORES = re.compile(r"model\.\d+\.cv3\.0\.2\.bias")
"""The layer that says how sure each class is."""


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """The N instances of one picture, the surest first. masks: (N, H, W) bool; confidence: (N,) in [0, 1]."""

    masks: np.ndarray
    confidence: np.ndarray


class Detector:
    """A segmentation network of ultralytics and what is asked of it.

    side_px: pictures are scaled to this side; confidence: what is less sure is no instance. The classes of a network that has
    several are not told apart: where boxes overlap, the surest of all classes stays.
    """

    def __init__(self, network: Any, side_px: int, confidence: float, device: str = "cpu") -> None:
        network = network.to(device).float().eval()
        network.pt_path = None
        self._of, self._at = (network, confidence, device), {side_px: self}
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
        self._predict = _predictor(options)
        self._predict.setup_model(network, verbose=False)

    @property
    def network(self) -> Callable[[Any], Any]:
        """What pictures (N, 3, side_px, side_px) in 0 to 1 go through, as it runs."""
        return self._predict.inference

    def at(self, side_px: int) -> Detector:
        """The same network for pictures that are scaled to another side, a multiple of 32."""
        network, confidence, device = self._of
        if side_px not in self._at:
            self._at[side_px] = Detector(network, side_px, confidence, device)
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
    """A network of an architecture of ultralytics with random weights: "yolov8n-seg". WeightsError for one that it has not."""
    _keep_to_itself()
    from ultralytics.nn.tasks import SegmentationModel

    try:
        return SegmentationModel(f"{architecture}.yaml", nc=classes, verbose=False)
    except (FileNotFoundError, KeyError, AttributeError):
        raise WeightsError(f"{KEY}.architecture is {architecture}, which ultralytics does not have; yolov8n-seg is one") from None


def network_of(weights: Path, architecture: str, trust_pickles: bool = False) -> Any:
    """The network of a file of weights, with as many classes as they are for. WeightsError where they do not fit."""
    tensors = state(weights, trust_pickles, KEY)
    scores = [value for name, value in tensors.items() if _SCORES.fullmatch(name)]
    return fitting(empty_network(architecture, len(scores[0]) if scores else 1), tensors, weights.name, KEY)


def _predictor(options: Mapping[str, Any]) -> Any:
    """ultralytics' predictor, which looks for the instances of one picture after the other, on a processor as a graph.

    Given several, its suppression of overlaps stops after two seconds of wall clock and leaves the rest of them without any.
    """
    _keep_to_itself()
    import torch
    from ultralytics.models.yolo.segment import SegmentationPredictor

    class Boxes(torch.nn.Module):
        """Of what the network gives, what counts where nothing is learned: boxes with their scores, and prototypes of masks."""

        def __init__(self, network: Any) -> None:
            super().__init__()
            self.network = network

        def forward(self, pictures: Any) -> Any:
            given = self.network(pictures)
            return given[0] if isinstance(given[0], tuple) else given[:2]

    class Unhurried(SegmentationPredictor):
        graphs: dict[tuple[int, ...], Graph]

        def inference(self, im: Any, *args: Any, **kwargs: Any) -> Any:
            if im.device.type != "cpu":
                return super().inference(im, *args, **kwargs)
            shape = (1, *im.shape[1:])
            if shape not in self.graphs:
                self.graphs[shape] = Graph(Boxes(self.model.backend.model).eval(), shape)
            found = [self.graphs[shape](picture[None]) for picture in im]
            return (tuple(torch.cat(parts) for parts in zip(*found, strict=True)),)

        def postprocess(self, preds: Any, img: Any, orig_imgs: Any) -> list[Any]:
            boxes, prototypes = preds[0] if isinstance(preds[0], tuple) else preds[:2]
            return [
                result
                for n in range(len(orig_imgs))
                for result in super(Unhurried, self).postprocess(
                    ((boxes[n : n + 1], prototypes[n : n + 1]),), img[n : n + 1], orig_imgs[n : n + 1]
                )
            ]

    predictor = Unhurried(overrides=dict(options))
    predictor.graphs = {}
    return predictor


def _keep_to_itself() -> None:
    """Before ultralytics is imported: it installs nothing, and neither asks nor tells anybody anything on the network."""
    for name, value in (("YOLO_AUTOINSTALL", "false"), ("YOLO_OFFLINE", "true")):
        os.environ.setdefault(name, value)

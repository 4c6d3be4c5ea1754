"""What ultralytics' own predictor makes of a network, which ours is held against."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

import numpy as np

from ovman.perception.detector import AT_MOST, Detections


def predictor(network: Any, side_px: int, confidence: float, **options: Any) -> Any:
    from ultralytics.models.yolo.segment import SegmentationPredictor

    asked = {
        "imgsz": side_px,
        "conf": confidence,
        "max_det": AT_MOST,
        "agnostic_nms": True,
        "retina_masks": True,
        "device": "cpu",
    }
    made = SegmentationPredictor(overrides=asked | {"verbose": False, "save": False, "mode": "predict"} | options)
    made.setup_model(with_a_path(deepcopy(network).float().eval()), verbose=False)
    return made


def with_a_path(network: Any) -> Any:
    network.pt_path = None
    return network


def detect(made: Any, pictures: Sequence[np.ndarray]) -> list[Detections]:
    """One by one: for a batch its suppression of overlaps stops after two seconds of wall time."""
    found = []
    for picture in pictures:
        (result,) = made([np.ascontiguousarray(picture[..., ::-1])], stream=False)
        masks = np.zeros((0, *result.orig_shape), bool) if result.masks is None else result.masks.data.numpy() > 0
        found.append(Detections(masks, result.boxes.conf.numpy()))
    return found


def shared(one: Detections, other: Detections, least_iou: float) -> int:
    """How many instances of `one` have a partner of their own in `other`: the best pairs first."""
    count = (len(one.masks), len(other.masks))
    if 0 in count:
        return 0
    flat = [found.masks.reshape(len(found.masks), -1).astype(np.float64) for found in (one, other)]
    inter = flat[0] @ flat[1].T
    iou = inter / np.maximum(flat[0].sum(axis=1)[:, None] + flat[1].sum(axis=1)[None] - inter, 1)
    taken: tuple[set[int], set[int]] = (set(), set())
    for index in np.argsort(-iou, axis=None, kind="stable"):
        row, column = divmod(int(index), count[1])
        if iou[row, column] >= least_iou and row not in taken[0] and column not in taken[1]:
            taken[0].add(row)
            taken[1].add(column)
    return len(taken[0])

"""What DualMap needs to come through a run. Applied at run time; no file of DualMap is changed.

As released, `Detector.process_yolo_and_sam` returns early when YOLO finds nothing, without `curr_detections`: in the first frame
the attribute does not exist yet and the run ends, in later ones the detections of the frame before are used again with the new
depth and pose. "first_only" is no more than the run needs to go on; "every_frame" forgets the frame before as well, which changes
the maps.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import Any

import numpy as np

FIRST_ONLY, EVERY_FRAME = "first_only", "every_frame"


def apply(detector: Any, mode: str) -> None:
    """Guards the classes `Detector` and `Filter` of a module, in place. ValueError for another mode than the two."""
    if mode not in (FIRST_ONLY, EVERY_FRAME):
        raise ValueError(f"guard is {mode!r}; it must be {FIRST_ONLY} or {EVERY_FRAME}")
    found, kept = detector.Detector.process_yolo_and_sam, detector.Filter.update_detections

    @functools.wraps(found)
    def process_yolo_and_sam(self: Any, *args: Any, **kwargs: Any) -> Any:
        if mode == EVERY_FRAME:
            self.curr_detections = None
        result = found(self, *args, **kwargs)
        if not hasattr(self, "curr_detections"):
            self.curr_detections = None
        return result

    @functools.wraps(kept)
    def update_detections(self: Any, detections: Any, color: Any) -> Any:
        return kept(self, detections, color) if detections is not None else nothing(self, color)

    detector.Detector.process_yolo_and_sam = process_yolo_and_sam
    detector.Filter.update_detections = update_detections


def nothing(filter: Any, color: np.ndarray) -> None:
    """A filter of a frame (H, W, 3) in which nothing was found: the arrays that it works on, without an entry."""
    filter.confidence = np.zeros(0, np.float32)
    filter.class_id = np.zeros(0, np.int64)
    filter.xyxy = np.zeros((0, 4), np.float32)
    filter.masks = np.zeros((0, *color.shape[:2]), bool)
    filter.masks_size = np.zeros(0, np.int64)
    filter.inter_np = np.zeros((0, 0))


@contextlib.contextmanager
def on(device: str, torch: Any) -> Iterator[None]:
    """DualMap asks for text features on "cuda" by name; on the device "cpu" its tensors stay where they are meanwhile."""
    if device != "cpu":
        yield
        return
    tensor, module = torch.Tensor.to, torch.nn.Module.to

    def staying(move: Any) -> Any:
        def to(self: Any, *args: Any, **kwargs: Any) -> Any:
            here = ["cpu" if str(value).startswith("cuda") else value for value in args]
            return move(self, *here, **{k: "cpu" if str(v).startswith("cuda") else v for k, v in kwargs.items()})

        return to

    torch.Tensor.to, torch.nn.Module.to = staying(tensor), staying(module)
    try:
        yield
    finally:
        torch.Tensor.to, torch.nn.Module.to = tensor, module

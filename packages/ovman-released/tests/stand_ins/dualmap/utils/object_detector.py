"""A detector by colour, with the fault of DualMap's: it returns early from a frame in which there is nothing."""

import numpy as np


class Filter:
    def update_detections(self, detections, color):
        self.confidence, self.class_id = detections["confidence"], detections["class_id"]
        self.masks = detections["masks"]
        self.xyxy = np.zeros((len(self.masks), 4))
        self.masks_size, self.inter_np = self.masks.sum(axis=(1, 2)), np.zeros((len(self.masks),) * 2)
        assert color.shape[:2] == self.masks.shape[1:]

    def get_len(self):
        return len(self.confidence)

    def run_filter(self):
        sizes = (self.confidence, self.class_id, self.xyxy, self.masks, self.masks_size, self.inter_np)
        assert len({len(part) for part in sizes}) == 1
        return None if self.get_len() == 0 else list(zip(self.class_id.tolist(), self.masks, strict=True))


class Detector:
    def __init__(self, settings):
        if settings.scene_id == "half_built":
            print("Error loading weights")
            return
        self.filter = Filter()

    def process_yolo_and_sam(self, color):
        red = color[..., 0]
        values = [value for value in np.unique(red).tolist() if value]
        if not values:
            return
        self.curr_detections = {
            "confidence": np.ones(len(values)),
            "class_id": np.array(values) // 10 - 1,
            "masks": np.stack([red == value for value in values]),
        }

    def process_detections(self, color):
        self.process_yolo_and_sam(color)
        self.filter.update_detections(self.curr_detections, color)
        return self.filter.run_filter() or []

"""Objects that are saved with the fields that DualMap saves."""

import uuid

import numpy as np


class LocalObject:
    def __init__(self, class_id, points, feature):
        self.uid, self.class_id, self.points, self.feature = uuid.uuid4(), class_id, points, feature
        self.observations = []

    def __getstate__(self):
        return {
            "uid": self.uid,
            "pcd_points": np.asarray(self.points).tolist(),
            "pcd_colors": np.zeros((len(self.points), 3)).tolist(),
            "clip_ft": self.feature.tolist(),
            "class_id": self.class_id,
            "nav_goal": False,
        }

    def __setstate__(self, state):
        self.uid, self.class_id = state["uid"], state["class_id"]
        self.points, self.feature = np.asarray(state["pcd_points"]).reshape(-1, 3), np.asarray(state["clip_ft"])
        self.observations = []


class GlobalObject(LocalObject):
    def __init__(self, class_id, points, feature, related=()):
        super().__init__(class_id, points, feature)
        self.related = list(related)

    def __getstate__(self):
        boxes = [{"min_bound": list(low), "max_bound": list(high)} for low, high, _, _ in self.related]
        return super().__getstate__() | {
            "related_objs": [feature.tolist() for _, _, feature, _ in self.related],
            "pcd_2d_points": [],
            "pcd_2d_colors": [],
            "related_bbox": boxes,
            "related_color": [class_id for _, _, _, class_id in self.related],
        }

    def __setstate__(self, state):
        super().__setstate__(state)
        features, classes = state["related_objs"], state["related_color"]
        bounds = [(box["min_bound"], box["max_bound"]) for box in state["related_bbox"]]
        self.related = [(*b, np.asarray(f), c) for b, f, c in zip(bounds, features, classes, strict=True)]

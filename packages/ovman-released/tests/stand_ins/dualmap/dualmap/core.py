"""A map with DualMap's outside: a class is an object, which stays if it was seen in two keyframes of a sequence.

The scene's name says what goes wrong: "hangs", "killed", "raises", "half_built", "forgets" (what it was preloaded with).
"""

import os
import pickle
import shutil
import signal
import threading
import time
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np

detectors, objects, types = (import_module(f"utils.{name}") for name in ("object_detector", "object", "types"))
torch = import_module("torch")


class Dualmap:
    def __init__(self, settings):
        print("Use FastSAM for OV?            : False")
        self.settings, self.stop_thread, self._keyframe, self._last = settings, False, 0, None
        threading.Thread(target=self._monitor).start()
        self.detector = detectors.Detector(settings)
        self.local_map_manager = SimpleNamespace(local_map=[])
        self.anchors = []
        if settings.preload_global_map and settings.scene_id != "forgets":
            for path in sorted(Path(settings.preload_path).glob("*.pkl")):
                self.anchors.append(pickle.loads(path.read_bytes()))

    def _monitor(self):
        while not self.stop_thread:
            time.sleep(0.05)

    def check_keyframe(self, seconds, pose):
        assert pose.shape == (4, 4) and abs(np.linalg.det(pose[:3, :3]) - 1) < 1e-6
        if self._last is not None and seconds - self._last < 0.5:
            return False
        self._last, self._keyframe = seconds, self._keyframe + 1
        return True

    def get_keyframe_idx(self):
        return self._keyframe

    def sequential_process(self, frame):
        if self.settings.scene_id == "hangs":
            time.sleep(600)
        if self.settings.scene_id == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.settings.scene_id == "raises":
            raise RuntimeError("something went wrong in DualMap")
        for class_id, mask in self.detector.process_detections(frame.color):
            rows, columns = np.nonzero(mask)
            depth = frame.depth[rows, columns, 0]
            camera = np.stack([columns, rows, np.ones(len(rows))]).T @ np.linalg.inv(frame.intrinsics).T * depth[:, None]
            points = (camera @ frame.pose[:3, :3].T + frame.pose[:3, 3])[depth > 0]
            held = [thing for thing in self.local_map_manager.local_map if thing.class_id == class_id]
            if not held:
                held = [objects.LocalObject(class_id, np.zeros((0, 3)), np.eye(8)[class_id])]
                self.local_map_manager.local_map += held
            held[0].points = np.concatenate([held[0].points, points])
            held[0].observations.append(types.LocalObservation(frame.idx, class_id))

    parallel_process = sequential_process

    def end_process(self):
        self.local_map_manager.local_map = [o for o in self.local_map_manager.local_map if len(o.observations) > 1]
        found = self.local_map_manager.local_map
        if self.settings.save_global_map:
            found = self.anchors + [self._anchor(thing) for thing in found if thing.class_id == 0]
        directory = Path(self.settings.output_path) / f"{self.settings.dataset_name}_{self.settings.scene_id}" / "map"
        shutil.rmtree(directory, ignore_errors=True)
        directory.mkdir(parents=True)
        for thing in found:
            (directory / f"{thing.uid}.pkl").write_bytes(pickle.dumps(thing))
        self.stop_thread = True

    def _anchor(self, thing):
        others = [other for other in self.local_map_manager.local_map if other.class_id == 1]
        related = [(o.points.min(axis=0), o.points.max(axis=0), o.feature, o.class_id) for o in others]
        return objects.GlobalObject(thing.class_id, thing.points, thing.feature, related)

    def convert_inquiry_to_feat(self, text):
        return torch.Tensor(np.eye(8)[None, len(text) % 8]).to("cuda")

"""Reads the layout "self_collected" as DualMap is said to: natural order, equal counts, depth as float64 metres (H, W, 1)."""

from importlib import import_module
from pathlib import Path

import cv2
import numpy as np
import yaml

import_module("imageio")


class Dataset:
    def __init__(self, settings):
        assert settings.use_stride is False, "every frame is wanted"
        self._scene = Path(settings.dataset_path) / settings.scene_id
        conf = yaml.safe_load(Path(settings.dataset_conf_path).read_text())
        assert conf["dataset_name"] == settings.dataset_name == "self_collected"
        self._camera = conf["camera_params"]
        rows = np.loadtxt(self._scene / "pose.txt", ndmin=2)
        assert rows.shape[1] == 17
        self.time_stamps, self.poses = rows[:, 0].tolist(), list(rows[:, 1:].reshape(-1, 4, 4))
        self._rgb, self._depth = (sorted((self._scene / kind).glob("*.png")) for kind in ("rgb", "depth"))
        assert len(self._rgb) == len(self._depth) == len(self.poses)

    def get_color(self, index):
        picture = cv2.cvtColor(cv2.imread(str(self._rgb[index])), cv2.COLOR_BGR2RGB)
        assert picture.shape == (self._camera["image_height"], self._camera["image_width"], 3)
        return picture, self._rgb[index].stem

    def get_depth(self, index):
        picture = cv2.imread(str(self._depth[index]), cv2.IMREAD_UNCHANGED)
        assert picture.dtype == np.uint16
        return (picture / self._camera["png_depth_scale"])[..., None]

    def get_intrinsics(self, index):
        c = self._camera
        return np.array([[c["fx"], 0, c["cx"]], [0, c["fy"], c["cy"]], [0, 0, 1.0]])


def dataset_initialization(settings):
    return Dataset(settings)

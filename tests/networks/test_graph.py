"""A detector that PyTorch runs gives what ultralytics makes of it."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.perception import networks, pytorch
from tests.networks import ultralytics_own
from tests.networks.test_networks import FRAMES, seeing

pytestmark = pytest.mark.networks


@pytest.mark.parametrize(("architecture", "classes"), [("yolov8n-seg", 1), ("yolov8n-seg", 7), ("yolo26n-seg", 3)])
def test_it_finds_what_ultralytics_finds_with_the_network(tmp_path, architecture, classes):
    """Whose suppression of overlaps is torchvision's, or the network's own."""
    path = seeing(architecture, tmp_path / "d.safetensors", classes)
    of = pytorch.load_detector(path, architecture)
    ours = networks.loaded_detector(of, 64, 0.25).detect(FRAMES)
    for one, other in zip(ours, ultralytics_own.detect(ultralytics_own.predictor(of, 64, 0.25), FRAMES), strict=True):
        assert one.masks.shape == other.masks.shape and len(one.confidence) == len(other.confidence) > 0
        assert np.allclose(one.confidence, other.confidence, atol=1e-3)
        if architecture != "yolo26n-seg":  # whose random weights find all equally sure, in any order
            assert (one.masks != other.masks).mean() < 1e-3

"""Frames, boxes, masks and suppression are ultralytics' and torchvision's."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torchvision.ops import nms
from ultralytics.data.augment import LetterBox
from ultralytics.utils import ops

from ovman.perception.detector import Letterbox, build_masks, non_max_suppression

pytestmark = pytest.mark.networks
SHAPES = [
    (300, 300, 320),
    (224, 224, 224),
    (90, 120, 64),
    (120, 90, 96),
    (333, 217, 160),
    (1, 300, 64),
    (480, 640, 640),
    (61, 47, 64),
]


@pytest.mark.parametrize(("height", "width", "side_px"), SHAPES)
def test_frames_and_boxes_are_ultralytics_own(height, width, side_px):
    rng, found = np.random.default_rng(0), Letterbox.of(height, width, side_px, 32)
    picture = rng.integers(0, 256, (height, width, 3), np.uint8)
    expected = LetterBox(side_px, auto=True, stride=32)(image=picture)
    frame = found.frame_of(picture)
    assert frame.shape == (1, 3, *found.frame) and found.frame == expected.shape[:2]
    assert np.array_equal(frame, torch.from_numpy(expected).permute(2, 0, 1)[None].float().div_(255).numpy())
    corners = rng.uniform(-20, side_px + 20, (50, 4)).astype(np.float32)
    boxes = ops.scale_boxes(found.frame, torch.from_numpy(corners.copy()), (height, width)).numpy()
    assert np.allclose(found.to_picture(corners), boxes, rtol=1e-6, atol=1e-5)
    assert np.mean(found.to_picture(corners) == boxes) > 0.99


@pytest.mark.parametrize(("height", "width", "side_px"), SHAPES)
def test_masks_are_ultralytics_masks(height, width, side_px):
    """Where sums of products are not the same to the last bit, a pixel on a mask's edge may differ."""
    rng = np.random.default_rng(1)
    found = Letterbox.of(height, width, side_px, 32)
    prototypes = rng.standard_normal((8, found.frame[0] // 4, found.frame[1] // 4)).astype(np.float32)
    coefficients = rng.standard_normal((30, 8)).astype(np.float32)
    corners = np.sort(rng.uniform(0, 1, (30, 2, 2)), axis=1).reshape(30, 4) * [width, height, width, height]
    corners[0], corners[1] = (0, 0, width, height), (0.4, 0.2, 0.4, 0.9)  # all of the picture, and nothing
    boxes = corners.astype(np.float32)
    expected = ops.process_mask_native(*map(torch.from_numpy, (prototypes, coefficients, boxes)), (height, width)).numpy() > 0
    ours = build_masks(coefficients, prototypes, boxes, found)
    assert ours.shape == expected.shape == (30, height, width) and (expected.any() or height == 1)
    assert np.count_nonzero(ours != expected) <= max(1, expected.size * 1e-5)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("spread", [5, 40, 1000])
def test_the_same_boxes_stay_in_the_same_order(seed, spread):
    draw = np.random.default_rng(seed)
    corner = draw.uniform(0, spread, (120, 2))
    boxes = np.concatenate([corner, corner + draw.uniform(0, 30, (120, 2))], 1).astype(np.float32)
    boxes[::7] = boxes[0]  # the same box several times
    boxes[5::9, 2:] = boxes[5::9, :2]  # and boxes without an area
    sure = draw.integers(0, 40, 120).astype(np.float32) / 40  # some as sure as others
    for iou_threshold in (0.0, 0.3, 0.7, 1.0):
        expected = nms(torch.from_numpy(boxes), torch.from_numpy(sure), iou_threshold).numpy()
        assert np.array_equal(non_max_suppression(boxes, sure, iou_threshold, 120), expected)
        assert np.array_equal(non_max_suppression(boxes, sure, iou_threshold, 4), expected[:4])

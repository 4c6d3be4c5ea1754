"""DualMap's observations: masks by properties, and frames of the real engine with true masks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dualmap.observing import Observer, filter_masks, histogram
from ovman.perception.backprojection import Camera
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from tests.arms import CONFIG

CONSTANTS = CONFIG.dualmap.observation
RED, BLUE = (200, 30, 30), (30, 30, 200)


def box(top, left, bottom, right, side=40) -> np.ndarray:
    mask = np.zeros((side, side), bool)
    mask[top:bottom, left:right] = True
    return mask


def painted(*parts) -> np.ndarray:
    rgb = np.zeros((40, 40, 3), np.uint8)
    for mask, colour in parts:
        rgb[mask] = colour
    return rgb


boxes = st.lists(st.tuples(*4 * [st.integers(0, 40)]), max_size=9)


@given(boxes, st.integers(1, 60), st.integers(0, 5))
def test_what_is_left_is_disjoint_large_enough_and_part_of_what_was_found(corners, min_mask_px, seed):
    masks = np.array([box(min(a, c), min(b, d), max(a, c), max(b, d)) for a, b, c, d in corners]).reshape(-1, 40, 40)
    rgb = np.random.default_rng(seed).choice(np.array([RED, BLUE], np.uint8), (40, 40))
    which, own, whole = filter_masks(masks, rgb, min_mask_px, CONSTANTS)
    assert len(which) == len(own) == len(whole) == len(set(which.tolist()))
    assert (own.sum(axis=0) <= 1).all()
    assert all(mask.sum() >= min_mask_px for mask in own)
    for k, part, all_of_it in zip(which, own, whole, strict=True):
        assert not (part & ~all_of_it).any()
        assert not (masks[k] & ~all_of_it).any()
        assert not (all_of_it & ~masks.any(axis=0)).any()


def test_of_two_masks_that_are_the_same_the_larger_stays():
    large, same = box(0, 0, 20, 20), box(0, 0, 20, 17)
    which, own, _ = filter_masks(np.array([same, large]), painted((large, RED)), 10, CONSTANTS)
    assert which.tolist() == [1] and np.array_equal(own[0], large)


def test_overlapping_masks_of_the_same_colours_are_one_and_others_are_not():
    left, right = box(0, 0, 20, 20), box(0, 18, 20, 30)
    which, own, _ = filter_masks(np.array([left, right]), painted((left, RED), (right, RED)), 10, CONSTANTS)
    assert which.tolist() == [0] and np.array_equal(own[0], left | right)
    which, own, whole = filter_masks(np.array([left, right]), painted((left, RED), (right, BLUE)), 10, CONSTANTS)
    assert which.tolist() == [0, 1]
    assert np.array_equal(own[1], right) and np.array_equal(own[0], left & ~right)
    assert np.array_equal(whole[0], left) and np.array_equal(whole[1], right)
    apart = box(0, 24, 20, 30)
    assert len(filter_masks(np.array([left, apart]), painted((left | apart, RED)), 10, CONSTANTS)[0]) == 2


def test_what_a_smaller_mask_leaves_too_little_of_goes():
    frame, inside = box(0, 0, 10, 10), box(0, 0, 10, 7)
    which, _, _ = filter_masks(np.array([frame, inside]), painted((frame, RED), (inside, BLUE)), 40, CONSTANTS)
    assert which.tolist() == [1]
    assert filter_masks(np.zeros((0, 40, 40), bool), painted(), 10, CONSTANTS)[1].shape == (0, 40, 40)


def test_a_histogram_counts_each_channel_by_itself():
    counts = histogram(np.array([[0, 15, 16], [255, 15, 17]], np.uint8), 16)
    assert counts.sum() == 6 and counts.shape == (48,)
    assert counts[0] == counts[15] == 1 and counts[16] == 2 and counts[33] == 2


RUNS, SLACK_M, SIDE_PX = 3, 0.05, 240


@dataclass
class Frame:
    rgb: np.ndarray
    depth: np.ndarray
    camera: Camera


@dataclass
class Segments:
    masks: np.ndarray
    confidence: np.ndarray


class Detector:
    """Finds what it is told to."""

    def __init__(self, masks):
        self.masks = masks

    def detect(self, pictures):
        return [Segments(masks, np.linspace(0.9, 0.3, len(masks)).astype(np.float32)) for masks in self.masks]


class Encoder:
    """Embeds a crop by its mean colour, and words by their letters; remembers the crops."""

    side_px, size = 32, 12

    def __init__(self):
        self.crops = []

    def images(self, crops):
        self.crops += list(crops)
        means = crops.reshape(len(crops), -1, 3).mean(axis=1) - 100.0
        return _unit(np.tile(means, 4) * np.linspace(1, 2, self.size))

    def texts(self, phrases):
        return _unit(np.array([[sum(map(ord, p)) % (7 + k) - 3.0 for k in range(self.size)] for p in phrases]))


def _unit(rows):
    return (rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-9)).astype(np.float32)


def shots_of(observer, frames, seed=0):
    draws = [[np.random.default_rng([seed, k, run]) for run in range(RUNS)] for k in range(len(frames))]
    return [shot for shot, _ in observer.look(frames, draws)]


@pytest.fixture(scope="module")
def scene():
    """Frames of a living room, true masks in them, the boxes of what these show, and the highest point of its walls."""
    body = replace(Embodiment.of(CONFIG), width_px=SIDE_PX, height_px=SIDE_PX)
    frames, masks, names = [], [], []
    with Session("FloorPlan203", CONFIG, body) as session:
        session.reset()
        start = session.pose
        for yaw in range(0, 360, 60):
            event = session.teleport(AgentPose(start.x, start.z, float(yaw)), image=True)
            at = session.camera
            camera = Camera((at["x"], at["y"], at["z"]), float(yaw), 0.0, CONFIG.camera.field_of_view_deg)
            frames.append(Frame(event.frame, event.depth_frame, camera))
            named = [k for k in sorted(event.instance_masks) if k in session.objects and not k.startswith("Floor|")]
            masks.append(np.array([event.instance_masks[k] for k in named]))
            names.append(named)
        boxes = {k: np.array(o["axisAlignedBoundingBox"]["cornerPoints"]) for k, o in session.objects.items()}
    return frames, masks, names, boxes


@pytest.fixture(scope="module")
def observed(scene):
    frames, masks, _, _ = scene
    encoder = Encoder()
    observer = Observer(Detector(masks), encoder, CONSTANTS)
    return observer, shots_of(observer, frames), encoder


def test_clouds_lie_in_the_true_boxes_of_what_they_show(scene, observed):
    _, masks, names, boxes = scene
    _, shots, _ = observed
    assert sum(len(shot.seen) for shot in shots) > 10
    inside = []
    for shot, named, found in zip(shots, names, masks, strict=True):
        sure = np.linspace(0.9, 0.3, len(found)).astype(np.float32)
        for one in shot.seen:
            corners = boxes[named[int(np.flatnonzero(sure == np.float32(one.confidence))[0])]]
            low, high = corners.min(axis=0) - SLACK_M, corners.max(axis=0) + SLACK_M
            for cloud in one.clouds:
                median = np.median(cloud, axis=0)
                inside.append(bool(((low <= median) & (median <= high)).all()))
    # Masks of the same colours that overlap are merged; true ones do not overlap, so that every cloud is of one object.
    assert all(inside)


def test_observations_have_unit_features_points_of_every_run_and_boxes_around_them(observed):
    observer, shots, encoder = observed
    seen = [one for shot in shots for one in shot.seen]
    for one, crop in zip(seen, encoder.crops.copy(), strict=True):
        assert one.feature.dtype == np.float32 and np.linalg.norm(one.feature) == pytest.approx(1.0, abs=1e-6)
        image = encoder.images(crop[None])[0]
        cosines = observer.class_features @ image
        assert cosines[one.class_id] == pytest.approx(cosines.max(), abs=1e-6)
        mixed = CONSTANTS.image_weight * image + CONSTANTS.text_weight * observer.class_features[one.class_id]
        assert one.feature == pytest.approx(mixed / np.linalg.norm(mixed), abs=1e-5)
        assert len(one.clouds) == RUNS
        for cloud in one.clouds:
            assert cloud.dtype == np.float32 and len(cloud) >= CONSTANTS.cluster_points
        heights = np.concatenate(one.clouds)[:, 1]
        assert one.middle_m == pytest.approx((heights.min() + heights.max()) / 2)


def test_runs_draw_different_points_and_a_run_draws_the_same_again(scene, observed):
    frames, _, _, _ = scene
    observer, shots, _ = observed
    again = shots_of(observer, frames)
    other = shots_of(observer, frames, seed=1)
    for one, same in zip((s for shot in shots for s in shot.seen), (s for shot in again for s in shot.seen), strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one.clouds, same.clouds, strict=True))
        assert not np.array_equal(one.clouds[0], one.clouds[1])
    assert not np.array_equal(other[0].seen[0].clouds[0], shots[0].seen[0].clouds[0])


def test_the_same_view_gives_clouds_of_the_same_density_whatever_its_size(scene):
    frames, masks, _, _ = scene
    halves = [Frame(f.rgb[::2, ::2], f.depth[::2, ::2], f.camera) for f in frames]
    whole = shots_of(Observer(Detector(masks), Encoder(), CONSTANTS), frames)
    half = shots_of(Observer(Detector([m[:, ::2, ::2] for m in masks]), Encoder(), CONSTANTS), halves)
    points = [sum(len(cloud) for shot in shots for one in shot.seen for cloud in one.clouds) for shots in (whole, half)]
    assert points[1] == pytest.approx(points[0], rel=0.05)


def test_the_ceiling_is_the_highest_that_is_seen(scene, observed):
    frames, _, _, _ = scene
    _, shots, _ = observed
    for frame, shot in zip(frames, shots, strict=True):
        assert shot.top_m > frame.camera.position[1]
    tops = np.array([shot.top_m for shot in shots])
    assert np.abs(tops - np.median(tops)).max() < 0.2


def test_a_frame_in_which_nothing_is_found_shows_nothing(scene):
    frames, _, _, _ = scene
    nothing = np.zeros((0, SIDE_PX, SIDE_PX), bool)
    assert [shot.seen for shot in shots_of(Observer(Detector([nothing]), Encoder(), CONSTANTS), frames[:1])] == [()]

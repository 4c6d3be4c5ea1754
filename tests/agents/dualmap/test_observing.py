"""What DualMap observes in frames of the real engine, given true masks: clouds in the boxes of their objects, unit features."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ovman.agents.dualmap.observing import Observer
from ovman.perception.backprojection import Camera
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from tests.arms import CONFIG

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


def draws(frames, seed=0):
    return [[np.random.default_rng([seed, k, run]) for run in range(RUNS)] for k in range(frames)]


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
    observer = Observer(Detector(masks), encoder, CONFIG.dualmap.observation)
    return observer, observer.look(frames, draws(len(frames))), encoder


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
    constants = CONFIG.dualmap.observation
    seen = [one for shot in shots for one in shot.seen]
    for one, crop in zip(seen, encoder.crops.copy(), strict=True):
        assert one.feature.dtype == np.float32 and np.linalg.norm(one.feature) == pytest.approx(1.0, abs=1e-6)
        image = encoder.images(crop[None])[0]
        cosines = observer.class_features @ image
        assert cosines[one.class_id] == pytest.approx(cosines.max(), abs=1e-6)
        mixed = constants.image_weight * image + constants.text_weight * observer.class_features[one.class_id]
        assert one.feature == pytest.approx(mixed / np.linalg.norm(mixed), abs=1e-5)
        assert len(one.clouds) == RUNS
        for cloud in one.clouds:
            assert cloud.dtype == np.float32 and len(cloud) >= constants.cluster_points
            assert (cloud >= one.box[:3]).all() and (cloud <= one.box[3:]).all()


def test_runs_draw_different_points_and_a_run_draws_the_same_again(scene, observed):
    frames, masks, _, _ = scene
    observer, shots, _ = observed
    again = observer.look(frames, draws(len(frames)))
    other = observer.look(frames, draws(len(frames), seed=1))
    for one, same in zip((s for shot in shots for s in shot.seen), (s for shot in again for s in shot.seen), strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one.clouds, same.clouds, strict=True))
        assert not np.array_equal(one.clouds[0], one.clouds[1])
    assert not np.array_equal(other[0].seen[0].clouds[0], shots[0].seen[0].clouds[0])


def test_the_same_view_gives_clouds_of_the_same_density_whatever_its_size(scene):
    frames, masks, _, _ = scene
    halves = [Frame(f.rgb[::2, ::2], f.depth[::2, ::2], f.camera) for f in frames]
    whole = Observer(Detector(masks), Encoder(), CONFIG.dualmap.observation).look(frames, draws(len(frames)))
    small = Observer(Detector([m[:, ::2, ::2] for m in masks]), Encoder(), CONFIG.dualmap.observation)
    half = small.look(halves, draws(len(frames)))
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
    shots = Observer(Detector([nothing]), Encoder(), CONFIG.dualmap.observation).look(frames[:1], draws(1))
    assert [shot.seen for shot in shots] == [()]

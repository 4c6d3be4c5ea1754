"""Frames as DualMap reads them: axes, poses, depth, times."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import yaml
from boxes import Box, spin, view
from hypothesis import given
from hypothesis import strategies as st

from ovman.perception.backprojection import Camera
from ovman_released.dualmap_frames import (
    FramesError,
    camera_parameters,
    camera_to_world,
    focal_px,
    join,
    millimetres,
    read_lens,
    write_visit,
)

BOX = Box((0.8, 0.0, 1.9), (1.2, 0.5, 2.5), 0)
FLOOR_Y = 0.02
cameras = st.builds(
    Camera,
    st.tuples(*[st.floats(-5, 5)] * 3),
    st.floats(0, 360),
    st.floats(-30, 60),
    st.sampled_from([60.0, 90.0]),
)


def matrix(directory) -> np.ndarray:
    """The intrinsic matrix that DualMap makes of the settings of a visit."""
    c = camera_parameters(read_lens(directory))
    return np.array([[c["fx"], 0, c["cx"]], [0, c["fy"], c["cy"]], [0, 0, 1]])


def written(directory, cameras, **size):
    write_visit(directory, (view([BOX], camera, **size) for camera in cameras), FLOOR_Y)
    poses = np.loadtxt(directory / "pose.txt", ndmin=2)[:, 1:].reshape(-1, 4, 4)
    return poses, [cv2.imread(str(p), cv2.IMREAD_UNCHANGED) for p in sorted((directory / "depth").iterdir())]


@given(cameras)
def test_a_pose_is_a_proper_rotation_with_the_axes_of_opencv(camera):
    pose = camera_to_world(camera, 0.0)
    assert np.allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3)) and np.linalg.det(pose[:3, :3]) == pytest.approx(1)
    assert pose[3].tolist() == [0, 0, 0, 1]
    assert pose[2, 0] == pytest.approx(0), "the picture's rows are level"
    assert pose[2, 1] == pytest.approx(-np.cos(np.radians(camera.horizon_deg))), "its columns go down"
    assert pose[2, 2] == pytest.approx(-np.sin(np.radians(camera.horizon_deg))), "a positive horizon looks down"


@given(cameras, st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.5, 6)))
def test_a_known_point_is_seen_where_it_is(camera, ahead):
    point = camera.axes() @ ahead + camera.position
    height, width, focal = 480, 640, focal_px(480, camera.field_of_view_deg)
    inside = np.linalg.inv(camera_to_world(camera, FLOOR_Y)) @ [point[0], point[2], point[1] - FLOOR_Y, 1.0]
    assert inside[:3] == pytest.approx([ahead[0], -ahead[1], ahead[2]], abs=1e-9)
    u, v = focal * inside[0] / inside[2] + (width - 1) / 2, focal * inside[1] / inside[2] + (height - 1) / 2
    # A pixel's centre, which has half a pixel in our pictures, has none in DualMap's.
    assert u + 0.5 == pytest.approx(width / 2 + focal * ahead[0] / ahead[2])
    assert v + 0.5 == pytest.approx(height / 2 - focal * ahead[1] / ahead[2])


def test_two_views_of_a_box_project_back_to_the_same_box(tmp_path):
    places = [Camera((1.0, 1.6, 0.0), 0.0, 20.0, 90.0), Camera((2.8, 1.5, 3.6), 225.0, 25.0, 90.0)]
    poses, depths = written(tmp_path / "v", places, width=320, height=240)
    inverse = np.linalg.inv(matrix(tmp_path / "v"))
    # The box in DualMap's world: x, z and y of ours, over the floor.
    low, high = np.array([0.8, 1.9, 0.0 - FLOOR_Y]), np.array([1.2, 2.5, 0.5 - FLOOR_Y])
    for pose, depth in zip(poses, depths, strict=True):
        rows, columns = np.nonzero(depth)
        rays = np.stack([columns, rows, np.ones(len(rows))]) * (depth[rows, columns] / 1000.0)
        points = (pose[:3, :3] @ inverse @ rays + pose[:3, 3:]).T
        assert len(points) > 500
        assert (points >= low - 2e-3).all() and (points <= high + 2e-3).all()
        assert points[:, 2].max() == pytest.approx(high[2], abs=2e-3), "its top is seen"
        faces = np.abs(np.concatenate([points - low, points - high], axis=1)).min(axis=1)
        assert faces.max() < 2e-3, "every pixel lies on a face of it"


def test_depth_is_whole_millimetres_and_nothing_where_there_is_none():
    depth = np.array([[0.0, 0.0014, 1.2346, 65.535], [-1.0, np.nan, np.inf, 65.6]])
    found = millimetres(depth)
    assert found.dtype == np.uint16
    assert found.tolist() == [[0, 1, 1235, 65535], [0, 0, 0, 0]]


def test_joined_visits_are_one_sequence_in_which_time_goes_on(tmp_path):
    for name, x in (("a", 1.0), ("b", 1.5)):
        write_visit(tmp_path / name, (view([BOX], camera) for camera in spin(x, 0.5)[:3]), FLOOR_Y)
    settings = join([tmp_path / "a", tmp_path / "b"], tmp_path / "joined", "FloorPlan1_a_b")
    sequence = tmp_path / "joined" / "FloorPlan1_a_b"
    rows = np.loadtxt(sequence / "pose.txt")
    assert rows.shape == (6, 17) and rows[:, 0].tolist() == [0, 1, 2, 3, 4, 5]
    for number, (visit, at) in enumerate([("a", 0), ("a", 1), ("a", 2), ("b", 0), ("b", 1), ("b", 2)]):
        assert rows[number, 1:].tolist() == np.loadtxt(tmp_path / visit / "pose.txt")[at, 1:].tolist()
        for kind in ("rgb", "depth"):
            here, there = (sequence / kind / f"{number:06d}.png"), (tmp_path / visit / kind / f"{at:06d}.png")
            assert here.read_bytes() == there.read_bytes()
    said = yaml.safe_load(settings.read_text())
    assert said["dataset_name"] == "self_collected"
    expected = {"image_height": 48, "image_width": 64, "fx": 24.0, "fy": 24.0, "cx": 31.5, "cy": 23.5}
    assert said["camera_params"] == pytest.approx(expected | {"png_depth_scale": 1000.0, "crop_edge": 0})


def test_frames_that_cannot_be_one_sequence_are_refused(tmp_path):
    camera = spin(1.0, 0.5)[0]
    with pytest.raises(FramesError, match="without frames"):
        write_visit(tmp_path / "none", [], 0.0)
    with pytest.raises(FramesError, match="frame 1 has another size or lens"):
        write_visit(tmp_path / "two", [view([BOX], camera), view([BOX], camera, width=80)], 0.0)
    wide = Camera(camera.position, camera.yaw_deg, camera.horizon_deg, 60.0)
    write_visit(tmp_path / "a", [view([BOX], camera)], 0.0)
    write_visit(tmp_path / "b", [view([BOX], wide)], 0.0)
    with pytest.raises(FramesError, match="a, b were seen through different lenses"):
        join([tmp_path / "a", tmp_path / "b"], tmp_path / "joined", "s")
    with pytest.raises(FramesError, match="no frames of a visit"):
        join([tmp_path / "c"], tmp_path / "joined", "s")

"""What the unmodified client does by itself and reads from every event: sizes, numbers, units, and several engines at once."""

from __future__ import annotations

import numpy as np
import pytest
from ai2thor.server import DepthFormat


@pytest.fixture(scope="module")
def small(start):
    """A Controller with images below Unity's minimum, and its own clipping planes."""
    options = {"renderDepthImage": True, "cameraNearPlane": 0.3, "cameraFarPlane": 12, "fieldOfView": 60}
    with start(scene="FloorPlan401", width=200, height=150, depth_format=DepthFormat.Normalized, **options) as controller:
        yield controller


def test_small_pictures_and_planes_from_the_start(small):
    event = small.reset("FloorPlan401")
    assert event.frame.shape == (150, 200, 3) and event.depth_frame.shape == (150, 200)
    assert (
        (event.metadata["screenWidth"], event.metadata["screenHeight"]) == (200, 150) == (event.screen_width, event.screen_height)
    )
    assert event.metadata["actionReturn"] == {"cameraNearPlane": pytest.approx(0.3), "cameraFarPlane": 12.0}
    assert (small.server.camera_near_plane, small.server.camera_far_plane) == (pytest.approx(0.3), 12)
    assert event.metadata["fov"] == 60 and event.metadata["depthFormat"] == "Meters"


def test_depth_in_the_units_that_the_client_asks_for(small):
    """Depth in millimetres, and as a fraction of the range between the planes, comes from the same metres."""
    formats = {}
    for wanted in DepthFormat:
        small.server.depth_format = wanted
        formats[wanted] = small.reset("FloorPlan401").depth_frame
    small.server.depth_format = DepthFormat.Normalized
    metres = formats[DepthFormat.Meters]
    assert metres.dtype == np.float32 and 0.3 <= metres.min() < metres.max() < 12
    assert np.allclose(formats[DepthFormat.Millimeters], metres * 1000, rtol=1e-5)
    assert np.allclose(formats[DepthFormat.Normalized], metres / 11.7, rtol=1e-5)

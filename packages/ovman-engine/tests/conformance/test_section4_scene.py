"""Contract, section 4: third-party cameras, map view, spawning, materials, filters, and actions on the whole scene."""

from __future__ import annotations

import numpy as np
import pytest


def image(thor, **arguments):
    """An event with images."""
    return thor.controller.step(action="Pass", **arguments)


# The map


@pytest.mark.scenes(3)
def test_map_view_properties(thor):
    """The camera is over the centre of the scene and looks down on half its larger extent; nothing is toggled."""
    value = thor.ok("GetMapViewCameraProperties").metadata["actionReturn"]
    assert {"position", "rotation", "orthographicSize", "orthographic"} <= set(value)
    bounds = thor.metadata["sceneBounds"]
    assert value["orthographic"] is True and thor.metadata["cameraOrthSize"] == -1
    assert value["rotation"]["x"] == pytest.approx(90)
    assert value["orthographicSize"] == pytest.approx(max(bounds["size"]["x"], bounds["size"]["z"]) / 2, rel=0.15)
    assert abs(value["position"]["x"] - bounds["center"]["x"]) < 0.6 and abs(value["position"]["z"] - bounds["center"]["z"]) < 0.6
    assert value["position"]["y"] > thor.position[1] + 0.5
    event = thor.controller.step("AddThirdPartyCamera", **value)
    assert event and len(event.third_party_camera_frames) == 1
    thor.ok("ToggleMapView")
    assert thor.metadata["cameraOrthSize"] == pytest.approx(value["orthographicSize"], rel=1e-3)


# Filters and the rest


def test_object_filter(thor):
    every = set(thor.objects)
    some = set(thor.random.sample(sorted(every), 3))
    thor.ok("SetObjectFilter", objectIds=sorted(some))
    assert set(thor.objects) == some
    thor.ok("RotateRight")
    assert set(thor.objects) == some
    thor.ok("SetObjectFilter", objectIds=[])
    assert not thor.objects
    thor.ok("ResetObjectFilter")
    assert set(thor.objects) == every


@pytest.mark.scenes(1)
def test_quality_and_seed(thor):
    thor.ok("ChangeQuality", quality="Very Low")
    thor.ok("SetRandomSeed", seed=42)


@pytest.mark.scenes(4)
def test_reset_brings_the_same_world_back(thor):
    """The restored world does not depend on earlier actions and scenes."""
    before = thor.pose, {k: (v["position"], v["rotation"]) for k, v in thor.objects.items()}
    picture = image(thor).frame
    for record in thor.pickupable(2):
        thor.ok("RemoveFromScene", objectId=record["objectId"])
    thor.step("MoveAhead")
    thor.ok("RotateRight")
    thor.reset("FloorPlan405")
    thor.reset()
    assert (thor.pose, {k: (v["position"], v["rotation"]) for k, v in thor.objects.items()}) == before
    assert np.array_equal(image(thor).frame, picture)

"""Contract, section 4: filters and actions on the whole scene."""

from __future__ import annotations

import numpy as np
import pytest


def image(thor, **arguments):
    """An event with images."""
    return thor.controller.step(action="Pass", **arguments)


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

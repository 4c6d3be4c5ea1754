"""Metadata: all of AI2-THOR's keys, recorded numbers for untouched objects, and consistent numbers for touched ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ovman_engine.client.images import BACKGROUND, colour, colour_table
from ovman_engine.plan import floorplan
from ovman_engine.plan.floorplan import rotation_matrix

SCENES = ("FloorPlan1", "FloorPlan201", "FloorPlan311", "FloorPlan423")
SEEN = {"distance", "visible", "isInteractable"}
"""Keys that depend on the agent."""


def xyz(vector):
    return np.array([vector["x"], vector["y"], vector["z"]])


def corners(record):
    return np.array(record["cornerPoints"])


@pytest.mark.parametrize("scene", SCENES)
def test_untouched_objects_are_reported_as_recorded(engine, scene):
    agent = engine(scene).agent
    plan = floorplan.load(scene)
    assert len(agent["objects"]) == len(plan.objects)
    for reported, obj in zip(agent["objects"], plan.objects, strict=True):
        assert set(reported) == set(obj.record) and len(reported) == 42
        assert {k: v for k, v in reported.items() if k not in SEEN} == {k: v for k, v in obj.record.items() if k not in SEEN}
        assert reported["distance"] == pytest.approx(obj.record["distance"], abs=2e-3)
    low, high = corners(agent["sceneBounds"]).min(axis=0), corners(agent["sceneBounds"]).max(axis=0)
    assert (low <= xyz(agent["agent"]["position"])).all() and (xyz(agent["agent"]["position"]) <= high).all()


@settings(derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_an_object_that_was_put_somewhere_is_the_same_body_there(teleporting, data):
    """Boxes move rigidly with the pose, the aligned one holds the oriented one, and nothing else is touched."""
    plan = floorplan.load("FloorPlan201")
    obj = data.draw(st.sampled_from([o for o in plan.objects if o.dynamic]))
    position = np.array([data.draw(st.floats(-4, 0)), data.draw(st.floats(0.5, 2)), data.draw(st.floats(0.5, 6))])
    euler = np.array([data.draw(st.floats(-60, 60)), data.draw(st.floats(0, 360)), data.draw(st.floats(-60, 60))])
    before = {o["objectId"]: o for o in teleporting.do("Pass")["objects"]}
    after = teleporting.do(
        "TeleportObject",
        objectId=obj.object_id,
        position=dict(zip("xyz", position.tolist(), strict=True)),
        rotation=dict(zip("xyz", euler.tolist(), strict=True)),
        forceAction=True,
        forceKinematic=True,
    )
    assert after["lastActionSuccess"], after["errorMessage"]
    moved = teleporting.object(obj.object_id)
    assert np.allclose(xyz(moved["position"]), position)
    assert np.allclose(rotation_matrix(xyz(moved["rotation"])), rotation_matrix(euler), atol=1e-6)
    oriented, aligned = moved["objectOrientedBoundingBox"]["cornerPoints"], moved["axisAlignedBoundingBox"]
    recorded = np.array(obj.record["objectOrientedBoundingBox"]["cornerPoints"])
    gaps = np.linalg.norm(np.diff(oriented, axis=0), axis=1)
    assert np.allclose(gaps, np.linalg.norm(np.diff(recorded, axis=0), axis=1), atol=1e-4)
    low, high = corners(aligned).min(axis=0), corners(aligned).max(axis=0)
    assert (low - 2e-3 <= np.min(oriented, axis=0)).all() and (np.max(oriented, axis=0) <= high + 2e-3).all()
    assert np.allclose((low + high) / 2, xyz(aligned["center"])) and np.allclose(high - low, xyz(aligned["size"]))
    distance = np.linalg.norm(xyz(after["agent"]["position"]) - position)
    assert moved["distance"] == pytest.approx(distance, abs=1e-6)
    bystanders = [
        o for o in after["objects"] if o["objectType"] in ("Window", "Sofa", "Painting") and o["objectId"] != obj.object_id
    ]
    assert bystanders
    for other in bystanders:
        assert other["position"] == before[other["objectId"]]["position"]


@pytest.fixture(scope="module")
def teleporting(engine):
    return engine("FloorPlan201")


def receptacles_agree(agent):
    objects = {o["objectId"]: o for o in agent["objects"]}
    for name, record in objects.items():
        for parent in record["parentReceptacles"] or ():
            assert name in objects[parent]["receptacleObjectIds"], (name, parent)
        for child in record["receptacleObjectIds"] or ():
            assert name in objects[child]["parentReceptacles"], (name, child)
        assert record["parentReceptacles"] != [] and (record["receptacleObjectIds"] is not None) == record["receptacle"]


def test_receptacles_follow_what_moves(engine):
    scene = engine("FloorPlan201", autoSimulation=False)
    recorded = {o["objectId"]: (o["parentReceptacles"], o["receptacleObjectIds"]) for o in scene.agent["objects"]}
    book = next(o for o in scene.agent["objects"] if o["objectType"] == "Book")
    table = next(o for o in scene.agent["objects"] if o["objectType"] == "CoffeeTable")
    top = corners(table["axisAlignedBoundingBox"]).max(axis=0)[1]
    spot = {**table["axisAlignedBoundingBox"]["center"], "y": float(top) + 0.4}
    for other in table["receptacleObjectIds"] or ():
        scene.do("RemoveFromScene", objectId=other)
    agent = scene.do("PlaceObjectAtPoint", objectId=book["objectId"], position=spot, forceKinematic=True)
    assert agent["lastActionSuccess"], agent["errorMessage"]
    assert table["objectId"] in scene.object(book["objectId"])["parentReceptacles"]
    assert book["objectId"] in scene.object(table["objectId"])["receptacleObjectIds"]
    for parent in book["parentReceptacles"]:
        assert book["objectId"] not in (scene.object(parent)["receptacleObjectIds"] or ())
    receptacles_agree(agent)
    agent = scene.do("Reset", sceneName="FloorPlan201_physics")
    assert {o["objectId"]: (o["parentReceptacles"], o["receptacleObjectIds"]) for o in agent["objects"]} == recorded


def test_colours_tell_all_instances_and_classes_of_a_scene_apart():
    for name in floorplan.names():
        table = colour_table(tuple(o.object_id for o in floorplan.load(name).objects))
        colours = [tuple(entry["color"]) for entry in table]
        assert len(set(colours)) == len(colours) and (0, 0, 0) not in colours
        assert {entry["name"] for entry in table if "|" not in entry["name"]} == {o.type for o in floorplan.load(name).objects}
    assert colour("Chair") == colour("Chair") and BACKGROUND == 0xFF000000

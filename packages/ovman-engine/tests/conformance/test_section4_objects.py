"""Contract, section 4: placing and removing objects, and time."""

from __future__ import annotations

import numpy as np
import pytest

from conformance.conftest import xyz

NOTHING = "Nothing|+00.00|+00.00|+00.00"


def open_floor(thor, margin=0.5, count=1):
    """Reachable cells at least `margin` from the agent and from each other, and clear of the edge of the grid."""
    cells = thor.reachable()
    known = {(round(c["x"], 2), round(c["z"], 2)) for c in cells}
    inner = [
        c
        for c in cells
        if all((round(c["x"] + i, 2), round(c["z"] + j, 2)) in known for i in (-0.25, 0, 0.25) for j in (-0.25, 0, 0.25))
    ]
    thor.random.shuffle(inner)
    chosen = []
    for c in inner or cells:
        others = [thor.position, *map(xyz, chosen)]
        if all(np.hypot(c["x"] - o[0], c["z"] - o[2]) > margin for o in others):
            chosen.append(c)
        if len(chosen) == count:
            return chosen
    pytest.skip("the floor is too small")


def by_name(thor):
    return {o["name"]: o for o in thor.metadata["objects"]}


def settled(thor, limit=100):
    for _ in range(limit):
        if thor.ok("Pass").metadata["isSceneAtRest"]:
            return
    pytest.fail("never at rest")


# SetObjectPoses


@pytest.mark.scenes(4)
def test_set_object_poses_as_they_are(thor):
    """Poses of the metadata are accepted as they are."""
    before = by_name(thor)
    thor.ok("SetObjectPoses", objectPoses=thor.poses())
    after = by_name(thor)
    assert set(after) == set(before)
    for name, record in after.items():
        assert np.allclose(xyz(record["position"]), xyz(before[name]["position"]), atol=2e-2), name


def test_set_object_poses_takes_away_what_is_not_listed(thor):
    """Movable objects that are not listed leave the metadata; the rest of the scene stays."""
    movables, fixed = [o["name"] for o in thor.movables()], {o["name"] for o in thor.metadata["objects"]}
    fixed -= set(movables)
    poses = thor.poses()
    keep = {p["objectName"] for p in thor.random.sample(poses, len(poses) // 2)}
    thor.ok("SetObjectPoses", objectPoses=[p for p in poses if p["objectName"] in keep])
    left = set(by_name(thor))
    assert keep <= left <= keep | fixed
    assert all(name.startswith(("Drawer", "Cabinet", "Shelf")) for name in fixed - left), "parts go with the whole"
    thor.reset()
    assert set(by_name(thor)) == set(movables) | fixed


def test_set_object_poses_twice_makes_a_copy(thor):
    (record,) = thor.pickupable()
    one, two = open_floor(thor, count=2)
    extra = [
        {"objectName": record["name"], "position": {"x": c["x"], "y": 1.2, "z": c["z"]}, "rotation": record["rotation"]}
        for c in (one, two)
    ]
    others = [p for p in thor.poses() if p["objectName"] != record["name"]]
    thor.ok("SetObjectPoses", objectPoses=others + extra)
    copies = [o for o in thor.metadata["objects"] if o["name"].startswith(f"{record['name']}_copy_")]
    assert record["name"] in by_name(thor) and len(copies) == 1
    assert copies[0]["objectType"] == record["objectType"] and copies[0]["objectId"] != by_name(thor)[record["name"]]["objectId"]


def test_set_object_poses_with_an_unknown_name(thor):
    """The action fails, and still places the others."""
    (record,) = thor.pickupable()
    (cell,) = open_floor(thor)
    target = {"x": cell["x"], "y": 1.3, "z": cell["z"]}
    poses = [p if p["objectName"] != record["name"] else {**p, "position": target} for p in thor.poses()]
    poses.append({"objectName": "Nothing_1", "position": target, "rotation": record["rotation"]})
    thor.refused("SetObjectPoses", "No Pickupable or Moveable object of name Nothing_1 found in scene.", objectPoses=poses)
    assert np.allclose(xyz(by_name(thor)[record["name"]]["position"]), xyz(target), atol=2e-2)


def test_set_object_poses_that_skips_moveables_leaves_the_furniture(thor):
    """As RoomR does: only pickupable objects are listed, and furniture stays."""
    before = by_name(thor)
    names = {o["name"] for o in thor.metadata["objects"] if o["pickupable"]}
    poses = [p for p in thor.poses() if p["objectName"] in names][::2]
    thor.ok("SetObjectPoses", objectPoses=poses, placeStationary=False, forceRigidbodySleep=True, skipMoveable=True)
    after = by_name(thor)
    assert set(after) == (set(before) - names) | {p["objectName"] for p in poses}
    for name, record in after.items():
        assert np.allclose(xyz(record["position"]), xyz(before[name]["position"]), atol=1e-6), name


# PlaceObjectAtPoint


def test_place_object_refusals(thor):
    (record,) = thor.pickupable()
    inside = thor.agent["position"]
    thor.refused("PlaceObjectAtPoint", f"Cannot find object with id {NOTHING}", objectId=NOTHING, position=inside)
    before = record["position"]
    thor.refused(
        "PlaceObjectAtPoint", "is not within scene bounds", objectId=record["objectId"], position={"x": 70.0, "y": 1.0, "z": 70.0}
    )
    assert thor.objects[record["objectId"]]["position"] == before


# TeleportObject


@pytest.mark.scenes(3)
def test_teleport_object_into_another(thor):
    """The action is refused with the obstacle's name and undone, unless it is forced."""
    record = thor.pickupable()[0]
    big = max(
        (o for o in thor.metadata["objects"] if o["objectType"] not in ("Floor", "Window", "Wall") and not o["pickupable"]),
        key=lambda o: np.prod(list(o["axisAlignedBoundingBox"]["size"].values())),
    )
    target = big["axisAlignedBoundingBox"]["center"]
    before = record["position"]
    event = thor.step("TeleportObject", objectId=record["objectId"], position=target, rotation=record["rotation"])
    if not event:
        assert f"{record['objectId']} is colliding with " in event.metadata["errorMessage"]
        assert event.metadata["errorMessage"].endswith("after teleport.")
        assert thor.objects[record["objectId"]]["position"] == before
    thor.ok("TeleportObject", objectId=record["objectId"], position=target, rotation=record["rotation"], forceAction=True)


# DisableObject, EnableObject, RemoveFromScene


def test_disabled_object_is_not_seen(thor):
    """A disabled object has no pixels and is listed as not visible; EnableObject restores it; a second call changes nothing."""
    for record in thor.pickupable(10):
        poses = thor.ok("GetInteractablePoses", objectId=record["objectId"], maxPoses=3).metadata["actionReturn"]
        for pose in poses:
            event = thor.look(**pose)
            if event.instance_masks.mask(record["objectId"]) is None or event.instance_masks.mask(record["objectId"]).sum() < 5:
                continue
            picture = event.frame.copy()
            for _ in range(2):
                thor.ok("DisableObject", objectId=record["objectId"])
            event = thor.look()
            mask = event.instance_masks.mask(record["objectId"])
            assert (mask is None or not mask.any()) and not thor.objects[record["objectId"]]["visible"]
            assert not np.array_equal(event.frame, picture)
            for _ in range(2):
                thor.ok("EnableObject", objectId=record["objectId"])
            assert np.array_equal(thor.look().frame, picture)
            return
    pytest.skip("nothing small was to be seen")


def test_remove_from_scene(thor):
    one, two, three = (r["objectId"] for r in thor.pickupable(3))
    count = len(thor.objects)
    thor.ok("RemoveFromScene", objectId=one)
    assert one not in thor.objects and len(thor.objects) == count - 1
    thor.ok("RemoveFromScene", objectIds=[two, three])
    assert not {one, two, three} & set(thor.objects)
    thor.refused("RemoveFromScene", objectId=one)
    thor.refused("DisableObject", objectId=two)
    thor.reset()
    assert {one, two, three} <= set(thor.objects) and len(thor.objects) == count


# Time


@pytest.mark.scenes(3)
def test_physics_by_hand(thor):
    """While physics is paused, an object stays in the air through any number of actions; steps move it; after unpausing, it
    falls.
    """
    (record,) = thor.pickupable()
    (cell,) = open_floor(thor)
    target = {"x": cell["x"], "y": 1.6, "z": cell["z"]}
    thor.ok("PausePhysicsAutoSim")
    thor.ok("TeleportObject", objectId=record["objectId"], position=target, rotation=record["rotation"])

    def height():
        return thor.objects[record["objectId"]]["position"]["y"]

    for _ in range(3):
        thor.ok("Pass")
    assert height() == pytest.approx(1.6, abs=1e-3)
    heights = [height()]
    for _ in range(8):
        thor.ok("AdvancePhysicsStep", timeStep=0.02)
        heights.append(height())
    assert all(a >= b for a, b in zip(heights, heights[1:], strict=False)) and heights[-1] < 1.6 - 0.05
    assert heights[0] - heights[-1] < 0.5 * 9.81 * (9 * 0.02) ** 2 + 0.05
    thor.ok("UnpausePhysicsAutoSim")
    settled(thor)
    assert height() < heights[-1]

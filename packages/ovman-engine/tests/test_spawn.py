"""Free places and random arrangements: objects are put where their type belongs, stay there, and overlap nothing. Contract,
section 4: GetSpawnCoordinatesAboveReceptacle, InitialRandomSpawn.
"""

from __future__ import annotations

import numpy as np
import pytest

from ovman_engine.plan import floorplan
from ovman_engine.world.placement import RECEPTACLES
from ovman_engine.world.spawn import SpawnOptions, spawn
from ovman_engine.world.world import World

SCENES = ("FloorPlan11", "FloorPlan310")
OPEN = ("CounterTop", "DiningTable", "CoffeeTable", "SideTable", "Desk", "Sofa", "Bed", "Shelf", "TVStand", "Dresser", "ArmChair")


def poses(metadata):
    return {o["objectId"]: (*o["position"].values(), *o["rotation"].values()) for o in metadata["objects"]}


def small(metadata):
    """A small object that fits nearly everywhere."""
    sizes = {o["objectId"]: max(o["axisAlignedBoundingBox"]["size"].values()) for o in metadata["objects"] if o["pickupable"]}
    fitting = [name for name, size in sizes.items() if 0.04 < size < 0.13]
    return min(fitting, key=lambda name: (sizes[name], name))


def test_points_are_above_the_receptacle_and_usable(engine):
    """What PlaceObjectAtPoint puts at a point is then on the receptacle."""
    checked = 0
    for scene in SCENES:
        world = engine(scene)
        thing = small(world.agent)
        world.do("DisableObject", objectId=thing)
        for receptacle in [o for o in world.agent["objects"] if o["objectType"] in OPEN][:4]:
            found = world.do("GetSpawnCoordinatesAboveReceptacle", objectId=receptacle["objectId"])["actionReturn"]
            box = receptacle["axisAlignedBoundingBox"]
            for point in found:
                for axis in "xz":
                    assert abs(point[axis] - box["center"][axis]) <= box["size"][axis] / 2 + 1e-6
                assert point["y"] > box["center"]["y"] - box["size"]["y"] / 2
            for point in found[:: max(len(found) // 2, 1)][:2]:
                world.do("EnableObject", objectId=thing)
                answer = world.do("PlaceObjectAtPoint", objectId=thing, position=point)
                assert answer["lastActionSuccess"], (scene, receptacle["objectId"], point, answer["errorMessage"])
                assert receptacle["objectId"] in world.object(thing)["parentReceptacles"], (scene, receptacle["objectId"], point)
                world.do("DisableObject", objectId=thing)
                checked += 1
    assert checked > 8


@pytest.fixture(scope="module")
def untouched(engine):
    """A scene that no test changes."""
    return engine("FloorPlan203")


def test_no_points(untouched):
    apart = next(o for o in untouched.agent["objects"] if not o["receptacle"])["objectId"]
    for object_id, start in ((apart, apart), ("Nothing|+00.00|+00.00|+00.00", "Cannot find sim object with id")):
        answer = untouched.do("GetSpawnCoordinatesAboveReceptacle", objectId=object_id)
        assert not answer["lastActionSuccess"] and answer["errorMessage"].startswith(start)


@pytest.mark.parametrize("scene", SCENES)
def test_random_arrangement(engine, scene):
    """Most objects get new places, each on a receptacle for its type, and are still there forty steps later."""
    world = engine(scene)
    before = poses(world.agent)
    answer = world.do("InitialRandomSpawn", randomSeed=5)
    assert answer["lastActionSuccess"], answer["errorMessage"]
    after = poses(world.agent)
    assert after.keys() == before.keys()
    pickupable = {o["objectId"] for o in world.agent["objects"] if o["pickupable"]}
    moved = {name for name in before if before[name] != after[name]}
    assert moved <= pickupable and len(moved) > 0.7 * len(pickupable)
    types = {o["objectId"]: o["objectType"] for o in world.agent["objects"]}
    for name in moved:
        parents = {types[p] for p in world.object(name)["parentReceptacles"] or ()}
        assert parents & RECEPTACLES[types[name]] and parents != {"Floor"}, (name, parents)
    for _ in range(40):
        world.do("Pass")
    assert poses(world.agent) == after


@pytest.mark.parametrize("scene", SCENES)
def test_nothing_overlaps(scene):
    """Boxes of placed objects do not overlap, and physics finds no contact deeper than a millimetre."""
    world = World(floorplan.load(scene))
    spawn(world, SpawnOptions(seed=2, no_receptacles=frozenset(["Floor"])))
    moved = [b for b in world.bodies.values() if not b.untouched]
    with world.trial([b.object_id for b in moved]) as model:
        for body in moved:
            assert all(depth <= 0.0015 for _, depth in model.touching(body.object_id)), body.object_id
    bounds = [b.box.bounds() for b in moved]
    low, high = np.array([b[0] for b in bounds]), np.array([b[1] for b in bounds])
    apart = ((low[:, None] >= high[None] - 1e-6) | (high[:, None] <= low[None] + 1e-6)).any(axis=2)
    assert (apart | np.eye(len(moved), dtype=bool)).all()


def test_only_what_is_asked_for(engine):
    world = engine("FloorPlan11")
    before = poses(world.agent)
    things = [o["objectId"] for o in world.agent["objects"] if o["pickupable"]]
    table = next(o["objectId"] for o in world.agent["objects"] if o["objectType"] == "CounterTop")

    def moved(**arguments):
        world.do("Reset", sceneName="FloorPlan11_physics")
        assert world.do("InitialRandomSpawn", randomSeed=1, **arguments)["lastActionSuccess"]
        after = poses(world.agent)
        return {name for name in before if after[name] != before[name]}

    assert moved(objectIds=things[:3]) <= set(things[:3])
    assert not moved(excludedObjectIds=things[:5]) & set(things[:5])
    for name in moved(receptacleObjectIds=[table]):
        assert table in world.object(name)["parentReceptacles"]
    for name in moved(excludedReceptacles=["CounterTop"]):
        assert all(not p.startswith("CounterTop") for p in world.object(name)["parentReceptacles"] or ())


def test_duplicates(engine):
    world = engine("FloorPlan11")
    kind = "Apple"
    count = lambda: [o for o in world.agent["objects"] if o["objectType"] == kind]  # noqa: E731
    assert len(count()) == 1
    original = count()[0]
    answer = world.do("InitialRandomSpawn", randomSeed=1, numDuplicatesOfType=[{"objectType": kind, "count": 4}])
    assert answer["lastActionSuccess"], answer["errorMessage"]
    found = {o["objectId"]: o for o in count()}
    assert set(found) == {original["objectId"], *(f"{original['objectId']}_copy_{k}" for k in range(3))}
    assert {o["name"] for o in found.values()} == {original["name"], *(f"{original['name']}_random_copy_{k}" for k in range(3))}
    assert len({tuple(o["position"].values()) for o in found.values()}) == 4
    assert {o["assetId"] for o in found.values()} == {original["assetId"]}
    world.do("Reset", sceneName="FloorPlan11_physics")
    assert len(count()) == 1


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        ({"numPlacementAttempts": 0}, "numPlacementAttempts must be a positive integer."),
        ({"excludedReceptacles": ["Tables"]}, "invalid Object Type used in excludedReceptacles array: Tables"),
        ({"excludedObjectIds": ["Cup|1"]}, "Cannot find sim object with id 'Cup|1'"),
        ({"numDuplicatesOfType": [{"objectType": "Unicorn", "count": 2}]}, "ArgumentException: Requested value 'Unicorn'"),
        ({"numDuplicatesOfType": ["Apple"]}, "numDuplicatesOfType takes entries like"),
    ],
)
def test_refusals_leave_everything(untouched, arguments, start):
    before = poses(untouched.agent)
    answer = untouched.do("InitialRandomSpawn", **arguments)
    assert not answer["lastActionSuccess"] and answer["errorMessage"].startswith(start), answer["errorMessage"]
    assert poses(untouched.agent) == before

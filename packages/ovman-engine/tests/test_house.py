"""ProcTHOR houses: rooms and walls as the JSON has them, seen, walked and handled through the real Controller.
Contract, section 1 item 7 and section 4 (CreateHouse).
"""

from __future__ import annotations

import copy

import numpy as np
import pytest

from ovman_engine.plan.assets import asset
from ovman_engine.plan.house_json import InvalidHouse, read
from ovman_engine.plan.houseplan import plan_of
from ovman_engine.room.building import room_of

HEIGHT = 2.7
WEST, EAST = [(0, 0), (0, 4), (5, 4), (5, 0)], [(5, 0), (5, 4), (9, 4), (9, 2), (7, 2), (7, 0)]
"""Floors of two rooms, the second L-shaped, with a wall between them at x = 5."""


def point(x, z, y=0.0):
    return {"x": x, "y": y, "z": z}


def room(number, kind, polygon):
    return {
        "id": f"room|{number}",
        "roomType": kind,
        "floorMaterial": {"name": f"Floor{number}"},
        "floorPolygon": [point(*p) for p in polygon],
    }


def walls(number, polygon):
    out = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        (x_0, x_1), (z_0, z_1) = sorted((a[0], b[0])), sorted((a[1], b[1]))
        corners = [point(*a), point(*b), point(*a, HEIGHT), point(*b, HEIGHT)]
        name = f"wall|{number}|{x_0:.2f}|{z_0:.2f}|{x_1:.2f}|{z_1:.2f}"
        out.append({"id": name, "roomId": f"room|{number}", "polygon": corners, "material": {"name": f"Wall{number}"}})
    return out


def thing(name, asset_id, x, z, below=0.0, **more):
    """An object that stands on what is `below` metres high."""
    size = asset(asset_id).size
    return {"id": name, "assetId": asset_id, "position": point(x, z, below + float(size[1]) / 2), "rotation": point(0, 0), **more}


def house(openness=1):
    """Two rooms and a door between them, 1 to 2 m from the end of the wall at z = 4."""
    table = "Dining_Table_16_1"
    top = float(asset(table).size[1])
    return {
        "rooms": [room(2, "LivingRoom", WEST), room(3, "Bedroom", EAST)],
        "walls": [*walls(2, WEST), *walls(3, EAST)],
        "doors": [
            {
                "id": "door|2|3",
                "assetId": "Doorway_1",
                "openable": True,
                "openness": openness,
                "room0": "room|2",
                "room1": "room|3",
                "wall0": "wall|2|5.00|0.00|5.00|4.00",
                "wall1": "wall|3|5.00|0.00|5.00|4.00",
                "holePolygon": [point(1, 0), point(2, 0, 2.1)],
            }
        ],
        "windows": [
            {
                "id": "window|2|0",
                "assetId": "Window_Hung_48x44",
                "room0": "room|2",
                "room1": "room|2",
                "wall0": "wall|2|0.00|4.00|5.00|4.00",
                "holePolygon": [point(2, 0, 1.0), point(3.2, 0, 2.1)],
            }
        ],
        "objects": [
            thing("DiningTable|2|0", table, 1.5, 2.5, kinematic=True, children=[thing("Apple|2|1", "Apple_1", 1.5, 2.5, top)]),
            thing("Bed|3|0", "Bed_1", 8.1, 2.9, kinematic=True),
        ],
        "metadata": {"agent": {"position": point(3.5, 2.0, 0.95), "rotation": point(0, 0, 270), "horizon": 30, "standing": True}},
    }


@pytest.fixture
def home(reset):
    return reset(house(), snapToGrid=False, renderDepthImage=True, renderInstanceSegmentation=True)


def reached(controller):
    found = controller.step("GetReachablePositions").metadata["actionReturn"]
    return np.array([(p["x"], p["z"]) for p in found])


def test_metadata(home):
    """Objects have their own ids and poses; the floors are those of the rooms."""
    objects = {o["objectId"]: o for o in home.last_event.metadata["objects"]}
    assert set(objects) == {"room|2", "room|3", "door|2|3", "window|2|0", "DiningTable|2|0", "Apple|2|1", "Bed|3|0"}
    types = {name: o["objectType"] for name, o in objects.items()}
    assert types["room|2"] == "Floor" and types["door|2|3"] == "Doorway" and types["Apple|2|1"] == "Apple"
    assert all(len(o) == 42 for o in objects.values())
    for given in (*house()["objects"], *house()["objects"][0]["children"]):
        box = objects[given["id"]]["axisAlignedBoundingBox"]
        assert [box["center"][a] for a in "xyz"] == pytest.approx([given["position"][a] for a in "xyz"], abs=1e-6)
        assert [box["size"][a] for a in "xyz"] == pytest.approx(asset(given["assetId"]).size, abs=1e-6)
    assert objects["Apple|2|1"]["parentReceptacles"] == ["DiningTable|2|0"]
    assert objects["DiningTable|2|0"]["receptacleObjectIds"] == ["Apple|2|1"]
    assert objects["Apple|2|1"]["pickupable"] and objects["Bed|3|0"]["moveable"] and objects["DiningTable|2|0"]["receptacle"]
    assert objects["Bed|3|0"]["parentReceptacles"] == ["room|3"]
    assert objects["door|2|3"]["isOpen"] and objects["door|2|3"]["openable"]


def test_walls_stop_and_doors_let_through(home):
    """All free points of both rooms are reached, none is in a wall, and the way leads through the door."""
    found = reached(home)
    assert (found[:, 0] < 4.5).sum() > 100 and (found[:, 0] > 5.5).sum() > 50
    assert not ((found[:, 0] > 7) & (found[:, 1] < 2)).any()
    assert (found >= 0.2).all() and (found[:, 0] <= 8.8).all() and (found[:, 1] <= 3.8).all()
    between = found[np.abs(found[:, 0] - 5.0) < 0.2]
    assert len(between) and (between[:, 1] > 2.0).all() and (between[:, 1] < 3.0).all()
    step = home.step("TeleportFull", position=point(4.5, 1.0, 0.9), rotation=point(0, 0, 90), horizon=0, standing=True)
    assert step.metadata["lastActionSuccess"]
    blocked = home.step("MoveAhead", moveMagnitude=0.5)
    assert not blocked.metadata["lastActionSuccess"] and "wall|" in blocked.metadata["errorMessage"]


def test_pictures(home):
    """Every pixel shows the house; the depth of a wall is its distance; the other room is visible through the door."""
    event = home.step("TeleportFull", position=point(3.0, 2.5, 0.9), rotation=point(0, 0, 90), horizon=0, standing=True)
    assert event.frame.std() > 10
    assert {"door|2|3", "room|2", "room|3", "wall|2|5.00|0.00|5.00|4.00"} <= set(event.instance_masks)
    assert sum(mask.sum() for mask in event.instance_masks.values()) > 0.999 * 300 * 300
    wall = event.instance_masks["wall|2|5.00|0.00|5.00|4.00"]
    assert event.depth_frame[wall] == pytest.approx(2.0, abs=0.01)
    event = home.step("TeleportFull", position=point(2.6, 2.5, 0.9), rotation=point(0, 0, 0), horizon=0, standing=True)
    assert "window|2|0" in event.instance_masks


def test_things_are_handled(home):
    """Both rooms have a floor, tables hold what is put on them, and walls let nothing pass."""
    placed = home.step("PlaceObjectAtPoint", objectId="Apple|2|1", position=point(6.0, 1.0, 1.0))
    assert placed.metadata["lastActionSuccess"], placed.metadata["errorMessage"]
    apple = next(o for o in placed.metadata["objects"] if o["objectId"] == "Apple|2|1")
    assert apple["parentReceptacles"] == ["room|3"]
    spots = home.step("GetSpawnCoordinatesAboveReceptacle", objectId="DiningTable|2|0").metadata["actionReturn"]
    assert len(spots) > 10
    back = home.step("PlaceObjectAtPoint", objectId="Apple|2|1", position=spots[len(spots) // 2])
    apple = next(o for o in back.metadata["objects"] if o["objectId"] == "Apple|2|1")
    assert apple["parentReceptacles"] == ["DiningTable|2|0"]
    assert home.step("InitialRandomSpawn", randomSeed=1).metadata["lastActionSuccess"]
    plain = home.step("Pass").frame
    assert (home.step("RandomizeMaterials").frame != plain).any() and (home.step("ResetMaterials").frame == plain).all()


@pytest.fixture(scope="module")
def empty(engine):
    """An engine that awaits a house."""
    world = engine()
    world.do("Reset", sceneName="Procedural")
    return world


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (lambda h: h.pop("rooms"), "rooms is empty"),
        (lambda h: h["rooms"][0].pop("floorPolygon"), "house.rooms[0] has no 'floorPolygon'"),
        (lambda h: h["rooms"][1].update(id="room|2"), "two things have the id 'room|2'"),
        (lambda h: h["rooms"][0].update(floorPolygon=[point(0, 0), point(1, 1), point(2, 2)]), "encloses nothing"),
        (
            lambda h: h["rooms"][0].update(floorPolygon=[point(*p) for p in WEST * 2]),
            "house.rooms[0].floorPolygon encloses no floor",
        ),
        (lambda h: h["rooms"][0].update(floorPolygon=[point(x, x % 2) for x in range(201)]), "201 points; at most 200"),
        (lambda h: h["walls"][0].update(polygon=[]), "house.walls[0].polygon is a list of at least three points"),
        (lambda h: h["walls"][0]["polygon"][1].update(x=1e30), "house.walls[0].polygon[1].x is a number within 1000"),
        (lambda h: h["doors"][0].update(wall0="wall|9"), "house.doors[0].wall0 is the id of none of its walls"),
        (lambda h: h["objects"][0].update(assetId="Unicorn_1"), "house.objects[0].assetId: there is no asset 'Unicorn_1'"),
        (lambda h: h["objects"][0]["children"][0].pop("position"), "house.objects[0].children[0] has no 'position'"),
        (lambda h: h.update(objects={"a": 1}), "house.objects is a list"),
    ],
)
def test_what_is_no_house(empty, broken, message):
    """The refusal names the place and the reason, and the scene stays."""
    given = copy.deepcopy(house())
    broken(given)
    with pytest.raises(InvalidHouse) as caught:
        read(given)
    assert message in str(caught.value)
    before = [o["objectId"] for o in empty.agent["objects"]]
    answer = empty.do("CreateHouse", house=given)
    assert not answer["lastActionSuccess"] and message in answer["errorMessage"]
    assert [o["objectId"] for o in empty.agent["objects"]] == before


def test_a_house_is_built_once_and_shown_as_at_first(reset, empty):
    """CreateHouse undoes all changes of a house. A house with other contents has its own plan."""

    def seen(given):
        controller = reset(given, snapToGrid=False, renderDepthImage=True, renderInstanceSegmentation=True)
        event = controller.last_event
        return controller, event.metadata["objects"], event.frame, event.depth_frame, event.instance_segmentation_frame

    controller, *before = seen(house())
    assert controller.step("DisableObject", objectId="Apple|2|1").metadata["lastActionSuccess"]
    place = [{"objectName": "Bed|3|0", "position": point(6.0, 2.5, 0.3), "rotation": point(0, 0)}]
    assert controller.step("SetObjectPoses", objectPoses=place).metadata["lastActionSuccess"]
    controller.step("RandomizeLighting", brightness=[0.4, 0.4])
    assert (controller.last_event.frame != before[1]).any()
    for one, other in zip(before, seen(house())[1:], strict=True):
        assert one == other if isinstance(one, list) else np.array_equal(one, other)
    moved = house()
    moved["objects"][1]["position"]["x"] += 0.1
    assert seen(moved)[1] != before[0]

    def plan(given):
        assert empty.do("CreateHouse", house=given)["lastActionSuccess"]
        return empty.engine.session.world.plan

    assert plan(house()) is plan(house()) and plan(moved) is not plan(house())


def test_looks_depend_on_the_building_alone(reset):
    """An object less, or a second one of the same asset, changes no pixel of what else is in view."""

    def frame_and_masks(objects):
        given = house() | {"objects": objects}
        event = reset(given, snapToGrid=False, renderInstanceSegmentation=True).last_event
        return event.frame, event.instance_masks

    first, second = thing("Chair|2|5", "Chair_007_1", 1.0, 1.0), thing("Chair|2|6", "Chair_007_1", 1.0, 3.0)
    bed = house()["objects"][1]
    frame, masks = frame_and_masks([first, second, bed])
    for objects in ([first, bed], [first, second], [second, first, bed]):
        other, others = frame_and_masks(objects)
        same = masks["Chair|2|5"]
        assert same.sum() > 200 and np.array_equal(same, others["Chair|2|5"])
        assert np.array_equal(frame[same], other[same])
        if "Chair|2|6" in others:
            assert np.array_equal(frame, other)


def house_with_rug():
    """The house with a floor that happens to have a rug in the first room; some rooms have none."""
    for number in range(30):
        given = house()
        given["rooms"][0]["floorMaterial"] = {"name": f"Floor{number}"}
        if "rug|room|2" in {name for name, _, _ in room_of(plan_of(read(given))).parts()}:
            return given
    raise AssertionError("no house has a rug")


def test_rugs_and_curtains_hide_nothing_and_stop_nobody(reset):
    """A card on a rug is seen, the rug is walked on, a window shows between its curtains; a map shows no ceiling."""
    x, z = 2.5, 2.0
    given = house_with_rug() | {"objects": [thing("CreditCard|2|7", "CreditCard_1", x, z)]}
    home = reset(given, snapToGrid=False, renderInstanceSegmentation=True)
    assert np.hypot(*(reached(home) - (x, z)).T).min() < 0.3  # the card keeps its own cell
    stand = {"position": point(x, z - 0.6, 0.9), "rotation": point(0, 0, 0), "standing": True}
    down = home.step("TeleportFull", **stand, horizon=60).instance_masks
    assert down["CreditCard|2|7"].sum() > 20 and down["rug|room|2"].sum() > 1000
    ahead = home.step("TeleportFull", **stand, horizon=0).instance_masks
    assert 0 < ahead["curtains|window|2|0"].sum() < 2 * ahead["window|2|0"].sum()
    home.step(
        "AddThirdPartyCamera", position=point(x, z, 10), rotation={"x": 90, "y": 0, "z": 0}, orthographic=True, orthographicSize=3
    )
    above = home.step("ToggleMapView").instance_masks
    assert above["CreditCard|2|7"].any() and not any(name.startswith("ceiling|") for name in above)


def test_rugs_and_curtains_stay_in_their_room():
    """Curtains and rugs, which do not collide, stay near the walls or flat on the floor."""
    plan = plan_of(read(house_with_rug()))
    parts = {name: parts for name, parts, _ in room_of(plan).parts()}
    assert {"curtains|window|2|0", "rug|room|2"} <= set(parts)
    for name, own in parts.items():
        low = np.min([p.centre - np.abs(p.rotation) @ p.size / 2 for p in own], axis=0)
        high = np.max([p.centre + np.abs(p.rotation) @ p.size / 2 for p in own], axis=0)
        if name.startswith("rug|"):
            floor = WEST if name == "rug|room|2" else EAST
            assert (low[[0, 2]] > np.min(floor, axis=0)).all() and (high[[0, 2]] < np.max(floor, axis=0)).all()
            assert low[1] == 0 and high[1] < 0.004  # the thinnest asset, a CD, has 4 mm
        elif name.startswith("curtains|"):
            assert 3.8 < low[2] < high[2] < 4.0 and 1.7 < low[0] < 2.0 and 3.2 < high[0] < 3.5 and high[1] < HEIGHT

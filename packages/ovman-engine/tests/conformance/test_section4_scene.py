"""Contract, section 4: third-party cameras, map view, spawning, materials, filters, and actions on the whole scene."""

from __future__ import annotations

import numpy as np
import pytest
from test_house import house

from conformance.conftest import BASE, xyz

NOTHING = "Nothing|+00.00|+00.00|+00.00"
FLAT = {"x": 0.0, "y": 0.0, "z": 0.0}


def image(thor, **arguments):
    """An event with images."""
    return thor.controller.step(action="Pass", **arguments)


# Third-party cameras


@pytest.mark.contract("4 AddThirdPartyCamera", "1.9")
def test_add_third_party_camera(thor):
    """The camera's pose is in the metadata; each event has one more image of each enabled kind; a reset removes the camera."""
    position, rotation = {**thor.agent["position"], "y": 1.6}, {"x": 20.0, "y": 40.0, "z": 0.0}
    event = thor.controller.step("AddThirdPartyCamera", position=position, rotation=rotation, fieldOfView=60)
    assert event
    (camera,) = event.metadata["thirdPartyCameras"]
    assert camera["thirdPartyCameraId"] == 0 and camera["fieldOfView"] == pytest.approx(60)
    assert np.allclose(xyz(camera["position"]), xyz(position), atol=1e-3)
    assert np.allclose(xyz(camera["rotation"]), xyz(rotation), atol=1e-2)
    assert [f.shape for f in event.third_party_camera_frames] == [(150, 200, 3)]
    assert [f.shape for f in event.third_party_depth_frames] == [(150, 200)]
    assert [f.shape for f in event.third_party_instance_segmentation_frames] == [(150, 200, 3)]
    assert event.third_party_camera_frames[0].std() > 3 and event.frame is not None
    thor.controller.step("AddThirdPartyCamera", position=position, rotation={**rotation, "y": 220.0})
    event = image(thor)
    assert [c["thirdPartyCameraId"] for c in event.metadata["thirdPartyCameras"]] == [0, 1]
    assert event.metadata["thirdPartyCameras"][1]["fieldOfView"] == pytest.approx(90)
    assert len(event.third_party_camera_frames) == len(event.third_party_depth_frames) == 2
    assert not np.array_equal(*event.third_party_camera_frames)
    thor.reset()
    event = image(thor)
    assert not event.metadata["thirdPartyCameras"] and not event.third_party_camera_frames


@pytest.mark.contract("4 AddThirdPartyCamera", "1.10")
def test_third_party_camera_at_the_agents_eye_sees_what_the_agent_sees(thor):
    thor.reset(renderSemanticSegmentation=True, renderNormalsImage=True)
    event = thor.look(position=thor.free_cell(), rotation=90, horizon=30, standing=True)
    event = thor.controller.step(
        "AddThirdPartyCamera",
        position=event.metadata["cameraPosition"],
        rotation={"x": 30.0, "y": 90.0, "z": 0.0},
        fieldOfView=90,
    )
    same = np.abs(event.third_party_depth_frames[0] - event.depth_frame) < 0.02
    agreed = (event.third_party_instance_segmentation_frames[0] == event.instance_segmentation_frame).all(axis=2)
    assert same.mean() > 0.9 and agreed.mean() > 0.9
    assert len(event.third_party_semantic_segmentation_frames) == len(event.third_party_normals_frames) == 1


@pytest.mark.contract("4 AddThirdPartyCamera")
@pytest.mark.parametrize("fov", [0, -1, 180, 270])
@pytest.mark.scenes(1)
def test_add_third_party_camera_refusals(thor, fov):
    event = thor.refused("AddThirdPartyCamera", "fov", position=FLAT, rotation=FLAT, fieldOfView=fov)
    assert not event.metadata["thirdPartyCameras"]


@pytest.mark.contract("4 AddThirdPartyCamera")
def test_third_party_camera_options(thor):
    """Orthographic, planes, the colour of the sky."""
    over = {**thor.agent["position"], "y": 2.0}
    event = thor.controller.step(
        "AddThirdPartyCamera",
        position=over,
        rotation={"x": 90.0, "y": 0.0, "z": 0.0},
        orthographic=True,
        orthographicSize=1.5,
        skyboxColor="white",
        nearClippingPlane=0.05,
        farClippingPlane=30.0,
    )
    assert event and event.third_party_camera_frames[0].shape == (150, 200, 3)
    low = thor.position[1] - 0.9
    assert np.median(event.third_party_depth_frames[0]) < 2.0 - low + 0.3


@pytest.mark.contract("4 UpdateThirdPartyCamera")
def test_update_third_party_camera(thor):
    """Only what is given changes."""
    position = {**thor.agent["position"], "y": 1.6}
    thor.ok("AddThirdPartyCamera", position=position, rotation={"x": 10.0, "y": 20.0, "z": 0.0}, fieldOfView=70)
    before = image(thor).third_party_camera_frames[0].copy()
    thor.ok("UpdateThirdPartyCamera", thirdPartyCameraId=0, rotation={"y": 200.0})
    (camera,) = thor.metadata["thirdPartyCameras"]
    assert np.allclose(xyz(camera["position"]), xyz(position), atol=1e-3) and camera["fieldOfView"] == pytest.approx(70)
    assert camera["rotation"]["y"] == pytest.approx(200, abs=0.01) and camera["rotation"]["x"] == pytest.approx(10, abs=0.01)
    assert not np.array_equal(image(thor).third_party_camera_frames[0], before)
    thor.ok("UpdateThirdPartyCamera", thirdPartyCameraId=0, position={"y": 1.2})
    (camera,) = thor.metadata["thirdPartyCameras"]
    assert np.allclose(xyz(camera["position"]), [position["x"], 1.2, position["z"]], atol=1e-3)
    thor.ok("UpdateThirdPartyCamera", fieldOfView=100)
    assert thor.metadata["thirdPartyCameras"][0]["fieldOfView"] == pytest.approx(100)


@pytest.mark.contract("4 UpdateThirdPartyCamera")
@pytest.mark.scenes(1)
def test_update_third_party_camera_refusals(thor):
    thor.ok("AddThirdPartyCamera", position=thor.agent["position"], rotation=FLAT)
    before = thor.metadata["thirdPartyCameras"]
    for number in (-1, 1, 99):
        assert thor.refused("UpdateThirdPartyCamera", thirdPartyCameraId=number, fieldOfView=50).metadata["errorMessage"]
    thor.refused("UpdateThirdPartyCamera", "fov", thirdPartyCameraId=0, fieldOfView=180)
    assert thor.metadata["thirdPartyCameras"] == before


# The map


@pytest.mark.contract("4 ToggleMapView")
@pytest.mark.scenes(3)
def test_map_view(thor):
    """The map view shows the whole room from above; a second call restores the agent's view."""
    before = thor.look()
    eye = dict(before.metadata["cameraPosition"])
    thor.ok("ToggleMapView")
    assert thor.metadata["cameraOrthSize"] > 0
    event = image(thor)
    assert event.metadata["cameraOrthSize"] > 0 and not np.array_equal(event.frame, before.frame)
    floors = [i for i in event.instance_masks if i.startswith("Floor")]
    assert floors and sum(event.instance_masks[i].sum() for i in floors) > 0.03 * 150 * 200
    assert len(list(event.instance_masks)) >= 5
    thor.ok("ToggleMapView")
    assert thor.metadata["cameraOrthSize"] == -1
    after = image(thor)
    assert np.array_equal(after.frame, before.frame) and after.metadata["cameraPosition"] == eye


@pytest.mark.contract("4 GetMapViewCameraProperties")
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


# Spawning


@pytest.mark.contract("4 GetSpawnCoordinatesAboveReceptacle")
@pytest.mark.scenes(4)
def test_spawn_coordinates(thor):
    """Points are over the receptacle, above its lower edge; the visible ones are among them."""
    found = 0
    for record in thor.metadata["objects"]:
        if not record["receptacle"] or record["objectType"] in ("Floor",) or record["openable"]:
            continue
        points = (
            thor.ok("GetSpawnCoordinatesAboveReceptacle", objectId=record["objectId"], anywhere=True).metadata["actionReturn"]
            or []
        )
        box = record["axisAlignedBoundingBox"]
        for p in points:
            assert abs(p["x"] - box["center"]["x"]) <= box["size"]["x"] / 2 + 0.1
            assert abs(p["z"] - box["center"]["z"]) <= box["size"]["z"] / 2 + 0.1
            assert p["y"] >= box["center"]["y"] - box["size"]["y"] / 2 - 0.01
        event = thor.step("GetSpawnCoordinatesAboveReceptacle", objectId=record["objectId"], anywhere=False)
        assert len(event.metadata["actionReturn"] or []) <= len(points)
        found += bool(points)
    assert found


@pytest.mark.contract("4 GetSpawnCoordinatesAboveReceptacle")
def test_spawn_coordinates_of_nothing(thor):
    thor.refused("GetSpawnCoordinatesAboveReceptacle", objectId=NOTHING, anywhere=True)


@pytest.mark.contract("4 InitialRandomSpawn")
@pytest.mark.scenes(3)
def test_initial_random_spawn(thor):
    """The same seed gives the same scene, another seed another one; only pickupable objects move; none is lost; a reset restores
    the scene."""
    before = {o["name"]: o for o in thor.metadata["objects"]}

    def spawned(seed):
        thor.reset()
        thor.ok("InitialRandomSpawn", randomSeed=seed, forceVisible=False, numPlacementAttempts=5, placeStationary=True)
        return {o["name"]: tuple(round(v, 4) for v in xyz(o["position"])) for o in thor.metadata["objects"]}

    one, again, other = spawned(1), spawned(1), spawned(2)
    assert one == again != other and set(one) == set(before)
    moved = [n for n in one if np.linalg.norm(np.array(one[n]) - xyz(before[n]["position"])) > 0.05]
    assert moved and all(before[n]["pickupable"] or before[n]["parentReceptacles"] for n in moved)
    thor.reset()
    assert {o["name"]: o["position"] for o in thor.metadata["objects"]} == {n: o["position"] for n, o in before.items()}


@pytest.mark.contract("4 InitialRandomSpawn")
def test_initial_random_spawn_leaves_out_what_it_is_told_to(thor):
    before = {o["name"]: o for o in thor.metadata["objects"]}
    kept = thor.pickupable(3)
    thor.ok("InitialRandomSpawn", randomSeed=3, excludedObjectIds=[o["objectId"] for o in kept])
    for record in kept:
        now = next(o for o in thor.metadata["objects"] if o["name"] == record["name"])
        assert np.allclose(xyz(now["position"]), xyz(before[record["name"]]["position"]), atol=0.02)


@pytest.mark.contract("4 InitialRandomSpawn")
def test_initial_random_spawn_makes_duplicates(thor):
    """Duplicates are made of types with a receptacle; ids stay unique."""
    kinds = {o["objectType"] for o in thor.pickupable(6)}

    def counts():
        return {kind: sum(o["objectType"] == kind for o in thor.metadata["objects"]) for kind in kinds}

    before = counts()
    wishes = [{"objectType": kind, "count": count + 2} for kind, count in sorted(before.items())]
    thor.ok("InitialRandomSpawn", randomSeed=5, numDuplicatesOfType=wishes, numPlacementAttempts=20)
    after = counts()
    assert all(before[kind] <= after[kind] for kind in kinds) and sum(after.values()) > sum(before.values())
    assert len({o["objectId"] for o in thor.metadata["objects"]}) == len(thor.metadata["objects"])


# Materials


@pytest.mark.contract("4 RandomizeMaterials", "4 ResetMaterials")
@pytest.mark.scenes(3)
def test_randomize_materials(thor):
    """Colours change, depth and ids do not. ResetMaterials and Reset restore them."""
    thor.go(thor.free_cell(), 90, 30)
    before = thor.look()
    value = thor.ok("RandomizeMaterials").metadata["actionReturn"]
    assert {
        "chosenRoomTypes",
        "useTrainMaterials",
        "useValMaterials",
        "useTestMaterials",
        "useExternalMaterials",
        "totalMaterialsConsidered",
    } <= set(value)
    assert value["totalMaterialsConsidered"] > 0
    painted = thor.look()
    assert np.abs(painted.frame.astype(int) - before.frame).mean() > 2
    assert np.array_equal(painted.depth_frame, before.depth_frame)
    assert np.array_equal(painted.instance_segmentation_frame, before.instance_segmentation_frame)
    thor.ok("ResetMaterials")
    assert np.array_equal(thor.look().frame, before.frame)
    thor.ok("RandomizeMaterials")
    pose = thor.pose
    thor.reset()
    thor.go(dict(zip("xyz", pose[:3], strict=True)), pose[3], pose[4])
    assert np.array_equal(thor.look().frame, before.frame)


@pytest.mark.contract("4 RandomizeMaterials")
@pytest.mark.scenes(3)
def test_randomize_materials_of_another_kind_of_room(thor):
    number = int(thor.scene.removeprefix("FloorPlan"))
    own = "kitchen" if number < 100 else {2: "livingroom", 3: "bedroom", 4: "bathroom"}[number // 100]
    foreign = "bathroom" if own != "bathroom" else "kitchen"
    assert thor.refused("RandomizeMaterials", inRoomTypes=[foreign]).metadata["errorMessage"]
    thor.ok("RandomizeMaterials", inRoomTypes=[own])


# Lighting


@pytest.mark.contract("4 RandomizeLighting", "4 ResetLighting")
@pytest.mark.scenes(3)
def test_randomize_lighting(thor):
    """Colours change, depth and ids do not. Equal ends leave nothing to chance. ResetLighting and Reset restore the lights."""
    thor.go(thor.free_cell(), 90, 30)
    before = thor.look()
    dim = {"synchronized": True, "randomizeColor": True, "brightness": [0.5, 0.5], "hue": [0.1, 0.1], "saturation": [0.2, 0.2]}
    thor.ok("RandomizeLighting", **dim)
    lit = thor.look()
    assert lit.frame.mean() < before.frame.mean() - 2
    assert np.array_equal(lit.depth_frame, before.depth_frame)
    assert np.array_equal(lit.instance_segmentation_frame, before.instance_segmentation_frame)
    thor.ok("RandomizeLighting", **dim)
    assert np.array_equal(thor.look().frame, lit.frame)
    thor.ok("ResetLighting")
    assert np.array_equal(thor.look().frame, before.frame)
    thor.ok("RandomizeLighting")
    assert not np.array_equal(thor.look().frame, before.frame)
    pose = thor.pose
    thor.reset()
    thor.go(dict(zip("xyz", pose[:3], strict=True)), pose[3], pose[4])
    assert np.array_equal(thor.look().frame, before.frame)


@pytest.mark.contract("4 RandomizeLighting")
@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"randomizeColor": False, "hue": [0, 1]}, "randomizeColor=False"),
        ({"randomizeColor": False, "saturation": [0, 1]}, "randomizeColor=False"),
        ({"brightness": [-0.5, 1]}, "brightness must be >= 0"),
        ({"hue": [0, 1.5]}, "hue range must be in [0:1]"),
        ({"saturation": [-1, 1]}, "saturation range must be in [0:1]"),
        ({"hue": [0, 0.5, 1]}, "must each have 2 values"),
    ],
)
def test_randomize_lighting_refusals(thor, arguments, complaint):
    before = thor.look().frame
    assert complaint in thor.refused("RandomizeLighting", **arguments).metadata["errorMessage"]
    assert np.array_equal(thor.look().frame, before)


# Filters and the rest


@pytest.mark.contract("4 SetObjectFilter", "4 ResetObjectFilter")
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


@pytest.mark.contract("4 SetObjectFilter")
def test_reset_takes_the_filter_off(thor):
    thor.ok("SetObjectFilter", objectIds=[])
    thor.reset()
    assert thor.objects


@pytest.mark.contract("4 GetScenesInBuild")
@pytest.mark.scenes(1)
def test_scenes_in_build(thor):
    names = thor.ok("GetScenesInBuild").metadata["actionReturn"]
    assert {f"{s}_physics" for s in thor.controller.ithor_scenes(include_kitchens=True) if not s.endswith("_physics")} | {
        s for s in thor.controller.ithor_scenes() if s.endswith("_physics")
    } <= set(names)


@pytest.mark.contract("4 ChangeResolution")
@pytest.mark.scenes(1)
def test_change_resolution(thor):
    event = thor.controller.step("ChangeResolution", x=90, y=120)
    assert event and event.frame.shape == (120, 90, 3) and event.depth_frame.shape == (120, 90)
    assert (event.metadata["screenWidth"], event.metadata["screenHeight"]) == (90, 120)


@pytest.mark.contract("4 ChangeQuality", "4 SetRandomSeed")
@pytest.mark.scenes(1)
def test_quality_and_seed(thor):
    thor.ok("ChangeQuality", quality="Very Low")
    thor.ok("SetRandomSeed", seed=42)


@pytest.mark.contract("1.7", "4 CreateHouse")
@pytest.mark.scenes(1)
def test_house_as_a_scene(thor):
    """The client sends Reset, Initialize and CreateHouse for a scene that is a dict; afterwards a scene by name works."""
    plan = house()
    thor.controller.initialization_parameters = {**BASE, "snapToGrid": False, "renderImage": False}
    event = thor.controller.reset(plan)
    assert event, event.metadata["errorMessage"]
    assert event.metadata["sceneName"] == "Procedural" and event.metadata["lastAction"] == "CreateHouse"
    assert {o["id"] for o in plan["objects"]} <= set(thor.objects)
    assert len(thor.reachable()) > 20 and thor.look().frame.std() > 3
    thor.reset()
    assert thor.metadata["sceneName"] == f"{thor.scene}_physics" and not {o["id"] for o in plan["objects"]} & set(thor.objects)


@pytest.mark.contract("4 CreateHouse")
@pytest.mark.scenes(1)
def test_create_house_refuses_what_is_no_house(thor):
    try:
        event = thor.step("CreateHouse", house={})
    except ValueError:
        event = thor.controller.last_event
    assert not event and event.metadata["errorMessage"]
    thor.reset()
    thor.ok("Pass")


@pytest.mark.contract("1.7", "4 Reset")
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

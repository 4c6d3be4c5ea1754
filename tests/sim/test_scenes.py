"""A scene is a floor plan, a home that its name draws again, or a house in a file, and is refused if it is another one."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest

from ovman.generation.scenes import AREA_M2, survey
from ovman.homes.generate import digest_house, draw, generate
from ovman.records.scene import Scene
from ovman.sim.scenes import HOUSES, SceneError, load_scene, name_house
from ovman.sim.session import Session
from tests.arms import CONFIG

HOME = draw("3", 2, "val")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The folder of houses, empty."""
    monkeypatch.chdir(tmp_path)
    HOUSES.mkdir()
    load_scene.cache_clear()
    yield HOUSES
    load_scene.cache_clear()


def write(path, house):
    load_scene.cache_clear()
    path.write_text(json.dumps(house))


def ids(things):
    """The ids of objects of a house and of what they hold."""
    return {i for thing in things for i in (thing["id"], *ids(thing.get("children", ())))}


def test_the_name_of_a_home_draws_it_again():
    assert load_scene(HOME.name) == HOME.house
    assert load_scene("FloorPlan1") == "FloorPlan1"


def test_a_session_goes_from_a_floor_plan_to_a_home_and_back():
    with Session("FloorPlan429", CONFIG) as session:
        session.reset()
        before = session.objects
        session.scene = HOME.name
        session.reset()
        assert ids(HOME.house["objects"]) <= {*session.objects}
        session.scene = "FloorPlan429"
        session.reset()
        assert session.objects == before


def test_tours_of_a_home_grow_with_its_floor_and_come_to_each_room():
    with Session(HOME.name, CONFIG) as session:
        scene = survey(session, 2, CONFIG.primitives.step_m)
    area_m2 = len(scene.reachable) * CONFIG.primitives.step_m**2
    for waypoints in (scene.waypoints, scene.other_waypoints):
        assert len(waypoints) >= area_m2 / AREA_M2 > len(waypoints) - 1
        assert {*scene.find_rooms(np.array(waypoints)).tolist()} == {0, 1}
    assert scene.floor_y == 0.0
    assert Scene.parse(scene.to_line()) == scene


def test_a_house_in_a_file_is_loaded_while_it_is_the_house_that_was_named(folder):
    write(folder / "mine.json", HOME.house)
    name = name_house("House-mine")
    assert name == f"House-mine-{digest_house(HOME.house)}" == name_house(name)
    with Session(name, CONFIG) as session:
        session.reset()
        assert ids(HOME.house["objects"]) <= {*session.objects}
    other = copy.deepcopy(HOME.house)
    del other["objects"][0]
    write(folder / "mine.json", other)
    with (
        pytest.raises(SceneError, match=rf"{name}: .* {digest_house(other)}; restore houses/mine.json"),
        Session(name, CONFIG) as one,
    ):
        one.reset()


def test_a_home_of_another_generator_is_refused():
    another = generate("3", 2, "train")
    name = f"Home-val-2-3-{digest_house(another)}"
    with pytest.raises(SceneError, match=f"{name}: .* draw the split again"):
        load_scene(name)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "houses/mine.json: No such file"),
        ("{", "houses/mine.json: Expecting property name"),
        ("[]", "houses/mine.json: house is a JSON object"),
        (lambda house: house["objects"][3].update(assetId="Throne_1"), r"houses/mine.json: house.objects\[3\].assetId"),
        (lambda house: house["rooms"][1].pop("floorPolygon"), r"houses/mine.json: house.rooms\[1\] has no 'floorPolygon'"),
        (lambda house: house["objects"][0]["position"].update(x=1e9), r"houses/mine.json: house.objects\[0\].position.x"),
    ],
)
def test_a_house_that_cannot_be_loaded_is_refused_with_file_place_and_remedy(text, says, folder):
    if callable(text):
        house = copy.deepcopy(HOME.house)
        text(house)
        text = json.dumps(house)
    if text is not None:
        (folder / "mine.json").write_text(text)
    with pytest.raises(SceneError, match=f"{says}.*; .*House-mine out of the split$"):
        name_house("House-mine")

from __future__ import annotations

import pytest

from ovman.language import is_plural_category, noun
from ovman_engine.plan import floorplan


@pytest.fixture(scope="module")
def categories() -> list[str]:
    return sorted({instance.type for name in floorplan.names() for instance in floorplan.load(name).objects})


def test_every_category_of_the_floor_plans_has_a_noun_of_its_own(categories):
    assert len(categories) == 118
    nouns = [noun(category) for category in categories]
    assert len(set(nouns)) == len(nouns)
    for spoken in nouns:
        assert spoken == " ".join(spoken.split())
        assert all(word.islower() or word in {"CD", "TV"} for word in spoken.split())


@pytest.mark.parametrize("category, spoken", [
    ("Chair", "chair"), ("ArmChair", "armchair"), ("HousePlant", "house plant"), ("TVStand", "TV stand"), ("CD", "CD"),
    ("BasketBall", "basketball"), ("BaseballBat", "baseball bat"), ("ToiletPaperHanger", "toilet paper hanger"),
    ("CellPhone", "cell phone"), ("Footstool", "footstool"), ("RobotArm2", "robot arm 2"), ("USBDrive", "USB drive"),
])  # fmt: skip
def test_nouns_are_what_people_say(category, spoken):
    assert noun(category) == spoken


@pytest.mark.parametrize("name", ["", "|", " "])
def test_a_name_without_letters_is_refused(name):
    with pytest.raises(ValueError, match="not the name of a category"):
        noun(name)


def test_plural_nouns_are_those_of_the_floor_plans(categories):
    assert {category for category in categories if is_plural_category(noun(category))} == {"Blinds", "Boots", "Curtains"}

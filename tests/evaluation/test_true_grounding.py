"""Oracle grounding: which objects of a map truly are of a category, by places and by what their detections show."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.evaluation.context import EpisodeContext
from ovman.evaluation.true_grounding import (
    commonest,
    grounding_by_labels,
    grounding_by_places,
    grounding_by_truth,
    recorded_positions,
)
from ovman.perception.labels import NOTHING, Labels
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.records.visit import Sighting, Sightings
from ovman.settings import Reading
from tests.arms import CONFIG
from tests.episodes import EPISODES, SIGHTINGS

coordinate = st.floats(-5, 5)
places = st.lists(st.tuples(coordinate, coordinate), max_size=10, unique=True)


@given(places, places, st.floats(0.1, 3))
def test_truth_names_the_nearest_object_of_each_recorded_position(recorded, p, radius_m):
    found = grounding_by_truth(recorded, p, radius_m)
    expected = set()
    for x, z in recorded:
        gaps = [(np.hypot(x - a, z - b), a, b, i) for i, (a, b) in enumerate(p)]
        if gaps and min(gaps)[0] <= radius_m:
            expected.add(min(gaps)[3])
    assert found == tuple(sorted(expected))


@given(places, places, st.floats(0.1, 3))
def test_places_name_every_object_near_a_recorded_position(recorded, p, radius_m):
    near = [i for i, (a, b) in enumerate(p) if any(np.hypot(x - a, z - b) <= radius_m for x, z in recorded)]
    assert grounding_by_places(recorded, p, radius_m) == tuple(near)
    assert {*grounding_by_truth(recorded, p, radius_m)} <= {*near}


def test_an_arm_of_the_places_reading_is_handed_the_places_of_both_visits():
    """A map of the second visit alone is handed the vacated place, too, which no other reading does."""
    arms = CONFIG.arms
    of = [arm for arm in arms.values() if arm.reading is Reading.PLACES]
    assert len(of) == 5 and all(arm.reads_sightings and not arm.reads_labels for arm in of)
    sightings = {one.episode: one for one in Sightings.read(SIGHTINGS)}
    vacated = [one for one in Episode.load(EPISODES) if one.relation is Relation.FORMER]
    handed = dict.fromkeys(("places", "nearest"), 0)
    for episode in vacated:
        objects = SimpleNamespace(p=np.array([episode.answer, (99.0, 99.0)]))
        for reading in handed:
            context = EpisodeContext(
                np.random.default_rng(0), 0, CONFIG, episode, arms[f"grounding_two_visits_{reading}"], None, sightings[episode.id]
            )
            handed[reading] += context.true_objects(objects, "second") == (0,)
    assert handed["places"] == len(vacated) > 2 * handed["nearest"]


def test_only_masks_that_count_are_recorded():
    sightings = [Sighting(view=v, instance="k", px=px, x=float(v), z=0.0) for v, px in enumerate((299, 300, 5000))]
    assert recorded_positions(sightings, 300).tolist() == [[1.0, 0.0], [2.0, 0.0]]
    assert grounding_by_truth(recorded_positions([], 300), [(0.0, 0.0)], 1.0) == ()


CATEGORIES = ("Chair", "Lamp", "Sofa")
labels = st.lists(st.tuples(st.integers(NOTHING, 2), st.integers(1, 9)), max_size=12).map(
    lambda rows: Labels(CATEGORIES, np.array([k for k, _ in rows], int), np.array([size for _, size in rows], int))
)


@given(labels, labels, st.integers(1, 4), st.sampled_from(CATEGORIES), st.randoms(use_true_random=False))
def test_an_object_is_of_one_category_by_majority_and_of_all_that_it_shows_by_any(first, second, objects, category, random):
    owner = [random.randrange(objects) for _ in range(len(first) + len(second))]
    members = [np.array([k for k, own in enumerate(owner) if own == i], int) for i in range(objects)]

    def meant(reading: Reading, name: str = category) -> set[int]:
        return {*grounding_by_labels(name, members, [first, second], reading)}

    assert meant(Reading.MAJORITY) <= meant(Reading.ANY)
    shown = [*first.category.tolist(), *second.category.tolist()]
    assert meant(Reading.ANY) == {own for own, k in zip(owner, shown, strict=True) if k == CATEGORIES.index(category)}
    every = [i for name in CATEGORIES for i in meant(Reading.MAJORITY, name)]
    assert len(every) == len({*every}), "one category an object"
    assert {*every} == {i for name in CATEGORIES for i in meant(Reading.ANY, name)}, "and one wherever it shows something"


def test_the_commonest_category_is_by_detections_then_by_area_and_masks_of_nothing_do_not_count():
    names = np.array(["Lamp", "Chair", "Chair", "", "", ""])
    assert commonest(names, np.array([900, 10, 10, 5, 5, 5])) == "Chair"
    assert commonest(names[:2], np.array([900, 10])) == "Lamp" and commonest(names[:2], np.array([10, 900])) == "Chair"
    assert commonest(names[:2], np.array([10, 10])) == "Chair"
    assert commonest(names[3:], np.array([5, 5, 5])) is None and commonest(names[:0], np.array([])) is None


def test_numbers_go_on_in_the_second_tour_and_one_that_no_detection_has_is_refused():
    first, second = (Labels(CATEGORIES, np.array([k]), np.array([1])) for k in (0, 1))
    assert grounding_by_labels("Lamp", [np.array([0]), np.array([1])], [first, second], Reading.MAJORITY) == (1,)
    with pytest.raises(ValueError, match="beyond the 1 of its tours"):
        grounding_by_labels("Lamp", [np.array([1])], [first], Reading.MAJORITY)
    with pytest.raises(ValueError, match="nearest is by true positions"):
        grounding_by_labels("Lamp", [], [first], Reading.NEAREST)

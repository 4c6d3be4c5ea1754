"""What a noun means in a map: by its features, and for the diagnostic arms by the truth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.reference.reasoning import ground, similarities
from ovman.evaluation.true_grounding import commonest, grounding_by_labels, grounding_by_truth, recorded_positions
from ovman.perception.labels import NOTHING, Labels
from ovman.records.visit import Sighting
from ovman.settings import Reading

BAND = 0.03
vectors = st.lists(st.floats(-1, 1), min_size=4, max_size=4).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)
units = vectors.map(lambda v: v / np.linalg.norm(v))
maps = st.lists(units, min_size=1, max_size=12).map(np.stack)
coordinate = st.floats(-5, 5)
places = st.lists(st.tuples(coordinate, coordinate), max_size=10, unique=True)


@given(maps, units, st.floats(0, 2), st.floats(0, 2))
def test_a_wider_band_holds_what_a_narrower_one_holds(features, noun, one, other):
    narrow, wide = sorted((one, other))
    assert set(ground(features, noun, 0)) <= set(ground(features, noun, narrow)) <= set(ground(features, noun, wide))


@given(maps, units)
def test_no_band_leaves_the_best_and_a_large_one_everything(features, noun):
    s = [float(np.dot(f, noun)) for f in features]
    best = ground(features, noun, 0)
    assert best and all(s[i] == pytest.approx(max(s)) for i in best)
    assert ground(features, noun, 2.001) == tuple(range(len(features)))


@given(maps, units, st.randoms(use_true_random=False))
def test_the_order_of_the_map_is_of_no_consequence(features, noun, random):
    order = list(range(len(features)))
    random.shuffle(order)
    assert sorted(order[i] for i in ground(features[order], noun, BAND)) == list(ground(features, noun, BAND))


def test_the_band_reaches_from_the_best_down():
    angles = np.arccos([0.9, 0.871, 0.869, -0.5])
    features = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert ground(features, (1.0, 0.0), BAND) == (0, 1)


def test_an_empty_map_means_nothing():
    assert ground(np.zeros((0, 4)), np.ones(4) / 2, BAND) == () == ground(np.zeros((0, 0)), np.ones(4) / 2, BAND)


@pytest.mark.parametrize(
    ("features", "noun", "similarity_margin", "message"),
    [
        (np.eye(3), np.ones(2), BAND, "of one encoder"),
        (np.ones(3), np.ones(3), BAND, "of one encoder"),
        (np.eye(2) * np.nan, np.ones(2), BAND, "not finite"),
        (np.eye(2), np.ones(2), -0.1, "similarity_margin"),
        (np.eye(2), np.ones(2), float("nan"), "similarity_margin"),
    ],
)
def test_wrong_input_is_named(features, noun, similarity_margin, message):
    with pytest.raises(ValueError, match=message):
        ground(features, noun, similarity_margin)


def test_similarity_does_not_depend_on_the_neighbours():
    features = np.random.default_rng(0).normal(size=(37, 129))
    noun = np.random.default_rng(1).normal(size=129)
    alone = [similarities(features[[i]], noun)[0] for i in range(len(features))]
    assert similarities(features, noun).tolist() == alone


@given(places, places, st.floats(0.1, 3))
def test_truth_names_the_nearest_object_of_each_recorded_position(recorded, p, radius_m):
    found = grounding_by_truth(recorded, p, radius_m)
    expected = set()
    for x, z in recorded:
        gaps = [(np.hypot(x - a, z - b), a, b, i) for i, (a, b) in enumerate(p)]
        if gaps and min(gaps)[0] <= radius_m:
            expected.add(min(gaps)[3])
    assert found == tuple(sorted(expected))


def test_a_moving_instance_is_every_object_along_its_track():
    track = [(0.0, 0.0), (1.5, 0.0), (3.0, 0.0)]
    p = [(3.1, 0.0), (0.1, 0.1), (1.5, 0.4), (9.0, 9.0)]
    assert grounding_by_truth(track, p, 1.0) == (0, 1, 2)


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

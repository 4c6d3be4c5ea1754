"""Weights of the cues against what they are fitted to, and the variants of the agent against the agent as it is."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from statistics import median

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.agents.reference.reasoning import answer_two_visits
from ovman.analysis.appearance import VARIANTS, compare_cues, find_pairs, pose_question
from ovman.analysis.cues import (
    CLIP,
    CUES,
    EXTENT,
    HISTOGRAM,
    Cues,
    MapObjects,
    Pairs,
    Weights,
    colour_histograms,
    disagreements,
    fit_weights,
    separation,
    share_grid,
)
from ovman.analysis.outcomes import ALL
from ovman.perception.clusters import Detection, clusters
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Evidence
from tests.analysis.fabricated import named
from tests.arms import CONFIG
from tests.episodes import episode_record

CONSTANTS = CONFIG.model_copy(update={"appearance": CONFIG.appearance.model_copy(update={"least_pairs": 1, "weight_step": 0.25})})
SOME = settings(max_examples=8, derandomize=True, deadline=None)


def made_of(splits, constants):
    return named(compare_cues(splits, constants))


def pairs(seed: int, count: int = 30, **told: float) -> Pairs:
    """Random pairs; a cue that is told by name is shifted by so much where the instances differ."""
    rng = np.random.default_rng(seed)
    same = rng.random(count) < 0.5
    same[:2] = True, False
    return Pairs({cue: rng.random(count) + told.get(cue, 0.0) * ~same for cue in CUES}, same)


@SOME
@given(st.integers(0, 2**32 - 1), st.sampled_from(VARIANTS))
def test_fitted_weights_are_shares_and_no_point_of_the_grid_tells_more(seed, cues):
    some = pairs(seed)
    weights = fit_weights(some, cues, 0.25, 1)
    assert list(weights.by_cue) == list(cues) and sum(weights.by_cue.values()) == pytest.approx(1.0)
    best = separation(some, weights)
    for shares in share_grid(len(cues), 0.25):
        assert separation(some, replace(weights, by_cue=dict(zip(cues, shares, strict=True)))) <= best
    assert best >= separation(some, Weights.on(CLIP))


def test_a_cue_is_taken_as_it_is_where_nothing_is_fitted_or_scaled():
    some = pairs(0, 200, histogram=5.0)
    as_it_is, least = dict.fromkeys(CUES, 1.0), min(some.counts)
    assert fit_weights(some, CUES, 0.25, least + 1) == Weights({cue: float(cue == CLIP) for cue in CUES}, as_it_is)
    assert fit_weights(some, CUES, 0.25, least).by_cue[HISTOGRAM] > 0.0
    assert fit_weights(some, CUES, 0.25, least, equal_scales=False).scale == as_it_is


def test_scales_make_the_cues_equally_large():
    some = pairs(3)
    some = replace(some, unlike={**some.unlike, EXTENT: some.unlike[EXTENT] * 70})
    weights = fit_weights(some, CUES, 0.25, 1)
    sizes = [weights.scale[cue] * some.unlike[cue].mean() for cue in CUES]
    assert sizes == pytest.approx([some.unlike[CLIP].mean()] * 3)


def chairs(places, colour, side, instances) -> MapObjects:
    """Chairs at (x, z), each detected once, of a colour and a size."""
    histogram = np.eye(4, dtype=np.float32)[colour]
    extent = np.array([[length, length, 1.0] for length in side], np.float32).reshape(-1, 3)
    cues = Cues(histogram.reshape(-1, 4), extent, np.full(len(places), 400), np.array(instances))
    found = [Detection(0, np.array([x, 0.5, z]), np.array([1.0, 0.0])) for x, z in places]
    return MapObjects.of(clusters(found, 0.1), cues)


FIRST = chairs([(0, 0), (1, 0)], [0, 1], [0.4, 0.4], ["a", "b"])
SECOND = chairs([(0.6, 0), (1, 0.1)], [1, 0], [0.4, 0.4], ["b", "a"])
"""Two chairs of one look to the encoder, of two colours, that change places: distance alone pairs them wrongly."""
MEANT = Evidence((0, 1), (0, 1))


def case(relation="moved", number=0, answer=(0.6, 0.0), scene="FloorPlan1"):
    record = episode_record(relation, number, answer=answer, visits={"first": "v", "second": "w"}, scene=scene)
    objects = {(scene, "v"): FIRST, (scene, "w"): SECOND}
    return pose_question(Episode.parse(json.dumps(record), "here"), MEANT, objects, CONSTANTS)


def test_cues_of_one_object_agree_and_are_symmetric():
    for one, other in ((FIRST, SECOND), (SECOND, FIRST)):
        here, there = disagreements(one, other, 0.01), disagreements(other, one, 0.01)
        assert all((here[cue] >= 0).all() and np.allclose(here[cue], there[cue].T) for cue in CUES)
    same = disagreements(FIRST, FIRST, 0.01)
    assert all(np.allclose(np.diag(same[cue]), 0.0) for cue in CUES) and same[HISTOGRAM][0, 1] == pytest.approx(1.0)
    thin = chairs([(0, 0)], [0], [0.0], ["a"])
    assert disagreements(FIRST, thin, 0.04)[EXTENT][0, 0] == pytest.approx(2 * math.log(10) / 3)


def test_a_pair_counts_once_and_those_that_are_near_do_not_count_as_apart():
    twice = [case(), case("former", 1, (0.0, 0.0))]
    found = find_pairs(twice, 0.0)
    assert found.counts == (2, 2) and find_pairs(twice, 0.75).counts == (1, 0)
    assert find_pairs([case(), case(scene="FloorPlan2")], 0.0).counts == (4, 4)


def test_clip_alone_is_the_agent_as_it_is_and_colours_set_right_what_it_confuses():
    made = made_of({"main": [case("moved", 0), case("stable", 1, (1.0, 0.1))], "multi": [case("moved", 2)]}, CONSTANTS)
    whole = {(row.pairs, row.cues, row.fitted_on, row.split): row for row in made if row.relation == ALL}
    assert len(whole) == len([row for row in made if row.relation == ALL])
    first = whole[ALL, "clip", None, "main"]
    answer, _ = answer_two_visits(case().episode.relation, FIRST.map, SECOND.map, (0, 1), (0, 1), CONSTANTS)
    assert answer == Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU) and first.successes < first.n
    assert (first.wins, first.losses, first.p, first.auroc) == (0, 0, 1.0, 0.5)
    coloured = whole[ALL, "clip + histogram", "main", "multi"]
    assert coloured.auroc == 1.0 and coloured.histogram > 0 and (coloured.successes, coloured.wins, coloured.losses) == (1, 1, 0)
    assert whole[ALL, "extent", None, "main"].n is None
    assert [row.relation for row in made if row.n is not None][:3] == [ALL, "moved", "stable"]


def test_an_arm_without_two_maps_is_refused():
    for meant in (None, Evidence(None, (0,))):
        with pytest.raises(ValueError, match="names no objects of two maps for FloorPlan1/moved/0000"):
            pose_question(case().episode, meant, {}, CONSTANTS)


def test_an_object_has_the_mean_the_median_and_the_commonest_instance_of_its_detections():
    rng, of = np.random.default_rng(0), ((0, 1, 3), (2, 4))
    histogram, extent = rng.random((5, 4), np.float32), rng.random((5, 3), np.float32)
    instance = np.array(["b", "", "", "", ""])  # most detections of the first object show nothing, those of the second all do
    cues = Cues(histogram, extent, np.full(5, 400), instance)
    places = [(0.0, 0.0), (0.0, 0.0), (5.0, 0.0), (0.0, 0.0), (5.0, 0.0)]
    found = clusters([Detection(k, np.array([x, 0.5, z]), np.ones(2)) for k, (x, z) in enumerate(places)], 0.1)
    made = MapObjects.of(found, cues)
    assert [tuple(one.members) for one in found] == list(of) and made.instance == ("b", None)
    assert made.histogram.shape == (2, 4) and made.extent.shape == (2, 3)
    for number, rows_of_it in enumerate(of):
        for b in range(4):
            exact = sum(Fraction(float(histogram[k, b])) for k in rows_of_it) / len(rows_of_it)
            assert made.histogram[number, b] == pytest.approx(float(exact), rel=1e-14)
        for side in range(3):
            assert made.extent[number, side] == median(float(extent[k, side]) for k in rows_of_it)


def test_a_map_without_objects_disagrees_with_nothing():
    empty = MapObjects.of((), Cues(np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, str)))
    assert empty.histogram.shape == (0, 4) and empty.extent.shape == (0, 3) and empty.instance == ()
    for first, second in ((empty, SECOND), (FIRST, empty), (empty, empty)):
        found = disagreements(first, second, 0.01)
        assert {cue: found[cue].shape for cue in found} == dict.fromkeys(CUES, (len(first.map), len(second.map)))


RED, GREY, BLUE = (255, 0, 0), (120, 120, 120), (0, 0, 255)


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.integers(1, 30))
def test_a_histogram_is_of_the_masks_pixels_alone_wherever_they_are(seed, hue_bins, saturation_bins):
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (6, 5, 3), dtype=np.uint8)
    masks = rng.random((3, 6, 5)) < 0.4
    found = colour_histograms(rgb, masks, hue_bins, saturation_bins)
    assert found.shape == (3, hue_bins * saturation_bins)
    assert found.sum(axis=1) == pytest.approx(masks.any(axis=(1, 2)).astype(float), abs=1e-5)
    other = np.where(masks[0, ..., None], rgb, rng.integers(0, 256, rgb.shape, dtype=np.uint8))
    assert np.array_equal(colour_histograms(other, masks[:1], hue_bins, saturation_bins), found[:1])
    order = rng.permutation(6)
    assert np.array_equal(colour_histograms(rgb[order], masks[:, order], hue_bins, saturation_bins), found)


def test_hue_and_saturation_and_no_brightness():
    rgb = np.array([[RED, GREY, BLUE, (60, 0, 0)]], np.uint8)
    red, grey, blue, dark = colour_histograms(rgb, np.eye(4, dtype=bool)[:, None], 16, 8)
    assert np.array_equal(red, dark) and red.argmax() % 8 == 7 and grey.argmax() == 0
    assert not (red * blue).any() and not (red * grey).any()

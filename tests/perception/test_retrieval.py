from __future__ import annotations

import numpy as np
import pytest

from ovman.perception.retrieval import rank_categories

NOUNS = {"Sofa": ("sofa", "couch"), "Bed": ("bed", "bunk"), "Lamp": ("lamp",), "Vase": ("vase", "jar", "sofa")}
AXES = np.eye(4)
TEXT = dict(zip(("sofa", "bed", "lamp", "vase"), AXES, strict=True)) | {
    "couch": AXES[0],
    "bunk": AXES[2],
    "jar": (AXES[3] + AXES[1]) / np.sqrt(2),
}


def ranked(features, categories, present=tuple(NOUNS)):
    return rank_categories(np.array(features, float), categories, present, NOUNS, TEXT)


def test_crops_that_are_their_nouns_come_first():
    found = ranked(AXES, list(NOUNS))
    assert found.own.tolist() == [0, 0, 0, 0]
    assert found.top(1).tolist() == [1, 1, 1, 1]
    assert found.chance(1).tolist() == [0.25] * 4 and found.chance(5).tolist() == [1.0] * 4


def test_a_synonym_stands_in_the_place_of_the_own_noun():
    found = ranked(AXES, list(NOUNS))
    # "bunk" lies where "lamp" does, so a bed is as far from it as from everything else; "lamp" has no synonyms.
    assert [r.tolist() for r in found.synonyms[:3]] == [[0], [3], []]
    assert np.isnan(found.top_by_synonym(1)[2])
    assert found.top_by_synonym(1)[[0, 1]].tolist() == [1.0, 0.0]


def test_the_mean_over_synonyms():
    vase = (AXES[3] + 2 * AXES[1]) / np.sqrt(5)
    found = ranked([vase], ["Vase"])
    assert found.synonyms[0].tolist() == [0, 2]
    assert found.top_by_synonym(1)[0] == 0.5


def test_a_shared_noun_is_right_for_each():
    assert ranked([AXES[0]], ["Vase"]).synonyms[0][1] == 0
    assert ranked([AXES[0]], ["Sofa"]).own[0] == 0


def test_a_tie_is_no_success():
    assert ranked([np.zeros(4)], ["Bed"]).own[0] == 3


def test_only_what_is_present_competes():
    assert ranked([AXES[2]], ["Bed"]).own[0] == 3
    assert ranked([AXES[2]], ["Bed"], present=("Bed",)).own[0] == 0
    assert ranked([AXES[2]], ["Bed"], present=("Bed", "Lamp", "Lamp")).choices[0] == 2


def test_shuffled_features_give_chance():
    rng = np.random.default_rng(0)
    count = 25
    nouns = {f"C{i}": (f"noun {i}", f"word {i}") for i in range(count)}
    text = {phrase: v / np.linalg.norm(v) for both in nouns.values() for phrase in both for v in [rng.normal(size=16)]}
    categories = [f"C{i}" for i in rng.integers(count, size=5000)]
    right = np.stack([text[nouns[category][0]] for category in categories])
    assert rank_categories(right, categories, list(nouns), nouns, text).top(1).mean() == 1.0
    found = rank_categories(rng.permutation(right), categories, list(nouns), nouns, text)
    for k in (1, 5):
        # Four standard errors of a proportion.
        margin = 4 * np.sqrt(k / count * (1 - k / count) / len(categories))
        assert found.top(k).mean() == pytest.approx(found.chance(k).mean(), abs=margin)


def test_each_crop_is_ranked_by_itself():
    rng = np.random.default_rng(1)
    features = rng.normal(size=(40, 4))
    categories = rng.choice(list(NOUNS), size=40).tolist()
    order = rng.permutation(40)
    whole, other = ranked(features, categories), ranked(features[order], [categories[i] for i in order])
    assert other.own.tolist() == whole.own[order].tolist()
    assert [r.tolist() for r in other.synonyms] == [whole.synonyms[i].tolist() for i in order]


def test_no_crops():
    assert len(ranked(np.zeros((0, 4)), []).own) == 0


def test_what_is_not_present_cannot_be_right():
    with pytest.raises(ValueError, match="Lamp is not among the 1"):
        ranked([AXES[2]], ["Lamp"], present=("Bed",))

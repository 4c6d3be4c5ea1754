from __future__ import annotations

import numpy as np

from ovman.analysis.perception import rank_categories

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


def test_a_shared_noun_is_right_for_each():
    assert ranked([AXES[0]], ["Vase"]).synonyms[0][1] == 0
    assert ranked([AXES[0]], ["Sofa"]).own[0] == 0


def test_a_tie_is_no_success():
    assert ranked([np.zeros(4)], ["Bed"]).own[0] == 3


def test_only_what_is_present_competes():
    assert ranked([AXES[2]], ["Bed"]).own[0] == 3
    assert ranked([AXES[2]], ["Bed"], present=("Bed",)).own[0] == 0
    assert ranked([AXES[2]], ["Bed"], present=("Bed", "Lamp", "Lamp")).choices[0] == 2


def test_each_crop_is_ranked_by_itself():
    rng = np.random.default_rng(1)
    features = rng.normal(size=(40, 4))
    categories = rng.choice(list(NOUNS), size=40).tolist()
    order = rng.permutation(40)
    whole, other = ranked(features, categories), ranked(features[order], [categories[i] for i in order])
    assert other.own.tolist() == whole.own[order].tolist()
    assert [r.tolist() for r in other.synonyms] == [whole.synonyms[i].tolist() for i in order]

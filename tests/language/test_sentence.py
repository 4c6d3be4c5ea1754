from __future__ import annotations

from itertools import product

import pytest

from ovman.language import RELATIONS, sentence
from ovman.task import Relation

NOUNS = ("chair", "house plant", "TV stand", "curtains", "boots", "armchair", "CD")


def test_every_relation_of_the_task_has_its_form():
    assert set(RELATIONS) == set(Relation)


def test_no_two_queries_share_a_sentence():
    sentences = [sentence(relation, noun) for relation, noun in product(Relation, NOUNS)]
    assert len(set(sentences)) == len(sentences)


@pytest.mark.parametrize("relation, noun, text", [
    ("moved", "chair", "go to the chair that was moved"),
    ("moved", "boots", "go to the boots that were moved"),
    ("former", "vase", "go to where the vase used to be"),
    ("moving", "chair", "go to the chair that is moving"),
    ("stable", "chair", "go to the chair that stayed in place"),
    ("appeared", "chair", "go to the chair that was not here before"),
    ("removed", "vase", "go to where the vase was before it was taken away"),
    ("removed", "curtains", "go to where the curtains were before they were taken away"),
])  # fmt: skip
def test_canonical_forms(relation, noun, text):
    assert sentence(relation, noun) == text


def test_wrong_input_is_refused():
    with pytest.raises(ValueError, match="not a change relation"):
        sentence("vanished", "chair")
    with pytest.raises(ValueError, match="empty"):
        sentence("moved", " ")

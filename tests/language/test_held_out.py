"""The held-out sentences are well formed and not those of the vocabulary; what the parser makes of them no test asks."""

from __future__ import annotations

import pytest

from ovman.language import RELATIONS, sentence
from ovman.language.held_out import read_held_out
from ovman.language.parser import split_words
from ovman.language.vocabulary import nouns
from ovman.seeds import generator
from tests.language.forms import FORMS

FORMS_PER_RELATION = 12


@pytest.fixture(scope="module")
def held_out():
    return read_held_out()


def test_there_are_enough_forms_for_every_relation_and_it_is_said_where_they_are_from(held_out):
    assert set(held_out.forms) == set(RELATIONS)
    assert {relation: len(set(forms)) for relation, forms in held_out.forms.items() if len(set(forms)) < FORMS_PER_RELATION} == {}
    every = [text for forms in held_out.forms.values() for form in forms for text in (form.singular, form.plural)]
    assert all(text.count("{noun}") == text.count("{") == text.count("}") == 1 for text in every)
    assert held_out.origin and not held_out.origin.endswith(".")


def test_no_form_is_one_of_the_vocabulary_or_of_two_relations(held_out):
    def plain(text: str) -> tuple[str, ...]:
        return split_words(text.replace("{noun}", "chair"))

    known = {plain(text) for forms in FORMS.values() for form in forms for text in (form.singular, form.plural)}
    known |= {plain(sentence(relation, "chair")) for relation in RELATIONS}
    said = [{plain(form.singular) for form in forms} for forms in held_out.forms.values()]
    assert not known & set().union(*said)
    assert sum(map(len, said)) == len(set().union(*said))


def test_a_draw_is_by_seed_and_reaches_every_noun_and_form(held_out):
    draws = [held_out.draw("moved", "Sofa", generator(0, "test", k)) for k in range(600)]
    assert draws == [held_out.draw("moved", "Sofa", generator(0, "test", k)) for k in range(600)]
    assert {noun for noun, _ in draws} == set(nouns("Sofa"))
    assert len({text.replace(noun, "{noun}") for noun, text in draws}) == len(held_out.forms["moved"])

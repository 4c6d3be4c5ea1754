"""The held-out sentences are well formed and not those of the vocabulary; what the parser makes of them no test asks."""

from __future__ import annotations

import pytest

from ovman.language.held_out import read_held_out
from ovman.language.parser import split_words
from ovman.language.sentence import RELATIONS, sentence
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


GOOD = "origin: a test\nforms:\n" + "".join(f"  {relation}:\n    - the {{noun}}\n" for relation in RELATIONS)


@pytest.mark.parametrize(("old", "new", "message"), [
    ("origin: a test\n", "", '"origin"'),
    ("origin: a test", "origin: 3", '"origin"'),
    ("  moved:\n    - the {noun}\n", "", '"forms" must have a list for each'),
    ("  moved:\n    - the {noun}\n", "  moved: []\n", "forms.moved must be a list"),
    ("  moved:\n    - the {noun}\n", "  moved:\n    - the chair\n", 'forms.moved, entry 1: a form has one "{noun}"'),
    ("  moved:\n    - the {noun}\n", "  moved:\n    - {singular: 'the {noun}'}\n", 'entry 1: must be a sentence'),
    ("  moved:\n    - the {noun}\n", "  moved:\n    - 'the {noun} and the {noun}'\n", 'entry 1: a form has one "{noun}"'),
])  # fmt: skip
def test_a_bad_file_is_refused_in_one_line(tmp_path, old, new, message):
    path = tmp_path / "held_out.yaml"
    path.write_text(GOOD)
    assert read_held_out(path).origin == "a test"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(ValueError) as refused:
        read_held_out(path)
    assert message in str(refused.value) and str(path) in str(refused.value) and "\n" not in str(refused.value)

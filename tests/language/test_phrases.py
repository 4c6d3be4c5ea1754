"""Phrases of categories by source, and the relation of a sentence about any of them."""

from __future__ import annotations

import pytest

from ovman.language import RELATIONS, is_plural, noun, other_number
from ovman.language.parser import read_relation
from ovman.language.phrases import NOUN, SOURCES, Phrase, list_phrases
from ovman.language.vocabulary import SYNONYMS
from tests.language.forms import FORMS

ANY = ("settee", "moving box", "old wooden thing", "TV", "child's chair", "place to sleep", "glasses", "stand for boots", "zyx")


def test_phrases_are_listed_by_source_and_the_noun_stands_in_where_there_are_none(tmp_path):
    file = tmp_path / "phrases.yaml"
    file.write_text("Sofa: {wordnet: [settee, lounge], people: [grey couch]}\nBed: {people: [bunk]}\nVase: {wordnet: []}\n")
    sofa = {"wordnet": (Phrase("settee", "wordnet"), Phrase("lounge", "wordnet")), "people": (Phrase("grey couch", "people"),)}
    assert list_phrases("Sofa", file) == sofa
    assert [*list_phrases("Bed", file)] == ["people"]
    for category in ("Vase", "FloorLamp"):
        assert list_phrases(category, file) == {NOUN: (Phrase(noun(category), NOUN),)}


def test_shipped_phrases_are_of_known_categories_and_have_no_article():
    for category in SYNONYMS:
        for source, phrases in list_phrases(category).items():
            assert source in SOURCES and len({*phrases}) == len(phrases)
            said = [phrase.text for phrase in phrases]
            assert not [text for text in said if text != text.strip() or text.split()[0] in ("a", "an", "the") or not text]


@pytest.mark.parametrize("phrase", ANY)
@pytest.mark.parametrize("relation", RELATIONS)
def test_a_form_of_the_vocabulary_is_read_whatever_the_noun_phrase(relation, phrase):
    read = [read_relation(form.singular.replace("{noun}", phrase), phrase) for form in FORMS[relation]]
    assert read.count(relation) == len(read)


def test_the_number_of_a_phrase_does_not_matter():
    for category in SYNONYMS:
        word = noun(category)
        for said in (word, other_number(word)):
            text = f"Go to the {said} that {'were' if is_plural(said) else 'was'} moved."
            assert read_relation(text, said) == "moved"

"""What the vocabulary says the parser understands, and what it does not understand it names."""

from __future__ import annotations

import re
import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.language import RELATIONS, cues, sentence
from ovman.language.cues import find_cues, to_regex
from ovman.language.parser import Parsed, ParseFailure, parse
from ovman.language.vocabulary import all_nouns, nouns
from ovman_engine.plan import floorplan
from tests.language.forms import FORMS, sentences

QUERIES = st.tuples(st.sampled_from(RELATIONS), st.sampled_from(all_nouns()))
FORM = st.integers(min_value=0, max_value=min(map(len, FORMS.values())))


def test_the_vocabulary_has_every_category_of_the_floor_plans():
    categories = {instance.type for name in floorplan.names() for instance in floorplan.load(name).objects}
    assert len(categories) == 118
    assert {noun for category in categories for noun in nouns(category)} <= set(all_nouns())


@pytest.mark.parametrize("relation", RELATIONS)
def test_every_form_is_understood(relation):
    for noun in ("coffee table", "curtains"):
        for said in sentences(relation, noun):
            assert parse(said) == Parsed(noun, relation), said


def test_every_noun_is_told_from_every_other_in_a_sentence():
    # One relation will do: the grammar of the relations is not shown the noun.
    assert [parse(sentence("moved", noun)) for noun in all_nouns()] == [Parsed(noun, "moved") for noun in all_nouns()]


@given(
    query=QUERIES,
    form=FORM,
    article=st.sampled_from(["", "the ", "that ", "my ", "Mum's "]),
    case=st.sampled_from([str, str.upper, str.title, str.lower]),
    before=st.sampled_from(["", "please, ", "Hey robot: ", "Would you be so kind? ", "... "]),
    after=st.sampled_from(["", "!", " please", "?!", ", thank you."]),
    gaps=st.sampled_from([" ", "  ", ", ", " \t"]),
)
def test_articles_case_punctuation_and_politeness_do_not_matter(query, form, article, case, before, after, gaps):
    relation, noun = query
    said = sentences(relation, noun)[form]
    words = said.replace(f"the {noun}", f"{article}{noun}").split(" ")
    assert parse(before + case(gaps.join(words)) + after) == Parsed(noun, relation)


@given(st.text(alphabet=string.printable, max_size=80))
def test_any_text_is_parsed_or_its_failure_is_named(text):
    result = parse(text)
    assert isinstance(result, ParseFailure) or (result.noun_phrase in all_nouns() and result.relation in RELATIONS)


@pytest.mark.parametrize(("said", "failure"), [
    ("", ParseFailure.NO_WORDS),
    (" ?! ", ParseFailure.NO_WORDS),
    ("go there", ParseFailure.NO_NOUN),
    ("go to the thing that was moved", ParseFailure.NO_NOUN),
    ("go to the unicorn that was moved", ParseFailure.UNKNOWN_NOUN),
    ("go to the pool table that was moved", ParseFailure.UNKNOWN_NOUN),
    ("go to the chair leg that was moved", ParseFailure.UNKNOWN_NOUN),
    ("go to the chair and the table that were moved", ParseFailure.AMBIGUOUS_NOUN),
    ("go to the chair", ParseFailure.NO_RELATION),
    ("clean the chair", ParseFailure.NO_RELATION),
    ("go to the chair that was not taken away", ParseFailure.NO_RELATION),
    ("go to the chair that was moved and is new", ParseFailure.AMBIGUOUS_RELATION),
    ("go to the place of the chair that was moved", ParseFailure.AMBIGUOUS_RELATION),
    ("go to where the new chair was", ParseFailure.AMBIGUOUS_RELATION),
])  # fmt: skip
def test_failures_are_named(said, failure):
    assert parse(said) is failure


@pytest.mark.parametrize(("said", "noun", "relation"), [
    ("the coffee table that was moved", "coffee table", "moved"),
    ("the T.V. that was moved", "TV", "moved"),
    ("arm chair that moved", "armchair", "moved"),
    ("the HOUSEPLANT that was moved", "house plant", "moved"),
    ("which of the chairs was moved?", "chair", "moved"),
    ("the vase on the coffee table that was moved", "vase", "moved"),
    ("to be safe, go to the chair that was moved", "chair", "moved"),
    ("the chair that isn't moving", "chair", "stable"),
    ("the chair that isn\u2019t where it was", "chair", "moved"),
    ("the chair that's still where it was", "chair", "stable"),
    ("the chair's old place", "chair", "former"),
    ("the chair's new place", "chair", "moved"),
    ("the chair's been moved, go to where it was", "chair", "former"),
    ("the chair's been moved, go to where it is now", "chair", "moved"),
    ("where is the chair that was not there before?", "chair", "appeared"),
    ("where was the chair that is not there any more?", "chair", "removed"),
    ("the chair that does not stay in its place", "chair", "moving"),
    ("the chair that did not stay in its place", "chair", "moved"),
    ("the chair that stayed while all the others were moved", "chair", "stable"),
])  # fmt: skip
def test_structure_counts_and_not_single_words(said, noun, relation):
    assert parse(said) == Parsed(noun, relation)


@pytest.mark.parametrize(("pattern", "said", "whole"), [
    ("<was> moved", "was moved", True),
    ("<was> <adv>* moved", "was really just moved", True),
    ("a b?", "a", True),
    ("( a | a b ) b?", "a b b", True),
    ("( a b )* c", "a b a c", False),
    ("a | b c", "b c", True),
    ("( a? )* b", "a a b", True),
    ("moved", "removed", False),
])  # fmt: skip
def test_patterns_match_whole_words(pattern, said, whole):
    regex = to_regex(pattern, {"was": "was | were", "adv": "really | just"})
    assert bool(re.fullmatch(regex, "".join(f"{word} " for word in said.split()))) is whole


def test_the_longest_cue_counts_and_cues_do_not_overlap():
    said = ["the", "X", "that", "was", "not", "moved", "is", "in", "a", "new", "place", "now"]
    found = find_cues(said)
    assert [(one.start, one.end) for one in found if cues.Tag.STAYED in one.tags] == [(3, 6)]
    assert not any(cues.Tag.NEW in one.tags for one in found), "a new place is not a new thing"
    assert all(one.end <= other.start for one, other in zip(found, found[1:], strict=False))


def test_repeated_words_take_no_time():
    assert find_cues([*(["'s", "just", "still", "is", "not"] * 30), "moved"])[-1].end == 151

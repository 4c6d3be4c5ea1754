"""The phrases name one category each, and the training of the encoder saw none of them."""

from collections import Counter, defaultdict

import pytest
import yaml

from ovman.language.vocabulary import all_nouns
from training.captions import Senses
from training.phrases import MOST, PHRASES, UNFIT, Judge, Uses, askable, choose_from_people, find_phrases, key

WORDNET = """00000001 06 n 01 lamp 0 000 | a piece of furniture
00000002 06 n 01 stand 0 000 | a small table
00000003 06 n 01 table 0 000 | a flat top
00000004 06 n 01 night 0 000 | a time
00000005 06 n 01 desk 0 000 | a table to write on
00000006 06 n 01 white 0 000 | a colour
00000007 06 n 01 small 0 000 | a part of the back
"""


@pytest.fixture(scope="module")
def phrases() -> dict[str, dict[str, list[str]]]:
    return yaml.safe_load(PHRASES.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def judge() -> Judge:
    return Judge.make(Senses.read(WORDNET))


def test_every_category_that_queries_ask_for_is_listed_and_no_other(phrases):
    assert sorted(phrases) == askable()


def test_each_phrase_is_of_one_category_and_no_noun_of_the_vocabulary(phrases):
    owners = defaultdict(set)
    for category, lists in phrases.items():
        assert set(lists) <= {"wordnet", "people"}
        for listed in lists.values():
            assert listed == sorted(set(listed)) and 0 < len(listed) <= MOST
            for phrase in listed:
                owners[key(phrase)].add(category)
    assert all(len(of) == 1 for of in owners.values())
    assert owners.keys().isdisjoint(key(known) for known in all_nouns())


def test_phrases_pass_the_rules_that_chose_them(phrases, judge):
    listed = [(phrase, category) for category, lists in phrases.items() for of in lists.values() for phrase in of]
    assert [each for each in listed if not judge.accepts(*each)] == []
    assert UNFIT.keys().isdisjoint(phrase for phrase, _ in listed)


@pytest.mark.parametrize(
    ("action", "sentence", "found"),
    [
        ("PutObject", "Put the mug on the small stand, next to the bed.", ("mug", "small stand")),
        ("PutObject", "place a book on top of the night table", ("book", "night table")),
        ("PickupObject", "Pick the box up from the sofa chair in the corner.", ("box", "sofa chair")),
        ("PickupObject", "Pick up the side of the box.", (None, None)),
        ("GotoLocation", "Turn left and walk past the couch to the desk.", ("desk", None)),
        ("GotoLocation", "Step back and turn to face the bin", ("bin", None)),
        ("ToggleObject", "Turn the tall lamp on.", ("tall lamp", None)),
        ("CleanObject", "Wash the mug in the sink.", (None, None)),
    ],
)
def test_objects_and_receptacles_are_found_where_the_verb_puts_them(action, sentence, found):
    assert find_phrases(action, sentence) == found


def test_the_judge_turns_down_what_was_seen_what_is_shared_and_what_names_an_instance(judge):
    fits = {
        ("night table", "SideTable"): True,
        ("night-stand", "SideTable"): False,  # "nightstand" is a noun of the vocabulary
        ("small lamp", "DeskLamp"): True,
        ("small desk", "Desk"): False,  # which of the desks
        ("white night table", "SideTable"): False,
        ("small desk", "SideTable"): False,  # it is a desk
        ("stand", "SideTable"): False,  # a TV stand is one
    }
    assert {each: judge.accepts(*each) for each in fits} == fits


def test_people_need_several_annotators_and_mean_the_category_most_often(judge):
    def said(annotators: int, here: int, there: int) -> Uses:
        by = {("night table", "sidetable"): {str(k) for k in range(annotators)}}
        return Uses(by, {"night table": Counter(sidetable=here, bed=there)}, 0, "")

    assert choose_from_people("SideTable", said(3, 6, 3), judge) == ["night table"]
    assert choose_from_people("SideTable", said(2, 6, 3), judge) == []
    assert choose_from_people("SideTable", said(3, 6, 4), judge) == []

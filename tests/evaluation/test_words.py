"""The words track: the instructions of arms, and the queries that agents read from them."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.interface import Abstention, AbstentionReason, Action, Answer, Instruction, Query, Relation
from ovman.agents.joint.decision import Nouns
from ovman.agents.pilot import GoalAgent
from ovman.agents.words import understand, understands
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.predictions import predict, query_of
from ovman.evaluation.words import draw_phrase, instruct, tell
from ovman.language import noun, phrases
from ovman.language.vocabulary import all_nouns
from ovman.perception.networks import encoder_of, write_noun_embeddings
from ovman.records.episode import Episode
from ovman.settings import Withheld
from ovman.settings.arms import Track
from tests.arms import ARMS, CONFIG
from tests.episodes import DATA, released
from tests.runs import job

FILE = """
Sofa: {wordnet: [settee, lounge], people: [long grey couch, place for three]}
Chair: {wordnet: [seat], people: [brown chair, thing to sit on]}
ArmChair: {people: [recliner]}
Vase: {wordnet: [urn, jar]}
"""
SOURCES = {"Sofa": {"wordnet", "people"}, "Chair": {"wordnet", "people"}, "ArmChair": {"people"}, "Vase": {"wordnet"}}
IN_WORDS = [arm for arm in ARMS if arm.track is Track.WORDS]
EVERYDAY = tuple(Episode.load(DATA / "episodes" / "everyday.jsonl"))


@pytest.fixture(autouse=True)
def some_phrases(tmp_path, monkeypatch):
    """Replace the file of phrases by one of four categories."""
    (tmp_path / "phrases.yaml").write_text(FILE)
    ours = partial(phrases.list_phrases, path=tmp_path / "phrases.yaml")
    monkeypatch.setattr("ovman.evaluation.words.list_phrases", ours)
    return ours


def asked(episode, arm=IN_WORDS[0]):
    return tell(query_of(episode, arm.withheld, 0), arm, episode)


def test_the_paper_s_track_is_told_the_noun_of_the_category_and_the_released_sentence():
    for episode in (*released(), *EVERYDAY):
        query = tell(query_of(episode, None, 0), CONFIG.arms["joint"], episode)
        assert query == Query(episode.category, episode.relation)
        assert (query.phrase, query.sentence) == (episode.noun, episode.sentence)


def test_an_instruction_has_a_sentence_with_its_phrase_and_nothing_else():
    for episode in EVERYDAY[::7]:
        for arm in (arm for arm in IN_WORDS if arm.withheld is None):
            told = asked(episode, arm)
            assert asdict(told) == {"sentence": told.sentence, "phrase": told.phrase} and type(told) is Instruction
            assert not {name for name in dir(told) if name in ("category", "relation")}
            assert told.phrase and told.phrase in told.sentence


def test_words_depend_on_the_episode_alone_and_reach_every_phrase_and_source(some_phrases):
    forwards = {episode.id: instruct(query_of(episode, None, 0), episode) for episode in EVERYDAY}
    backwards = {episode.id: asked(episode, arm) for episode in reversed(EVERYDAY) for arm in IN_WORDS[:1]}
    assert forwards == backwards
    assert len({asked(EVERYDAY[0], arm).sentence for arm in IN_WORDS if arm.withheld is None}) == 1
    for category, wanted in SOURCES.items():
        drawn = [draw_phrase(category, episode) for episode in EVERYDAY]
        assert {phrase.source for phrase in drawn} == wanted
        assert {phrase.text for phrase in drawn} == {one.text for of in some_phrases(category).values() for one in of}
    assert {draw_phrase("FloorLamp", episode).source for episode in EVERYDAY} == {"noun"}


def test_the_noun_is_withheld_from_the_sentence_too():
    arm = next(arm for arm in IN_WORDS if arm.withheld is Withheld.NOUN)
    for episode in EVERYDAY[::7]:
        told, said = asked(episode, arm), asked(episode)
        assert not told.phrase and "thing" in told.sentence and said.phrase not in told.sentence


def test_an_instruction_is_understood_as_a_query_without_a_category():
    told = Instruction(sentence="Where did they move the settee to? Go and stand by it.", phrase="settee")
    query = understand(told)
    assert query == Query("", Relation.MOVED, sentence=told.sentence, phrase="settee")
    assert understand(Query("Sofa", Relation.FORMER)) == Query("Sofa", Relation.FORMER)
    nonsense = Instruction(sentence="The settee.", phrase="settee")
    assert understand(nonsense) == Abstention(AbstentionReason.NOT_PARSED)
    assert understands(lambda query, context: (query.phrase, query.relation))(told, None) == ("settee", Relation.MOVED)


def test_an_agent_abstains_if_it_does_not_understand():
    class Never(GoalAgent):
        def decide(self, query):
            raise AssertionError

    agent = Never(SimpleNamespace())
    agent.ask(Instruction(sentence="The settee.", phrase="settee"))
    assert agent.act(SimpleNamespace()) is Action.ABSTAIN


@pytest.fixture(scope="module")
def nouns_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("nouns") / "nouns.npz"
    write_noun_embeddings(all_nouns(), CONFIG, file)
    return file


def store(name, nouns_file):
    arm, settings = job(name)
    return ObservationStore(arm, settings, 90.0, nouns_file.parent, {"nouns": nouns_file})


def test_any_phrase_has_an_embedding_in_the_words_track_and_nouns_keep_theirs(nouns_file):
    encoder, of_words, of_paper = encoder_of(CONFIG.perception), store("joint_words", nouns_file), store("joint", nouns_file)
    for phrase in ("antique rocking chair", "settle", "Ä-förmiges Ding", "x" * 300, "?", "thing on which my aunt sits"):
        found = of_words.noun(phrase)
        assert np.array_equal(found, encoder.texts([phrase])[0]) and abs(np.linalg.norm(found) - 1) < 1e-5
        with pytest.raises(ValueError, match="has no embedding"):
            of_paper.noun(phrase)
    assert all(np.array_equal(of_words.noun(phrase), of_paper.noun(phrase)) for phrase in all_nouns()[::20])


def test_a_phrase_means_the_categories_whose_captions_it_resembles(nouns_file):
    embedding = store("joint_words", nouns_file).noun
    known = Nouns(embedding, CONFIG.joint)
    shown = {
        phrase: embedding(noun(category))[None] for phrase, category in (("grey settee", "Sofa"), ("potted fern", "HousePlant"))
    }
    for phrase, feature in shown.items():
        others = [known.log_probability(other, phrase)[0] for other in shown.values() if other is not feature]
        assert known.log_probability(feature, phrase)[0] > known.chance > max(others)


def test_an_arm_of_the_words_track_gets_an_instruction(monkeypatch):
    given = []

    def agent(told, context):
        given.append(told)
        return Answer(0.0, 0.0), None

    monkeypatch.setattr("ovman.evaluation.predictions.load_agent", lambda *_: agent)
    for name in ("joint_words", "joint"):
        arm, settings = job(name)
        predict(arm, EVERYDAY[0], settings, ObservationStore(arm, settings, 90.0, DATA))
    assert [type(one) for one in given] == [Instruction, Query]

"""The words track: an arm gets a sentence and its noun phrase, drawn for each episode by name, in place of the query."""

from __future__ import annotations

from ovman import seeds
from ovman.agents.interface import NOTHING_NAMED, Instruction, Query
from ovman.language import sentence
from ovman.language.held_out import read_held_out
from ovman.language.phrases import Phrase, list_phrases
from ovman.records.episode import Episode
from ovman.settings import Arm
from ovman.settings.arms import Track


def tell(query: Query, arm: Arm, episode: Episode) -> Instruction:
    """Return what an arm is told of a query about an episode: all of it, or in the words track an instruction."""
    return instruct(query, episode) if arm.track is Track.WORDS else query


def instruct(query: Query, episode: Episode) -> Instruction:
    """Return an instruction that means the query: a drawn phrase in a held-out or in the canonical sentence.

    The draws depend on the episode alone: whatever the arm and the order of the episodes, an episode is asked in the same words.
    """
    phrase = draw_phrase(query.category, episode).text if query.category else ""
    forms = read_held_out().forms[query.relation]
    number = int(seeds.generator(episode.provenance.seed, "words", episode.id, "sentence").integers(len(forms) + 1))
    named = phrase or NOTHING_NAMED
    said = forms[number].fill(named) if number < len(forms) else sentence(query.relation, named)
    return Instruction(sentence=said, phrase=phrase)


def draw_phrase(category: str, episode: Episode) -> Phrase:
    """Draw a noun phrase of a category for an episode: sources are equally likely, then the phrases of the source."""
    draws = seeds.generator(episode.provenance.seed, "words", episode.id)
    by_source = tuple(list_phrases(category).values())
    phrases = by_source[int(draws.integers(len(by_source)))]
    return phrases[int(draws.integers(len(phrases)))]

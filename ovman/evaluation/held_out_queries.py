"""The two-visit agent asked by a sentence: what it infers of the query, and what it answers to that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, Evidence, Relation
from ovman.agents.reference.reasoning import answer_phrase
from ovman.evaluation.observations import Perceived
from ovman.language.held_out import HeldOut
from ovman.language.parser import Parsed, ParseFailure, parse
from ovman.records.episode import Episode
from ovman.records.visit import VisitPair
from ovman.seeds import generator
from ovman.settings import Settings

SCHEMA = "ovman-sentence/1"


@dataclass(frozen=True, slots=True)
class Asked:
    """A sentence about an episode. noun: the one in it; relation: the one that is meant; understood: the parser's result."""

    episode: str
    sentence: str
    noun: str
    relation: Relation
    understood: Parsed | ParseFailure

    @property
    def object_right(self) -> bool:
        """Whether the noun was found; a sentence that is not parsed has neither noun nor relation."""
        return isinstance(self.understood, Parsed) and self.understood.noun_phrase == self.noun

    @property
    def relation_right(self) -> bool:
        """Whether the relation was found."""
        return isinstance(self.understood, Parsed) and self.understood.relation == self.relation

    @property
    def read_as(self) -> str:
        """The relation that was read, or the name of the failure."""
        return self.understood.relation if isinstance(self.understood, Parsed) else str(self.understood)

    def to_json(self) -> dict[str, Any]:
        """{"schema", "episode", "sentence", "noun", "relation"} and {"parsed": {"noun_phrase", "relation"}} or {"failure"}."""
        record = {"schema": SCHEMA, "episode": self.episode, "sentence": self.sentence, "noun": self.noun}
        record["relation"] = str(self.relation)
        match self.understood:
            case Parsed(noun_phrase, relation):
                return record | {"parsed": {"noun_phrase": noun_phrase, "relation": relation}}
            case failure:
                return record | {"failure": str(failure)}


def ask(episode: Episode, held_out: HeldOut) -> Asked:
    """Draw a held-out sentence for an episode, by its seed and id alone, and parse it."""
    draws = generator(episode.provenance.seed, "language", episode.id)
    noun, sentence = held_out.draw(episode.relation, episode.category, draws)
    return Asked(episode.id, sentence, noun, episode.relation, parse(sentence))


def answer(
    noun_phrase: str, relation: str, visits: VisitPair[str], perceived: Perceived, settings: Settings
) -> tuple[Answer | Abstention, Evidence]:
    """Return the answer of the reference agent with two visits to a query of any noun phrase and relation.

    visits: the names of both visits of the episode; settings: those of the reference agent. Raises ValueError as ``Perceived``
    does for a visit without a map or a noun phrase without an embedding.
    """
    map_1, map_2 = (perceived.map(visits[visit]) for visit in VISITS)
    return answer_phrase(Relation(relation), map_1, map_2, perceived.noun(noun_phrase), settings)


NOT_UNDERSTOOD = Abstention(AbstentionReason.NOT_PARSED)

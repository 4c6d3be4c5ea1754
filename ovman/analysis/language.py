"""Evaluate the parser on held-out sentences, and the two-visit agent on the queries that it reads from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, Evidence, Relation
from ovman.agents.reference.reasoning import answer_phrase
from ovman.analysis.instances import scene_files
from ovman.analysis.outcomes import find_successes, group_by
from ovman.analysis.rows import Row, write_csv
from ovman.analysis.statistics import compare_paired, wilson_interval
from ovman.evaluation.observations import Perceived, read_perceived
from ovman.language.held_out import HeldOut, read_held_out
from ovman.language.parser import Parsed, ParseFailure, parse
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.record import line, lines
from ovman.records.visit import VisitPair
from ovman.seeds import generator
from ovman.settings import Settings

SCHEMA = "ovman-sentence/1"
LANGUAGE = "what relation read_as n count rate low high confidence wins losses p origin"
NOT_UNDERSTOOD = Abstention(AbstentionReason.NOT_PARSED)


class What(StrEnum):
    """The quantity that a row counts.

    Of the sentences: OBJECT, RELATION and BOTH, understood right; READ_AS, what each relation was read as. Of the episodes: the
    successes of the two-visit agent with the query SUPPLIED, and with the relation, the noun or both INFERRED from the
    sentence. A sentence that is not parsed is a failure.
    """

    OBJECT = "object"
    RELATION = "relation"
    BOTH = "both"
    SUPPLIED = "supplied"
    RELATION_INFERRED = "relation_inferred"
    NOUN_INFERRED = "noun_inferred"
    INFERRED = "inferred"
    READ_AS = "read_as"


INFERRED: Mapping[What, tuple[bool, bool]] = {
    What.RELATION_INFERRED: (False, True),
    What.NOUN_INFERRED: (True, False),
    What.INFERRED: (True, True),
}
"""Whether the noun and whether the relation are read from the sentence."""


@dataclass(frozen=True, slots=True)
class Asked:
    """A sentence about an episode. noun: of the sentence; relation: of the episode; understood: the parser's result."""

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


def write_language(
    episodes_file: Path,
    supplied_file: Path,
    maps: Sequence[Path],
    nouns_file: Path,
    held_out_file: Path,
    settings: Settings,
    directory: Path,
    output: Path,
) -> None:
    """Write the sentences and the predictions with inferred queries into a directory, and the rows of `count_understood`.

    supplied_file: the predictions of the arm comparisons.agent. Settings: comparisons.agent, success.radius_m,
    evaluation.confidence and those of the reference agent.
    """
    episodes, held_out = Episode.load(episodes_file), read_held_out(held_out_file)
    asked = [ask(episode, held_out) for episode in episodes]
    perceived = read_perceived(scene_files(maps), nouns_file)
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "sentences.jsonl").write_text("".join(line(one.to_json()) for one in asked), encoding="utf-8")
    succeeded = {What.SUPPLIED: find_successes(episodes, Prediction.read(supplied_file), settings.success.radius_m)}
    for what in INFERRED:
        predictions = predict_inferred(what, episodes, asked, perceived, settings)
        (directory / f"{what}.jsonl").write_text(lines(predictions), encoding="utf-8")
        succeeded[what] = find_successes(episodes, predictions, settings.success.radius_m)
    write_csv(output, LANGUAGE, count_understood(asked, succeeded, settings.evaluation.confidence, held_out.origin))


def predict_inferred(
    what: What, episodes: Sequence[Episode], asked: Sequence[Asked], perceived: Mapping[str, Perceived], settings: Settings
) -> list[Prediction]:
    """Predict with the two-visit agent, asked by what was understood of the sentences. `what`: one of INFERRED."""
    arm, (noun_inferred, relation_inferred) = f"{settings.comparisons.agent}_{what}", INFERRED[what]
    predictions = []
    for episode, one in zip(episodes, asked, strict=True):
        match one.understood:
            case Parsed(noun_phrase, relation):
                phrase = noun_phrase if noun_inferred else episode.noun
                asked_for = relation if relation_inferred else episode.relation
                outcome, evidence = answer(phrase, asked_for, episode.visits, perceived[episode.scene], settings)
                predictions.append(Prediction.of(one.episode, arm, 0, outcome, evidence))
            case ParseFailure():
                predictions.append(Prediction.of(one.episode, arm, 0, NOT_UNDERSTOOD))
    return predictions


def count_understood(
    asked: Sequence[Asked], succeeded: Mapping[What, Mapping[str, bool]], confidence: float, origin: str
) -> list[Row]:
    """Count by what, then by relation and over all; READ_AS rows come last, without empty ones.

    read_as: of a READ_AS row, a relation or the name of a failure. wins, losses, p: against the success with the query
    supplied, of inferred queries. origin: where the sentences are from.
    """
    is_right: Mapping[What, Callable[[Asked], bool]] = {
        What.OBJECT: lambda one: one.object_right,
        What.RELATION: lambda one: one.relation_right,
        What.BOTH: lambda one: one.object_right and one.relation_right,
    }
    right = {what: {one.episode: test(one) for one in asked} for what, test in is_right.items()} | dict(succeeded)
    by_relation = group_by(asked, "relation")

    def row(what: What, relation: str, count: int, read_as: str | None = None) -> Row:
        n = len(by_relation[relation])
        low, high = wilson_interval(count, n, confidence)
        tests = dict.fromkeys(("wins", "losses", "p"))
        values = {"what": what, "relation": relation, "read_as": read_as, "n": n, "count": count, "rate": count / n}
        return values | {"low": low, "high": high, "confidence": confidence, **tests, "origin": origin}

    rows = []
    for what, hits in right.items():
        for relation, group in by_relation.items():
            ids = [one.episode for one in group]
            rows.append(row(what, relation, sum(hits[name] for name in ids)))
            if what in INFERRED:
                against = compare_paired((hits[name] for name in ids), (succeeded[What.SUPPLIED][name] for name in ids))
                rows[-1] |= zip(("wins", "losses", "p"), against, strict=True)
    for relation, group in by_relation.items():
        for name in (*map(str, Relation), *map(str, ParseFailure)):
            if count := sum(one.read_as == name for one in group):
                rows.append(row(What.READ_AS, relation, count, name))
    return rows


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

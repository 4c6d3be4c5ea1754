"""Stage `language`: how well held-out sentences are understood, and which success is left with queries read from them. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.outcomes import Case, StaticOutcome, static_outcomes
from ovman.analysis.rates import ALL
from ovman.analysis.statistics import mcnemar_exact, wilson_interval
from ovman.evaluation.held_out_queries import NOT_UNDERSTOOD, Asked, answer, ask
from ovman.evaluation.observations import Perceived, read_perceived
from ovman.language.held_out import read_held_out
from ovman.language.parser import Parsed, ParseFailure
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.record import line, lines
from ovman.records.task import Relation
from ovman.settings import Settings

SENTENCES, METRICS = "sentences.jsonl", "language.csv"
RELATION_INFERRED, NOUN_INFERRED, INFERRED = "relation_inferred", "noun_inferred", "inferred"


class What(StrEnum):
    """What a row counts. Of the sentences: OBJECT, RELATION and BOTH, read right; READ_AS, what each relation was read as. Of the
    episodes: successes of the two-visit agent with the query SUPPLIED, with the noun supplied and RELATION_INFERRED from the
    sentence, with NOUN_INFERRED and the relation supplied, and with both INFERRED. There a sentence that is not parsed is a
    failure."""

    OBJECT = "object"
    RELATION = "relation"
    BOTH = "both"
    SUPPLIED = "supplied"
    RELATION_INFERRED = "relation_inferred"
    NOUN_INFERRED = "noun_inferred"
    INFERRED = "inferred"
    READ_AS = "read_as"


@dataclass(frozen=True, slots=True)
class LanguageRate:
    """relation: the one that was meant, or "all". read_as: of READ_AS rows, a relation or the name of a failure; else None.

    count of n; low, high: Wilson's interval at ``confidence``. wins, losses: episodes that succeed unlike with the query
    supplied, p of their exact McNemar test; None but for the three inferred rows. origin: where the sentences are from.
    """

    what: What
    relation: str
    read_as: str | None
    n: int
    count: int
    rate: float
    low: float
    high: float
    confidence: float
    wins: int | None = None
    losses: int | None = None
    p: float | None = None
    origin: str = ""


def run(
    episodes_file: Path,
    supplied_file: Path,
    maps_files: Sequence[Path],
    nouns_file: Path,
    held_out_file: Path,
    constants: Settings,
    output_dir: Path,
) -> None:
    """Writes the sentences, the predictions of the inferred arms and "language.csv" into output_dir.

    supplied_file: the predictions of the arm comparisons.agent. constants: comparisons.agent, success.radius_m,
    evaluation.confidence and those of the reference agent. Raises ValueError in one line.
    """
    episodes = Episode.load(episodes_file)
    held_out = read_held_out(held_out_file)
    asked = [ask(episode, held_out) for episode in episodes]
    perceived = read_perceived(maps_files, nouns_file)
    supplied = Prediction.read(supplied_file)
    relation_inferred = inferred(RELATION_INFERRED, episodes, asked, perceived, constants, said_noun=False)
    noun_inferred = inferred(NOUN_INFERRED, episodes, asked, perceived, constants, said_noun=True, said_relation=False)
    both_inferred = inferred(INFERRED, episodes, asked, perceived, constants, said_noun=True)
    cases = [Case.of(episode) for episode in episodes]
    rates = language_rates(
        asked,
        {
            What.SUPPLIED: successes(cases, supplied, constants),
            What.RELATION_INFERRED: successes(cases, relation_inferred, constants),
            What.NOUN_INFERRED: successes(cases, noun_inferred, constants),
            What.INFERRED: successes(cases, both_inferred, constants),
        },
        constants.evaluation.confidence,
        held_out.origin,
    )
    output_dir.mkdir(parents=True, exist_ok=True)
    (output_dir / SENTENCES).write_text("".join(line(one.to_json()) for one in asked), encoding="utf-8")
    (output_dir / f"{RELATION_INFERRED}.jsonl").write_text(lines(relation_inferred), encoding="utf-8")
    (output_dir / f"{NOUN_INFERRED}.jsonl").write_text(lines(noun_inferred), encoding="utf-8")
    (output_dir / f"{INFERRED}.jsonl").write_text(lines(both_inferred), encoding="utf-8")
    frames.write(output_dir / METRICS, LanguageRate, rates)
    right = sum(one.object_right and one.relation_right for one in asked)
    print(f"{right} of {len(asked)} held-out sentences are understood; origin: {held_out.origin}", flush=True)


def inferred(
    name: str,
    episodes: Sequence[Episode],
    asked: Sequence[Asked],
    perceived: Mapping[str, Perceived],
    constants: Settings,
    *,
    said_noun: bool,
    said_relation: bool = True,
) -> list[Prediction]:
    """What the two-visit agent answers to the queries as they were understood.

    name: what follows the agent's name in that of the arm. said_noun: whether the noun is the one that was understood, or the
    category's own, supplied; said_relation: likewise of the relation. A sentence that was not understood gives neither.
    """
    arm = f"{constants.comparisons.agent}_{name}"
    predictions = []
    for episode, one in zip(episodes, asked, strict=True):
        match one.understood:
            case Parsed(noun_phrase, relation):
                phrase = noun_phrase if said_noun else episode.noun
                asked_for = relation if said_relation else episode.relation
                outcome, evidence = answer(phrase, asked_for, episode.visits, perceived[episode.scene], constants)
                predictions.append(Prediction.of(one.episode, arm, 0, outcome, evidence))
            case ParseFailure():
                predictions.append(Prediction.of(one.episode, arm, 0, NOT_UNDERSTOOD))
    return predictions


def successes(cases: Sequence[Case], predictions: Sequence[Prediction], constants: Settings) -> dict[str, bool]:
    """Which episodes succeed, by their ids. The gate is that of ``static_outcomes``."""
    judged: list[StaticOutcome] = static_outcomes(cases, predictions, radius_m=constants.success.radius_m, samples=1, seed=0)
    return {outcome.episode: outcome.success == 1.0 for outcome in judged}


def language_rates(
    asked: Sequence[Asked], succeeded: Mapping[What, Mapping[str, bool]], confidence: float, origin: str
) -> list[LanguageRate]:
    """Every row of "language.csv": by what, then by relation with "all" last; READ_AS rows at the end, those that count."""
    right: Mapping[What, Callable[[Asked], bool]] = {
        What.OBJECT: lambda one: one.object_right,
        What.RELATION: lambda one: one.relation_right,
        What.BOTH: lambda one: one.object_right and one.relation_right,
        **{what: partial(_succeeds, of) for what, of in succeeded.items()},
    }
    groups = {str(relation): [one for one in asked if one.relation is relation] for relation in Relation} | {ALL: list(asked)}
    groups = {relation: group for relation, group in groups.items() if group}

    def rate(what: What, relation: str, count: int, read_as: str | None = None) -> LanguageRate:
        n = len(groups[relation])
        low, high = wilson_interval(count, n, confidence)
        return LanguageRate(what, relation, read_as, n, count, count / n, low, high, confidence, origin=origin)

    rows = []
    for what, is_right in right.items():
        for relation, group in groups.items():
            row = rate(what, relation, sum(map(is_right, group)))
            rows.append(_paired(row, group, succeeded[what], succeeded[What.SUPPLIED]) if what in _INFERRED else row)
    for relation, group in groups.items():
        for name in (*map(str, Relation), *map(str, ParseFailure)):
            count = sum(one.read_as == name for one in group)
            if count:
                rows.append(rate(What.READ_AS, relation, count, name))
    return rows


_INFERRED = (What.RELATION_INFERRED, What.NOUN_INFERRED, What.INFERRED)


def _succeeds(of: Mapping[str, bool], one: Asked) -> bool:
    return of[one.episode]


def _paired(row: LanguageRate, group: Sequence[Asked], of: Mapping[str, bool], supplied: Mapping[str, bool]) -> LanguageRate:
    """The row with its test against the success with the query supplied."""
    wins = sum(of[one.episode] and not supplied[one.episode] for one in group)
    losses = sum(supplied[one.episode] and not of[one.episode] for one in group)
    return replace(row, wins=wins, losses=losses, p=mcnemar_exact(wins, losses))

"""What the records say under one setting, by the functions of the workflow: what the page must show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from ovman.analysis.outcomes import Case, static_outcomes
from ovman.analysis.rates import static_rates
from ovman.evaluation.scoring import judged
from ovman.explore.records import Records
from ovman.explore.setting import Setting, under
from ovman.generation.release import rejection
from ovman.generation.verdict import verdict
from ovman.records.relation import Relation
from ovman.records.trial import Trial
from ovman.settings import Settings

UNCERTIFIED = "not_certified"
"""Stands for a reason where a trial is admissible and the oracle has not run it, since the setting in force rejects it."""
NONE = ""
"""Stands for a reason where there is none."""


@dataclass(frozen=True, slots=True)
class Reading:
    """rejected: trials by (relation, first reason against them), `UNCERTIFIED` among the reasons; certified: those with none.

    left: the released episodes among these, by relation. success: of each arm on them, by relation, then "all"; arms of no
    prediction on them have none. margin: of comparisons.memory, None where no episode is left.
    """

    rejected: Mapping[tuple[str, str], int]
    certified: Mapping[str, int]
    left: Mapping[str, int]
    success: Mapping[str, Mapping[str, float]]
    margin: float | None


def reading(records: Records, settings: Settings, setting: Setting) -> Reading:
    """The records under a setting; constants that it does not name are those of the settings."""
    constants = under(settings, setting)
    against = {trial.candidate.id: reason_of(trial, records, constants) for trial in records.trials}
    relation_of = {trial.candidate.id: str(trial.candidate.relation) for trial in records.trials}
    left = [one for one in records.episodes if against[one.id] == NONE]
    cases = [Case.of(one) for one in left]
    there = {one.id: one for one in left}
    success: dict[str, dict[str, float]] = {}
    for arm, predictions in records.predictions.items():
        of = [prediction for prediction in predictions if prediction.episode in there]
        outcomes = static_outcomes(
            cases,
            of,
            radius_m=constants.success.radius_m,
            samples=constants.single_visit.samples,
            seed=constants.benchmark.seed,
        )
        if outcomes:
            success[arm] = {rate.relation: rate.rate for rate in static_rates(outcomes, constants.evaluation.confidence)}
    for arm, runs in records.runs.items():
        of_runs = [
            (
                str(there[run.episode].relation),
                judged(
                    run,
                    there[run.episode].relation,
                    there[run.episode].protocol.success.model_copy(update={"radius_m": constants.success.radius_m}),
                ),
            )
            for run in runs
            if run.episode in there
        ]
        if of_runs:
            by = {str(relation): [found for at, found in of_runs if at == relation] for relation in Relation}
            success[arm] = {name: sum(found) / len(found) for name, found in by.items() if found}
            success[arm]["all"] = sum(found for _, found in of_runs) / len(of_runs)
    memory = settings.comparisons.memory
    both = memory.arm in success and memory.baseline in success
    return Reading(
        Counter((relation_of[name], reason) for name, reason in against.items() if reason != NONE),
        Counter(relation_of[name] for name, reason in against.items() if reason == NONE),
        Counter(str(one.relation) for one in left),
        success,
        success[memory.arm]["all"] - success[memory.baseline]["all"] if both else None,
    )


def reason_of(trial: Trial, records: Records, constants: Settings) -> str:
    """The first reason against a trial under these constants, certification included; `UNCERTIFIED` or `NONE`."""
    found = verdict(trial, constants)
    if found.rejected is not None:
        return str(found.rejected)
    runs = records.certified.get(found.id)
    if runs is None:
        return UNCERTIFIED
    return str(rejection(found, runs, constants.success) or NONE)

"""All readings of the records on the grid of the sliders, small enough for a page.

The reasons against a trial come in the order of Algorithm 1, and each part of them depends on few thresholds: geometry on
Delta_min and the validity radius, observations on tau, Delta_min and the smallest mask, drift on its tolerance, certification on
R. So a trial is four small tables, and most trials have theirs in common with many others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

from ovman.analysis.outcomes import Case, StaticOutcome, is_expectation, static_outcomes
from ovman.evaluation.scoring import judged
from ovman.explore.reading import NONE, UNCERTIFIED
from ovman.explore.records import Records
from ovman.explore.setting import in_force, positions, under
from ovman.generation.release import rejection
from ovman.generation.verdict import against_drift, against_geometry, against_observations
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.records.trial import Trial, Verdict
from ovman.settings import Kind, Settings

GEOMETRY, OBSERVATION = ("delta_min_m", "validity_radius_m"), ("tau_m", "delta_min_m", "min_mask_px")
DRIFT, CERTIFICATION = ("drift_tolerance_m",), ("radius_m",)
ALPHABET = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
NEVER, ABSENT = "-", " "
DECIMALS = 6
Say = Callable[[str], None]


def encoded(records: Records, settings: Settings, say: Say) -> dict[str, Any]:
    """The data of the page. say: told how far it is. Tables are texts of a character a position, the last slider fastest.

    sliders: positions by name; start: numbers of those in force. reasons: of a character's number in `ALPHABET`, with their stage
    of Algorithm 1. trials: [relation, geometry, observations, drift, certification, episode or -1], numbers of `tables`. arms: of
    each run a text of a character an episode, the number of the least R at which it succeeds, or a list of probabilities by R.
    """
    sliders = positions(settings)
    start = {name: sliders[name].index(value) for name, value in in_force(settings).items()}
    number = {one.id: place for place, one in enumerate(records.episodes)}
    tables: dict[str, int] = {}
    trials = []
    for done, trial in enumerate(records.trials, start=1):
        found = [tables.setdefault(text, len(tables)) for text in _tables(trial, records, settings, sliders)]
        trials.append([list(Relation).index(trial.candidate.relation), *found, number.get(trial.candidate.id, -1)])
        if done % 500 == 0 or done == len(records.trials):
            say(f"{done} of {len(records.trials)} trials judged at every position of the sliders")
    return {
        "split": records.split,
        "sliders": sliders,
        "start": start,
        "relations": [str(relation) for relation in Relation],
        "episodes": [list(Relation).index(one.relation) for one in records.episodes],
        "reasons": [[reason, _stage(reason)] for reason in REASONS],
        "tables": [*tables],
        "trials": trials,
        "arms": [*_static(records, settings, sliders["radius_m"]), *_embodied(records, settings, sliders["radius_m"])],
        "memory": [settings.comparisons.memory.arm, settings.comparisons.memory.baseline],
    }


REASONS = (NONE, *map(str, Rejection), UNCERTIFIED)
"""By their numbers in the tables."""


def _stage(reason: str) -> str:
    if reason in (NONE, UNCERTIFIED):
        return "" if reason == NONE else "certification"
    return str(Rejection(reason).stage)


def _tables(trial: Trial, records: Records, settings: Settings, sliders: dict[str, list[float]]) -> Iterator[str]:
    """Of geometry, observations, drift and certification."""
    candidate, measured = trial.candidate, trial.measured
    if isinstance(measured.ended, Rejection):
        yield from (_constant(str(measured.ended)), *[_constant(NONE)] * 3)
        return
    yield _table(GEOMETRY, sliders, settings, lambda constants: against_geometry(candidate, measured, constants))
    if measured.sightings is None:
        yield from [_constant(NONE)] * 2
    else:
        yield _table(OBSERVATION, sliders, settings, lambda constants: against_observations(candidate, measured, constants))
        yield _table(DRIFT, sliders, settings, lambda constants: against_drift(measured, constants))
    runs = records.certified.get(candidate.id)
    if runs is None:
        yield _constant(UNCERTIFIED)
        return
    admissible = Verdict(id=candidate.id, relation=candidate.relation, rejected=None, reasons=())

    def of_runs(constants: Settings) -> Iterator[Rejection]:
        against = rejection(admissible, runs, constants.success)
        if against is not None:
            yield against

    yield _table(CERTIFICATION, sliders, settings, of_runs)


def _table(
    names: Sequence[str], sliders: dict[str, list[float]], settings: Settings, against: Callable[[Settings], Iterator[Rejection]]
) -> str:
    """The first reason at each combination of positions; one character where all are the same."""
    codes = []
    for values in product(*(sliders[name] for name in names)):
        constants = under(settings, dict(zip(names, values, strict=True)))
        codes.append(_code(str(next(against(constants), NONE))))
    return codes[0] if len({*codes}) == 1 else "".join(codes)


def _constant(reason: str) -> str:
    return _code(reason)


def _code(reason: str) -> str:
    return ALPHABET[REASONS.index(reason)]


def _static(records: Records, settings: Settings, radii: Sequence[float]) -> Iterator[dict[str, Any]]:
    cases = [Case.of(one) for one in records.episodes]
    for arm, predictions in records.predictions.items():
        at: list[dict[tuple[int, str], StaticOutcome]] = []
        for radius_m in radii:
            outcomes = static_outcomes(
                cases, predictions, radius_m=radius_m, samples=settings.single_visit.samples, seed=settings.benchmark.seed
            )
            at.append({(outcome.seed, outcome.episode): outcome for outcome in outcomes})
        runs: list[Any] = []
        for seed in sorted({seed for seed, _ in at[0]}):
            of = [[found.get((seed, case.id)) for found in at] for case in cases]
            if any(one is not None and is_expectation(one) for row in of for one in row):
                runs.append([[None if one is None else round(float(one.success), DECIMALS) for one in row] for row in of])
            else:
                runs.append("".join(_least([None if one is None else bool(one.success) for one in row]) for row in of))
        yield _arm(arm, settings, runs)


def _embodied(records: Records, settings: Settings, radii: Sequence[float]) -> Iterator[dict[str, Any]]:
    for arm, found in records.runs.items():
        by_seed = {seed: {run.episode: run for run in found if run.seed == seed} for seed in sorted({run.seed for run in found})}
        runs = []
        for of in by_seed.values():
            text = ""
            for episode in records.episodes:
                run, success = of.get(episode.id), episode.protocol.success
                text += _least(
                    [
                        None if run is None else judged(run, episode.relation, success.model_copy(update={"radius_m": radius_m}))
                        for radius_m in radii
                    ]
                )
            runs.append(text)
        yield _arm(arm, settings, runs)


def _arm(name: str, settings: Settings, runs: list[Any]) -> dict[str, Any]:
    arm = settings.arms[name]
    return {
        "name": name,
        "title": arm.system if arm.kind is Kind.EMBODIED else f"{arm.system}, {arm.memory}",
        "kind": str(arm.kind),
        "block": "control" if arm.control else "handed" if "handed" in (arm.grounding, arm.positions, arm.answer) else "system",
        "runs": runs,
    }


def _least(successes: Sequence[bool | None]) -> str:
    """The number of the least R at which a run succeeds. ValueError where it fails at a larger one."""
    if successes[0] is None:
        return ABSENT
    first = next((number for number, success in enumerate(successes) if success), None)
    if first is None:
        return NEVER
    if not all(successes[first:]):
        raise ValueError("a run succeeds within a radius and not within a larger one")
    return ALPHABET[first]

"""What stands beside a score: released arms on the same episodes, chance, and exact tests, so that a score that a control reaches
is seen to be one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ovman.analysis.outcomes import is_expectation
from ovman.analysis.rates import Rate, by_arm, by_seed, chances
from ovman.analysis.significance import Comparison, Outcome, family
from ovman.entry.release import Release
from ovman.settings import Kind, Pair


@dataclass(frozen=True, slots=True)
class Beside:
    """Released arms beside a score. references: the arms that are the reference agent.

    released: rates by relation, then all, of these and of the controls. chance: the mean of 1/n_i by relation and over all, n_i
    the instances of an episode's category. tests: each run that was judged against the released arms, by relation, then all.
    untested: a line for each arm that is not tested, and why. systems: what the released arms are called, by name. entries:
    driving rates on the same episodes, by name, of the leaderboard's entries on a split that the release has no rates of.
    """

    references: frozenset[str]
    released: Sequence[Rate]
    chance: Mapping[str, float]
    tests: Sequence[Comparison]
    untested: Sequence[str]
    systems: Mapping[str, str]
    entries: Mapping[str, Sequence[Rate]] = field(default_factory=dict)


def set_beside(judged: Sequence[Outcome], kind: Kind, split: str | None, release: Release, whole: bool = True) -> Beside:
    """What stands beside these outcomes, of arms of one kind. split: the released split that they are of, None for others.

    whole: whether they cover it; released arms and tests are there only then. A static run is tested against the arms that were
    realised once, an embodied one against runs under its own seed.
    """
    rates, outcomes = ([], []) if split is None or not whole else release.of_kind(kind, split)
    entries = {} if split is None else release.entered(kind, split, {outcome.episode for outcome in judged})
    systems = {name: arm.system for name, arm in release.settings.arms.items()}
    tests, untested = _tests(judged, outcomes, kind, systems)
    chance = chances({outcome.episode: outcome for outcome in judged})
    by_relation = {relation: of_n for relation, (of_n, _) in chance.items()}
    return Beside(release.references(kind), rates, by_relation, tests, untested, systems, entries)


def _tests(
    judged: Sequence[Outcome], released: Sequence[Outcome], kind: Kind, systems: Mapping[str, str]
) -> tuple[list[Comparison], list[str]]:
    tests, untested = [], []
    baselines = {}
    for name, outcomes in by_arm(released).items():
        runs = by_seed(outcomes)
        if any(map(is_expectation, outcomes)):
            untested.append(f"{systems[name]}: a stochastic pick")
        elif kind is Kind.STATIC and len(runs) > 1:
            untested.append(f"{systems[name]}: {len(runs)} runs")
        else:
            baselines[name] = runs
    for arm, outcomes in by_arm(judged).items():
        if any(map(is_expectation, outcomes)):
            untested.append(f"{arm}, which is judged: a stochastic pick")
            continue
        for seed, run in by_seed(outcomes).items():
            for name, runs in baselines.items():
                baseline = runs.get(seed) if kind is Kind.EMBODIED else next(iter(runs.values()))
                if baseline is None:
                    untested.append(f"{systems[name]}: no run under seed {seed}")
                else:
                    tests += family(Pair(name=f"{arm} against {name}", arm=arm, baseline=name), seed, run, baseline)
    return tests, untested

"""Static and embodied success broken down: by scene, seed, difficulty, failure, rung of the error budget, and kind of oracle."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from enum import StrEnum
from itertools import pairwise

from ovman.analysis.comparisons import Comparison
from ovman.analysis.outcomes import ALL, Outcome, group_by, groups, is_expectation
from ovman.analysis.rates import Rate, rates
from ovman.analysis.rows import Row
from ovman.analysis.statistics import compare_paired, mcnemar_exact
from ovman.evaluation.words import draw_phrase
from ovman.language.phrases import SOURCES
from ovman.records.episode import Episode
from ovman.settings import Arm, Kind, Source
from ovman.settings.arms import Track

SCENES = "kind arm scene n seeds successes rate low high interval confidence least greatest"
SEEDS = "kind arm relation seed n successes rate"
DIFFICULTY = "by group arm n successes rate low high interval confidence"
SHORTCUTS = "kind arm relation n chance rate excess crowded crowded_rate uncrowded_rate"
TAXONOMY = "arm verdict relation episodes n embodied seed"
BUDGET = "rung arm relation n successes rate low high gain gained lost p"
READINGS = "map grounding arm relation n successes rate low high gained lost p"
WORDS = "arm track source n successes rate low high interval confidence"
INSTANCES, SCENE = "instances", "scene"
ANSWER_GIVEN = "answer given"
"""Title of the highest rung, the answer itself, which needs no arm."""
LOST = "lost_in_navigation"
"""The static successes that fail when executed, a subset of the verdict SUCCESS."""
OWN, POSITIONS = "own", "positions"


def seed_rates(outcomes: Sequence[Outcome], confidence: float) -> list[Row]:
    """Compute the rate of every arm in each single pass over the episodes.

    A static arm with one run answers the same under every seed and has no rows.
    """
    passes = groups(outcomes, "kind", "arm").items()
    shown = [one for (kind, _), of in passes if kind is Kind.EMBODIED or len(group_by(of, "seed")) > 1 for one in of]
    return rates(shown, ("kind", "arm", "relation", "seed"), confidence)


def words(outcomes: Sequence[Outcome], episodes: Sequence[Episode], arms: Mapping[str, Arm], confidence: float) -> list[Row]:
    """Compute the rate of each arm of the words track, and of the arm that it ablates, by the source of the episode's phrase."""
    source, of_arm, rows = {one.id: draw_phrase(one.category, one).source for one in episodes}, group_by(outcomes, "arm"), []
    for name in (name for name in of_arm if arms[name].track is Track.WORDS):
        for track, judged in ((Track.PAPER, of_arm.get(arms[name].ablates, [])), (Track.WORDS, of_arm[name])):
            for part in (ALL, *SOURCES):
                if group := [one for one in judged if part in (ALL, source[one.episode])]:
                    rows += [{"arm": name, "track": track, "source": part, **row} for row in rates(group, (), confidence)]
    return rows


def difficulty(static: Sequence[Outcome], confidence: float) -> list[Row]:
    """Compute the static rates by the number of instances of the category and by scene (the paper's Fig. difficulty)."""
    return [
        {"by": by, "group": row[column], **row}
        for by, column in ((INSTANCES, "instance_group"), (SCENE, "scene"))
        for row in rates(static, (column, "arm"), confidence)
    ]


def shortcuts(outcomes: Sequence[Outcome], radius_m: float) -> list[Row]:
    """Compare every arm with the chance of 1/n, and its success on crowded and on uncrowded episodes.

    An episode is crowded if another instance of the category is within `radius_m` of the answer.
    """
    rows: list[Row] = []
    for (kind, arm, relation), group in groups(outcomes, "kind", "arm", "relation").items():
        crowded = [one for one in group if one.neighbour_m is not None and one.neighbour_m <= radius_m]
        others = [one for one in group if one.neighbour_m is None or one.neighbour_m > radius_m]
        chance, rate = math.fsum(1.0 / one.instances for one in group) / len(group), _mean_success(group)
        row = {"kind": kind, "arm": arm, "relation": relation, "n": len({one.episode for one in group})}
        row |= {"chance": chance, "rate": rate, "excess": rate - chance, "crowded": len({one.episode for one in crowded})}
        row |= {"crowded_rate": _mean_success(crowded) if crowded else None}
        rows.append(row | {"uncrowded_rate": _mean_success(others) if others else None})
    return rows


def _mean_success(outcomes: Sequence[Outcome]) -> float:
    return math.fsum(one.success for one in outcomes) / len(outcomes)


class Verdict(StrEnum):
    """The verdict on an episode, in the order of the paper's table; every episode has exactly one.

    SUCCESS: the point is within R of the answer; if success is exclusive, it is also nearer to the answer than to every rival.
    ABSTAIN: the arm abstained. WRONG_INSTANCE: the point fails and is within R of another instance of the category, in the visit
    that the answer belongs to. NEAR_MISS, ELSEWHERE: any other failure, up to or beyond the near-miss distance from the answer.
    """

    SUCCESS = "success"
    ABSTAIN = "abstain"
    ELSEWHERE = "elsewhere"
    NEAR_MISS = "near_miss"
    WRONG_INSTANCE = "wrong_instance"


def judge_failure(outcome: Outcome, radius_m: float, near_miss_m: float) -> Verdict:
    """Return the verdict on one realised prediction; `radius_m` is R."""
    if outcome.success:
        return Verdict.SUCCESS
    if outcome.distance_m is None:
        return Verdict.ABSTAIN
    # A point next to another instance is explained by it, however near the answer is.
    if outcome.other_m is not None and outcome.other_m <= radius_m:
        return Verdict.WRONG_INSTANCE
    return Verdict.NEAR_MISS if outcome.distance_m <= near_miss_m else Verdict.ELSEWHERE


def taxonomy(static: Sequence[Outcome], navigations: Iterable[Row], radius_m: float, near_miss_m: float) -> list[Row]:
    """Count the verdicts of every realised static arm by relation, then what navigation lost (Table taxonomy).

    `seed` is the run of an arm with several runs, or the seed of the embodied arm that lost successes.
    """
    lost = [row for row in navigations if row["lost"] is not None]
    rows: list[Row] = []
    for arm, outcomes in group_by(static, "arm").items():
        if any(map(is_expectation, outcomes)):
            continue
        runs = group_by(outcomes, "seed")
        for seed, run in runs.items():
            counts = {
                relation: Counter(judge_failure(one, radius_m, near_miss_m) for one in group)
                for relation, group in group_by(run, "relation").items()
            }
            of_run = {"arm": arm, "embodied": None, "seed": seed if len(runs) > 1 else None}
            rows += [
                of_run | {"verdict": verdict, "relation": relation, "episodes": count[verdict], "n": count.total()}
                for verdict in Verdict
                for relation, count in counts.items()
            ]
        of_arm = (row for row in lost if row["executes"] == arm)
        rows += [row | {"arm": arm, "verdict": LOST, "episodes": row["lost"], "embodied": row["arm"]} for row in of_arm]
    return rows


def budget(rates: Iterable[Rate], comparisons: Iterable[Comparison], rungs: Mapping[str, str]) -> list[Row]:
    """Compute the error budget: the rate of each rung, and its gain over the rung below (the paper's Fig. diag a).

    rungs: titles by arm, from the lowest; comparisons: has a test of each rung against the rung below. If the rates of one rung
    are missing, the budget is empty.
    """
    by_rung = {(rate.arm, rate.relation): rate for rate in rates}
    if not rungs or not rungs.keys() <= {arm for arm, _ in by_rung}:
        return []
    tests = {(row.arm, row.baseline, row.relation): row for row in comparisons}
    rows: list[Row] = []
    for lower, arm in pairwise([None, *rungs]):
        for (of, relation), rate in by_rung.items():
            if of != arm:
                continue
            row = {**asdict(rate), "rung": rungs[arm], "successes": round(rate.successes)}
            row |= dict.fromkeys(("gain", "gained", "lost", "p"))
            if lower is not None:
                test = tests[arm, lower, relation]
                gain = rate.rate - by_rung[lower, relation].rate
                row |= {"gain": gain, "gained": round(test.wins), "lost": round(test.losses), "p": test.p}
            rows.append(row)
    return rows + [_answer_given(row) for row in rows if row["arm"] == arm]


def _answer_given(below: Row) -> Row:
    missing = below["n"] - below["successes"]
    row = {"rung": ANSWER_GIVEN, "arm": None, "successes": below["n"], "rate": 1.0, "low": None, "high": None}
    return below | row | {"gain": 1.0 - below["rate"], "gained": missing, "lost": 0, "p": mcnemar_exact(missing, 0)}


def readings(static: Sequence[Outcome], arms: Mapping[str, Arm], maps: Mapping[str, str], confidence: float) -> list[Row]:
    """Compare each reading of oracle grounding, and oracle positions, with an arm's own grounding.

    maps: the map that each arm reads, in the order of the table; a map's first arm is its baseline. gained, lost, p: against that
    arm; None for it, an expectation, or an arm of several runs.
    """
    of_arm = group_by(static, "arm")
    first: dict[str, str] = {}
    rows = []
    for name, title in maps.items():
        baseline = first.setdefault(title, name) if name in of_arm else name
        for relation, group in group_by(of_arm.get(name, ()), "relation").items():
            (rate,) = rates(group, ("arm",), confidence)
            against = (None, None, None) if baseline == name else _count_changes(group, of_arm[baseline])
            rows.append(
                {
                    "map": title,
                    "grounding": name_grounding(arms[name]),
                    **rate,
                    "relation": relation,
                    **dict(zip(("gained", "lost", "p"), against, strict=True)),
                }
            )
    return rows


def name_grounding(arm: Arm) -> str:
    """Return OWN, the reading of an arm's oracle grounding, or POSITIONS."""
    if arm.positions is Source.HANDED:
        return POSITIONS
    return str(arm.reading) if arm.grounding is Source.HANDED else OWN


def _count_changes(group: Sequence[Outcome], baseline: Sequence[Outcome]) -> tuple[int, int, float] | tuple[None, None, None]:
    if any(map(is_expectation, (*group, *baseline))) or max(len(group_by(some, "seed")) for some in (group, baseline)) > 1:
        return None, None, None
    was = {outcome.episode: outcome.success for outcome in baseline}
    return compare_paired([outcome.success for outcome in group], [was[outcome.episode] for outcome in group])

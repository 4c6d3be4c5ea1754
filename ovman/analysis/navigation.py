"""Runs of embodied arms: what executing an answer costs and gains, an agent's own task, and how far movers go meanwhile."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from statistics import median

from ovman import seeds
from ovman.analysis.outcomes import Outcome, group_by, groups, is_expectation
from ovman.analysis.rows import Row
from ovman.analysis.statistics import compare_paired
from ovman.records.episode import Episode
from ovman.records.task import displacement_m
from ovman.settings import Arm
from ovman.sim.world import Mover, walk

NAVIGATION = "arm seed relation n successes sr spl spl_given_success executes static_successes lost gained p"
RESCUED = "arm executes seed relation n gained rescued nearest_m farthest_m"
OWN_TASK = "arm seed relation n own_successes own_rate successes rate gap only_own only_here p"
MOVER = "phase actions n least_m median_m greatest_m radius_m within moved"
BETWEEN_VISITS = "between the visits"
WHILE_ACTING = "while an agent acts"
AFTER = (0, 10, 20, 40, 80, 160)
"""Numbers of agent actions after which the distance of a mover is measured."""
WALKS = 20
"""Simulated walks of each episode's mover."""


def navigation(static: Sequence[Outcome], embodied: Sequence[Outcome], arms: Mapping[str, Arm], radius_m: float) -> list[Row]:
    """Compare every embodied arm under every seed with the static arm whose answers it executes, if any.

    lost: static successes that fail when executed; gained: static failures that succeed, because the stop test also accepts a
    stop near the target's box or the navigable cell. Both are None if the arm executes nothing or a stochastic pick. rescued: the
    gained that stop within R of the target's box; nearest_m, farthest_m: from the predicted point to the answer, among these.

    Raises:
        ValueError: A static arm that is executed has answers under several seeds.
    """
    executed = _executed(static, arms)
    rows: list[Row] = []
    for (arm, seed, relation), runs in groups(embodied, "arm", "seed", "relation").items():
        answers = [executed[arm][run.episode] for run in runs] if arm in executed else []
        successful = [run.spl or 0.0 for run in runs if run.success]
        n = len(runs)
        row: Row = {"arm": arm, "seed": seed, "relation": relation, "n": n, "successes": len(successful)}
        row |= {"sr": len(successful) / n, "spl": math.fsum(run.spl or 0.0 for run in runs) / n}
        row |= {"spl_given_success": math.fsum(successful) / len(successful) if successful else None}
        row |= {"executes": arms[arm].executes, "static_successes": None}
        row |= dict.fromkeys(("lost", "gained", "p"))
        if answers:
            row["static_successes"] = math.fsum(answer.success for answer in answers)
        if answers and not any(map(is_expectation, answers)):
            gained, lost, p = compare_paired((run.success for run in runs), (answer.success for answer in answers))
            near_box = [
                answer.distance_m
                for run, answer in zip(runs, answers, strict=True)
                if run.success and not answer.success and run.box_distance_m is not None and run.box_distance_m <= radius_m
            ]
            metres = [distance for distance in near_box if distance is not None]
            row |= {"lost": lost, "gained": gained, "p": p, "rescued": len(near_box)}
            row |= {"nearest_m": min(metres, default=None), "farthest_m": max(metres, default=None)}
        rows.append(row)
    return rows


def rescued(navigations: Iterable[Row]) -> list[Row]:
    """Return the rows of `navigation` of arms that execute realised answers."""
    return [row for row in navigations if row["lost"] is not None]


def _executed(static: Sequence[Outcome], arms: Mapping[str, Arm]) -> dict[str, dict[str, Outcome]]:
    """Return the outcomes of the answers that embodied arms execute, by embodied arm and episode."""
    answers = group_by(static, "arm")
    found = {}
    for name, arm in arms.items():
        outcomes = answers.get(arm.executes or "", [])
        if len(group_by(outcomes, "seed")) > 1:
            raise ValueError(f"{arm.executes} has answers under several seeds; {name} can execute one answer per episode")
        if outcomes:
            found[name] = {outcome.episode: outcome for outcome in outcomes}
    return found


def own_task(embodied: Sequence[Outcome]) -> list[Row]:
    """Compare the success of runs on the task that their agent was made for with that on this task.

    CoW is made to reach any instance of a category. Here it must reach the instance that the relation selects.

    Raises:
        ValueError: Some runs of an arm were judged on its own task and others were not.
    """
    judged = []
    for arm, runs in group_by(embodied, "arm").items():
        having = [run for run in runs if run.own_success is not None]
        if having and len(having) < len(runs):
            raise ValueError(f"{arm}: {len(runs) - len(having)} of {len(runs)} runs lack a verdict on its own task; judge again")
        judged += having
    rows: list[Row] = []
    for (arm, seed, relation), runs in groups(judged, "arm", "seed", "relation").items():
        owns, heres = [bool(run.own_success) for run in runs], [bool(run.success) for run in runs]
        n, own, here = len(runs), sum(owns), sum(heres)
        only_own, only_here, p = compare_paired(owns, heres)
        row = {"arm": arm, "seed": seed, "relation": relation, "n": n, "own_successes": own, "own_rate": own / n}
        row |= {"successes": here, "rate": here / n, "gap": (own - here) / n}
        rows.append(row | {"only_own": only_own, "only_here": only_here, "p": p})
    return rows


def mover_distances(episodes: Sequence[Episode], radius_m: float, moved_m: float) -> list[Row]:
    """Measure how far the movers of MOVING episodes go: between the visits, and from the end of visit 2 while an agent acts.

    The walks after visit 2 are simulated from the episode, WALKS for each, with no agent in the way. within: the share of
    distances up to `radius_m`; moved: episodes whose displacement is at least `moved_m`, the threshold of Eq. 1.
    """
    moving = [episode for episode in episodes if episode.target in {one.instance for one in episode.movers}]
    if not moving:
        return []
    displacements = [displacement_m(episode.world_1, episode.world_2, episode.target) for episode in moving]
    between = [metres for metres in displacements if metres is not None]
    walks = [distances for episode in moving for distances in _walked_m(episode)]
    return [
        _distance_row(BETWEEN_VISITS, None, between, radius_m, sum(metres >= moved_m for metres in between)),
        *(_distance_row(WHILE_ACTING, actions, [one[k] for one in walks], radius_m, None) for k, actions in enumerate(AFTER)),
    ]


def _walked_m(episode: Episode) -> list[list[float]]:
    """Return the distances from the recorded end point after each number of AFTER, walk by walk."""
    (start,) = (one for one in episode.movers if one.instance == episode.target)
    roam = next(one.roam for one in episode.changes if one.instance == episode.target and one.roam is not None)
    begun = Mover(roam).resumed(start)
    found = []
    for number in range(WALKS):
        rng = seeds.generator(episode.provenance.seed, "mover", episode.id, "distance", number)
        path = [begun, *walk(begun, episode.protocol.mover, rng, AFTER[-1])]
        found.append([math.dist(path[actions].position, begun.position) for actions in AFTER])
    return found


def _distance_row(phase: str, actions: int | None, metres: Sequence[float], radius_m: float, moved: int | None) -> Row:
    within = sum(one <= radius_m for one in metres) / len(metres)
    values = (phase, actions, len(metres), min(metres), median(metres), max(metres), radius_m, within, moved)
    return dict(zip(MOVER.split(), values, strict=True))

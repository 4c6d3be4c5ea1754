"""How far the movers of MOVING episodes go: between the visits, and from where they were last recorded while an agent acts.

The walk after the second visit is simulated from the episode alone, with no agent in the way, for each of WALKS seeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from ovman import seeds
from ovman.records.episode import Episode
from ovman.records.scene import Roam
from ovman.sim.world import Mover, walk
from ovman.task import displacement_m

BETWEEN_VISITS = "between the visits"
WHILE_ACTING = "while an agent acts"
AFTER = (0, 10, 20, 40, 80, 160)
"""Numbers of agent actions after which a mover is looked at."""
WALKS = 20
"""Walks of each episode's mover."""


@dataclass(frozen=True, slots=True)
class MoverDistance:
    """Distances of movers, metres: from where they stood in visit 1 to where visit 2 ended (actions is None), or from there to
    where they are after so many agent actions.

    n: episodes, or episodes times walks; within: share of the distances that are at most `radius_m`; moved: episodes whose target
    also satisfies MOVED, None for the distances while an agent acts.
    """

    phase: str
    actions: int | None
    n: int
    least_m: float
    median_m: float
    greatest_m: float
    radius_m: float
    within: float
    moved: int | None


def mover(episodes: Sequence[Episode], radius_m: float, moved_m: float) -> list[MoverDistance]:
    """One row between the visits, one for each number of actions of AFTER; none without a MOVING episode.

    radius_m: R; moved_m: the displacement from which Eq. 1 calls an instance moved.
    """
    moving = [episode for episode in episodes if episode.target in {one.instance for one in episode.movers}]
    if not moving:
        return []
    between = [displacement_m(episode.world_1, episode.world_2, episode.target) for episode in moving]
    there = [metres for metres in between if metres is not None]
    away = [distances for episode in moving for distances in _away_m(episode)]
    return [
        _row(BETWEEN_VISITS, None, there, radius_m, sum(metres >= moved_m for metres in there)),
        *(_row(WHILE_ACTING, actions, [one[k] for one in away], radius_m, None) for k, actions in enumerate(AFTER)),
    ]


def _away_m(episode: Episode) -> list[list[float]]:
    """Distances to the recorded end point after each number of AFTER, walk by walk."""
    (start,) = (one for one in episode.movers if one.instance == episode.target)
    begun = Mover(_roam(episode)).resumed(start)
    found = []
    for number in range(WALKS):
        rng = seeds.generator(episode.provenance.seed, "mover", episode.id, "distance", number)
        path = [begun, *walk(begun, episode.protocol.mover, rng, AFTER[-1])]
        found.append([math.dist(path[actions].position, begun.position) for actions in AFTER])
    return found


def _roam(episode: Episode) -> Roam:
    return next(one.roam for one in episode.changes if one.instance == episode.target and one.roam is not None)


def _row(phase: str, actions: int | None, metres: Sequence[float], radius_m: float, moved: int | None) -> MoverDistance:
    return MoverDistance(
        phase=phase,
        actions=actions,
        n=len(metres),
        least_m=min(metres),
        median_m=median(metres),
        greatest_m=max(metres),
        radius_m=radius_m,
        within=sum(one <= radius_m for one in metres) / len(metres),
        moved=moved,
    )

"""The ideal observer, a diagnostic: true masks, places and looks, and no identity across visits.

Of each visit it knows the instances of the queried category: where each was recorded, and a *look* that instances of one asset
share. It matches the instances of both visits one to one. If its success is below 1, looks and places do not decide every query.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Abstention, AbstentionReason, Answer, PredictionContext, Query, Relation, UniformPick
from ovman.homes.catalogue import looks_different

Place = tuple[float, float]
FAR_M = 1000.0
"""Metres that a pair counts more whose members are not at one place: an instance that stayed is never taken for another's."""


@dataclass(frozen=True, slots=True)
class Seen:
    """An instance in one visit. track: its recorded places (x, z) in the order of the tour, metres."""

    look: str
    track: tuple[Place, ...]

    @property
    def at(self) -> Place:
        """Where it was recorded last."""
        return self.track[-1]

    @property
    def spread_m(self) -> float:
        """Largest distance between two of its recorded places."""
        return max((math.dist(a, b) for a in self.track for b in self.track), default=0.0)


def predict(query: Query, context: PredictionContext) -> tuple[Answer | UniformPick | Abstention, None]:
    """Answer as the static arm ideal_observer. Reads admissibility.{tau_m,motion_m}."""
    looks, limits = context.looks, context.settings.admissibility
    visits: list[list[Seen]] = []
    for which in ("first", "second"):
        instances = context.world(which).category(query.category)
        # Sorted by what is seen: neither ids nor their order say which instance is which.
        visits.append(sorted((Seen(looks[one.id], one.track) for one in instances), key=lambda seen: (seen.track, seen.look)))
    places = find_places(Relation(query.relation), visits[0], visits[1], limits.tau_m, limits.motion_m)
    if len(places) == 1:
        return Answer(*places[0]), None
    return (UniformPick(tuple(places)) if places else Abstention(AbstentionReason.NO_CANDIDATE)), None


def find_places(relation: Relation, first: Sequence[Seen], second: Sequence[Seen], tau_m: float, motion_m: float) -> list[Place]:
    """Return the places that answer a relation: one where looks and places decide, several where they leave a choice.

    MOVING: the instance whose places spread farthest, and by more than `motion_m`. It answers no other relation, unless nothing
    else does. MOVED and FORMER: pairs of one look, at least `tau_m` apart. STABLE: pairs at one place. APPEARED and REMOVED: what
    the other visit has no counterpart of. If nothing came or went, a moved instance stands for it, and the reverse.
    """
    mover = max(range(len(second)), key=lambda j: second[j].spread_m, default=-1)
    if mover >= 0 and second[mover].spread_m <= motion_m:
        mover = -1
    if relation is Relation.MOVING:
        return [second[mover].at] if mover >= 0 else []
    pairs = match(first, second, tau_m)
    near, far = ([(i, j) for i, j in pairs if (_distance(first[i], second[j]) >= tau_m) is apart] for apart in (False, True))
    near, far = ([pair for pair in some if pair[1] != mover] or some for some in (near, far))
    gone = [one.at for i, one in enumerate(first) if i not in {i for i, _ in pairs}]
    come = [one.at for j, one in enumerate(second) if j not in {j for _, j in pairs}]
    left, taken = [first[i].at for i, _ in far], [second[j].at for _, j in far]
    return {
        Relation.MOVED: taken or come,
        Relation.FORMER: left or gone,
        Relation.STABLE: [second[j].at for _, j in near],
        Relation.APPEARED: come or taken,
        Relation.REMOVED: gone or left,
    }[relation]


def match(
    first: Sequence[Seen], second: Sequence[Seen], tau_m: float, differ: Callable[[str, str], bool] = looks_different
) -> list[tuple[int, int]]:
    """Return the pairs of instances (i, j) of one look, one to one: as many as can be, then as many at one place.

    differ: whether two looks can be told apart. Two assets that look alike count as one look, but an equal one is preferred.
    """
    from scipy.optimize import linear_sum_assignment

    forbidden = FAR_M * (len(first) + len(second) + 1) * 10
    cost = np.full((len(first), len(second)), forbidden)
    for i, before in enumerate(first):
        for j, after in enumerate(second):
            if not differ(before.look, after.look):
                metres = _distance(before, after)
                cost[i, j] = metres + FAR_M * (metres >= tau_m) + FAR_M / 2 * (before.look != after.look)
    rows, columns = linear_sum_assignment(cost)
    return [(i, j) for i, j in zip(rows.tolist(), columns.tolist(), strict=True) if cost[i, j] < forbidden]


def _distance(before: Seen, after: Seen) -> float:
    """Return the metres between the last place of the first visit and that of the second, as Eq. 1 measures a displacement."""
    return math.dist(before.at, after.at)

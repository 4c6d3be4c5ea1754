"""What an arm drew its answer from, as the page shows it: its objects of both visits, what it grounded, whom it took for whom.

Arms with maps of their own record their evidence. The evidence of the arm that is handed positions is drawn again here from the
recorded sightings, by the agent's own functions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS
from ovman.agents.reference.association import associate, cost_matrix, distances
from ovman.agents.reference.grounding import similarities
from ovman.evaluation.prediction import Prediction
from ovman.models.settings import Arm, Source, named
from ovman.perception.clusters import Cluster
from ovman.report.show.results import MAKE, Results, ShowError
from ovman.sim.recorded import world_state

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Item:
    """An object of a visit as an arm has it. id: its index in the map of the visit, or among the handed instances.

    at: (x, z), metres; sightings: how often it was detected; similarity: to the noun, None where there are no features;
    track: where it was seen, in order; views: in which views; nearest_m: distance to the nearest grounded object of the other
    visit, None where there is none or the object is not grounded.
    """

    id: int
    at: Point
    sightings: int
    similarity: float | None
    grounded: bool
    track: tuple[Point, ...]
    views: tuple[int, ...]
    nearest_m: float | None = None


@dataclass(frozen=True, slots=True)
class MatchedPair:
    """An object of the first and one of the second visit, by id, taken for the same: Eq. cost in metres, and its first term."""

    first: int
    second: int
    cost_m: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class Reasoning:
    """arm: whose. looked: whether the arm looks at the first visit at all; items: of both visits, each sorted by id."""

    arm: str
    title: str
    items: tuple[tuple[Item, ...], tuple[Item, ...]]
    pairs: tuple[MatchedPair, ...]
    looked: bool = True

    def grounded(self, visit: int) -> tuple[Item, ...]:
        return tuple(item for item in self.items[visit] if item.grounded)

    def unmatched(self, visit: int) -> tuple[Item, ...]:
        """The grounded objects of a visit (0 or 1) that are in no pair."""
        matched = {(pair.first, pair.second)[visit] for pair in self.pairs}
        return tuple(item for item in self.grounded(visit) if item.id not in matched)


def reasonings(results: Results, episode: Mapping[str, Any], settings: Any) -> list[Reasoning]:
    """The two-visit arms' evidence, own maps first, as far as the results have it."""
    found = []
    # These arms answer once.
    predictions = {arm: next(iter(runs.values())) for arm, runs in results.predictions(episode["id"]).items()}
    maps = [results.map(episode, which) for which in VISITS]
    if all(clusters is not None for clusters in maps):
        noun = results.nouns.get(episode["noun"])
        for arm in ("two_visits", "grounding_two_visits"):
            if arm in predictions and predictions[arm].evidence is not None:
                found.append(of_maps(named(results.arms, arm), maps, predictions[arm], noun, settings))
    trial = results.trial(episode)
    if trial is not None and "positions_two_visits" in predictions:
        found.append(of_positions(named(results.arms, "positions_two_visits"), trial, settings))
    return found


def of_maps(
    arm: Arm, maps: Sequence[Sequence[Cluster]], prediction: Prediction, noun: np.ndarray | None, settings: Any
) -> Reasoning:
    """From an agent's maps of both visits and the evidence that its prediction records.

    ShowError where the evidence names objects that the maps do not have.
    """
    evidence = prediction.evidence
    chosen = [set(evidence.grounded_1 or ()), set(evidence.grounded_2)]
    if any(i >= len(clusters) for indices, clusters in zip(chosen, maps, strict=True) for i in indices):
        raise ShowError(
            f"{prediction.episode}: the prediction of {arm.name} was made from other maps than these; `{MAKE}` makes both"
        )
    scores = [None if noun is None else similarities([c.feature for c in clusters], noun) for clusters in maps]
    nearest = _nearest([{i: maps[v][i].position for i in sorted(chosen[v])} for v in (0, 1)])
    items = tuple(
        tuple(
            Item(
                id=i,
                at=_point(cluster.position),
                sightings=len(cluster.track),
                similarity=None if scores[v] is None else float(scores[v][i]),
                grounded=i in chosen[v],
                track=tuple(map(_point, cluster.track)),
                views=tuple(int(view) for view in cluster.views),
                nearest_m=nearest[v].get(i),
            )
            for i, cluster in enumerate(clusters)
        )
        for v, clusters in enumerate(maps)
    )
    pairs = []
    for i, j in evidence.pairs:
        one, other = maps[0][i], maps[1][j]
        cost = cost_matrix(
            one.position[None],
            other.position[None],
            one.feature[None],
            other.feature[None],
            feature_scale_m=settings.association.feature_scale_m,
        )
        pairs.append(MatchedPair(i, j, float(cost[0, 0]), float(np.hypot(*(one.position - other.position)))))
    return Reasoning(arm.name, _title(arm), items, tuple(pairs), evidence.grounded_1 is not None)


def of_positions(arm: Arm, trial: Mapping[str, Any], settings: Any) -> Reasoning:
    """From the sightings that the arm was handed: every recorded instance of the category is an object, and all are grounded."""
    candidate, measured = trial["candidate"], trial["measured"]
    worlds = [
        world_state(measured["sightings"][which], candidate["category"], settings.admissibility.min_mask_px) for which in VISITS
    ]
    seen = [sorted(world.category(candidate["category"]), key=lambda k: (k.x, k.z)) for world in worlds]
    p = [np.array([(k.x, k.z) for k in instances], dtype=float).reshape(-1, 2) for instances in seen]
    matched = associate(*p, gate_m=settings.association.gate_m, feature_scale_m=settings.association.feature_scale_m)
    nearest = _nearest([dict(enumerate(points)) for points in p])
    items = tuple(
        tuple(
            Item(
                id=i,
                at=(k.x, k.z),
                sightings=len(k.track),
                similarity=None,
                grounded=True,
                track=tuple(k.track),
                views=_views(measured["sightings"][VISITS[v]], k.id, settings.admissibility.min_mask_px),
                nearest_m=nearest[v].get(i),
            )
            for i, k in enumerate(instances)
        )
        for v, instances in enumerate(seen)
    )
    gap = distances(*p)
    return Reasoning(
        arm.name, _title(arm), items, tuple(MatchedPair(i, j, float(gap[i, j]), float(gap[i, j])) for i, j in matched.pairs)
    )


def _views(sightings: Sequence[Mapping[str, Any]], instance: str, min_mask_px: int) -> tuple[int, ...]:
    return tuple(seen["view"] for seen in sightings if seen["instance"] == instance and seen["px"] >= min_mask_px)


def _nearest(points: Sequence[Mapping[int, np.ndarray]]) -> list[dict[int, float]]:
    """For both visits: the distance of each object to the nearest of the other visit; nothing where that visit has none."""
    near: list[dict[int, float]] = [{}, {}]
    if points[0] and points[1]:
        gap = distances(np.array(list(points[0].values())), np.array(list(points[1].values())))
        near[0] = dict(zip(points[0], gap.min(axis=1).tolist(), strict=True))
        near[1] = dict(zip(points[1], gap.min(axis=0).tolist(), strict=True))
    return near


def _title(arm: Arm) -> str:
    if arm.positions is Source.HANDED:
        return "positions handed over"
    return f"own maps, {'grounding handed over' if arm.grounding is Source.HANDED else 'own grounding'}"


def _point(pair: Any) -> Point:
    return float(pair[0]), float(pair[1])

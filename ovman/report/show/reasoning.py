"""The evidence of an arm as the page shows it: its objects of both visits, the grounded ones, and their association.

Arms with maps of their own record their evidence. The evidence of an arm that is handed positions is computed again here from
the recorded sightings, by the agent's own functions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ovman.agents.interface import VISITS
from ovman.agents.reference.association import associate, cost_matrix, distances
from ovman.agents.reference.reasoning import similarities
from ovman.perception.clusters import Cluster
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import Prediction
from ovman.records.visit import Sighting, Sightings
from ovman.report.show.results import MAKE, Results, ShowError
from ovman.settings import Arm, Kind, Need, Settings, Source, of_kind
from ovman.settings.arms import other_readings
from ovman.task import recorded_world


@dataclass(frozen=True, slots=True)
class Item:
    """An object of a visit as an arm has it. id: its index in the map of the visit, or among the handed instances.

    at: (x, z), metres; sightings: number of detections; similarity: to the noun, None without features; track: positions of the
    detections, in order; views: of the detections; nearest_m: distance to the nearest grounded object of the other visit, None
    without one or if the object itself is not grounded.
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
    """Matched objects of the first and of the second visit, by id. cost_m: Eq. cost in metres; distance_m: its first term."""

    first: int
    second: int
    cost_m: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class Reasoning:
    """The evidence of an arm for one episode.

    items: of both visits, each sorted by id; own_maps: False for an arm that is handed positions; looked: whether the arm uses
    the first visit.
    """

    arm: str
    title: str
    items: tuple[tuple[Item, ...], tuple[Item, ...]]
    pairs: tuple[MatchedPair, ...]
    own_maps: bool
    looked: bool = True

    def grounded(self, visit: int) -> tuple[Item, ...]:
        """The grounded objects of a visit (0 or 1)."""
        return tuple(item for item in self.items[visit] if item.grounded)

    def unmatched(self, visit: int) -> tuple[Item, ...]:
        """The grounded objects of a visit (0 or 1) that are in no pair."""
        matched = {(pair.first, pair.second)[visit] for pair in self.pairs}
        return tuple(item for item in self.grounded(visit) if item.id not in matched)


def reasonings(results: Results, episode: Episode, settings: Settings) -> list[Reasoning]:
    """The evidence of the arms that associate both visits, own maps first, as far as the results have it.

    Arms that pick at random (`expected`) associate nothing, and one from which something is withheld is asked another question
    than the page's. The others record their evidence or are handed positions. Of the
    readings of what is handed over one is shown.
    """
    found = []
    predictions = {arm: next(iter(runs.values())) for arm, runs in results.predictions(episode.id).items()}
    left = other_readings(results.arms)
    static = [arm for arm in of_kind(results.arms, Kind.STATIC) if arm.name not in left]
    arms = [arm for arm in static if arm.name in predictions and not arm.expected and arm.withheld is None]
    maps = [clusters for which in VISITS if (clusters := results.map(episode, which)) is not None]
    if len(maps) == len(VISITS):
        noun = results.nouns.get(episode.noun)
        for arm in arms:
            prediction = predictions[arm.name]
            if Need.MAPS in arm.needs and prediction.evidence is not None:
                found.append(of_maps(arm, maps, prediction, noun, settings))
    sightings = results.sightings(episode)
    if sightings is not None:
        handed = [arm for arm in arms if arm.positions is Source.HANDED]
        found += [of_positions(arm, episode, sightings, settings) for arm in handed]
    titles = Counter(one.title for one in found)
    return [one if titles[one.title] == 1 else replace(one, title=f"{one.title} ({one.arm})") for one in found]


def of_maps(
    arm: Arm, maps: Sequence[Sequence[Cluster]], prediction: Prediction, noun: np.ndarray | None, settings: Settings
) -> Reasoning:
    """From an agent's maps of both visits and the evidence that its prediction records.

    ShowError if the evidence names objects that the maps do not have. ValueError for a prediction without evidence.
    """
    evidence = prediction.evidence
    if evidence is None:
        raise ValueError(f"{prediction.episode}: the prediction of {arm.name} has no evidence")
    chosen = [set(evidence.grounded_1 or ()), set(evidence.grounded_2)]
    if any(i >= len(clusters) for indices, clusters in zip(chosen, maps, strict=True) for i in indices):
        raise ShowError(
            f"{prediction.episode}: the prediction of {arm.name} was made from other maps than these; `{MAKE}` makes both"
        )
    scores: list[list[float | None]] = [
        [None] * len(clusters) if noun is None else similarities([c.feature for c in clusters], noun).tolist()
        for clusters in maps
    ]
    nearest = _nearest([{i: maps[v][i].position for i in sorted(chosen[v])} for v in (0, 1)])
    items = [
        tuple(
            Item(
                id=i,
                at=_point(cluster.position),
                sightings=len(cluster.track),
                similarity=scores[v][i],
                grounded=i in chosen[v],
                track=tuple(map(_point, cluster.track)),
                views=tuple(int(view) for view in cluster.views),
                nearest_m=nearest[v].get(i),
            )
            for i, cluster in enumerate(clusters)
        )
        for v, clusters in enumerate(maps)
    ]
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
    return Reasoning(arm.name, _title(arm), (items[0], items[1]), tuple(pairs), True, evidence.grounded_1 is not None)


def of_positions(arm: Arm, episode: Episode, sightings: Sightings, settings: Settings) -> Reasoning:
    """From the handed sightings: every recorded instance of the category is an object, and all are grounded."""
    category, min_mask_px = episode.category, settings.admissibility.min_mask_px
    worlds = [recorded_world(sightings.sightings[which], category, min_mask_px) for which in VISITS]
    seen = [sorted(world.category(category), key=lambda k: (k.x, k.z)) for world in worlds]
    p = [np.array([(k.x, k.z) for k in instances], dtype=float).reshape(-1, 2) for instances in seen]
    matched = associate(*p, gate_m=settings.association.gate_m, feature_scale_m=settings.association.feature_scale_m)
    nearest = _nearest([dict(enumerate(points)) for points in p])
    items = [
        tuple(
            Item(
                id=i,
                at=(k.x, k.z),
                sightings=len(k.track),
                similarity=None,
                grounded=True,
                track=tuple(k.track),
                views=_views(sightings.sightings[VISITS[v]], k.id, min_mask_px),
                nearest_m=nearest[v].get(i),
            )
            for i, k in enumerate(instances)
        )
        for v, instances in enumerate(seen)
    ]
    gap = distances(*p)
    pairs = tuple(MatchedPair(i, j, float(gap[i, j]), float(gap[i, j])) for i, j in matched.pairs)
    return Reasoning(arm.name, _title(arm), (items[0], items[1]), pairs, own_maps=False)


def _views(sightings: Sequence[Sighting], instance: str, min_mask_px: int) -> tuple[int, ...]:
    return tuple(seen.view for seen in sightings if seen.instance == instance and seen.px >= min_mask_px)


def _nearest(points: Sequence[Mapping[int, np.ndarray]]) -> list[dict[int, float]]:
    """For both visits: the distance of each object to the nearest one of the other visit; empty if that visit has none."""
    near: list[dict[int, float]] = [{}, {}]
    if points[0] and points[1]:
        gap = distances(np.array(list(points[0].values())), np.array(list(points[1].values())))
        near[0] = dict(zip(points[0], gap.min(axis=1).tolist(), strict=True))
        near[1] = dict(zip(points[1], gap.min(axis=0).tolist(), strict=True))
    return near


def _title(arm: Arm) -> str:
    if arm.positions is Source.HANDED:
        return "oracle positions"
    return f"own maps, {'oracle grounding' if arm.grounding is Source.HANDED else 'own grounding'}"


def _point(pair: np.ndarray) -> Point:
    return float(pair[0]), float(pair[1])

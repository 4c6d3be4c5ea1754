"""Collect the evidence of the arms: their objects of both visits, the grounded ones, and the association.

Arms with maps of their own record their evidence. For an arm with oracle positions the agent's own functions compute it again
from the recorded sightings.
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
from ovman.records.visit import Sightings
from ovman.report.show.results import MAKE, Results, ShowError
from ovman.settings import Arm, Kind, Need, Settings, Source, of_kind
from ovman.settings.arms import other_readings
from ovman.task import recorded_world


@dataclass(frozen=True, slots=True)
class Item:
    """An object of a visit as an arm has it.

    Attributes:
        id: Its index in the map of the visit, or among the instances of the category.
        at: (x, z), metres.
        sightings: Number of detections.
        similarity: To the noun, None without features.
        grounded: Whether the arm takes it for the category.
        track: Positions of the detections, in order.
        views: Views of the detections.
        nearest_m: Distance to the nearest grounded object of the other visit; None without one, or if not grounded itself.
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
    """The evidence of an arm for one episode. items: of both visits; own_maps: False for an arm with oracle positions."""

    arm: str
    title: str
    items: tuple[tuple[Item, ...], tuple[Item, ...]]
    pairs: tuple[MatchedPair, ...]
    own_maps: bool

    def grounded(self, visit: int) -> tuple[Item, ...]:
        """Return the grounded objects of a visit (0 or 1)."""
        return tuple(item for item in self.items[visit] if item.grounded)

    def unmatched(self, visit: int) -> tuple[Item, ...]:
        """Return the grounded objects of a visit (0 or 1) that are in no pair."""
        matched = {(pair.first, pair.second)[visit] for pair in self.pairs}
        return tuple(item for item in self.grounded(visit) if item.id not in matched)


def collect_reasonings(results: Results, episode: Episode, settings: Settings) -> list[Reasoning]:
    """Return the evidence of the arms that associate both visits, own maps first, as far as the results have it.

    Arms that pick at random associate nothing. An arm with an ablated input is asked another question than the page's. Of several
    readings of oracle grounding one is shown.
    """
    predictions = {arm: next(iter(runs.values())) for arm, runs in results.predictions(episode).items()}
    others = other_readings(results.arms)
    arms = [
        arm
        for arm in of_kind(results.arms, Kind.STATIC)
        if arm.name in predictions and arm.name not in others and not arm.expected and arm.withheld is None
    ]
    found = []
    maps = [clusters for which in VISITS if (clusters := results.map(episode, which)) is not None]
    if len(maps) == len(VISITS):
        noun = results.nouns.get(episode.noun)
        for arm in arms:
            if Need.MAPS in arm.needs and predictions[arm.name].evidence is not None:
                found.append(read_maps(arm, maps, predictions[arm.name], noun, settings))
    sightings = results.sightings(episode)
    if sightings is not None:
        with_positions = [arm for arm in arms if arm.positions is Source.HANDED]
        found += [read_positions(arm, episode, sightings, settings) for arm in with_positions]
    titles = Counter(one.title for one in found)
    return [one if titles[one.title] == 1 else replace(one, title=f"{one.title} ({one.arm})") for one in found]


def read_maps(
    arm: Arm, maps: Sequence[Sequence[Cluster]], prediction: Prediction, noun: np.ndarray | None, settings: Settings
) -> Reasoning:
    """Return the evidence that a prediction records, about an agent's maps of both visits.

    Raises:
        ShowError: The evidence names objects that the maps do not have.
    """
    evidence = prediction.evidence
    assert evidence is not None
    chosen = [set(evidence.grounded_1 or ()), set(evidence.grounded_2)]
    if any(i >= len(clusters) for indices, clusters in zip(chosen, maps, strict=True) for i in indices):
        other = f"the prediction of {arm.name} was made from other maps than these"
        raise ShowError(f"{prediction.episode}: {other}; `{MAKE}` makes both")
    nearest = _measure_gaps([{i: clusters[i].position for i in sorted(of)} for of, clusters in zip(chosen, maps, strict=True)])

    def items(visit: int) -> tuple[Item, ...]:
        features = [cluster.feature for cluster in maps[visit]]
        scores = [None] * len(features) if noun is None else similarities(features, noun).tolist()
        return tuple(
            Item(
                id=i,
                at=_point(cluster.position),
                sightings=len(cluster.track),
                similarity=scores[i],
                grounded=i in chosen[visit],
                track=tuple(map(_point, cluster.track)),
                views=tuple(int(view) for view in cluster.views),
                nearest_m=nearest[visit].get(i),
            )
            for i, cluster in enumerate(maps[visit])
        )

    pairs = []
    for i, j in evidence.pairs:
        one, other_one = maps[0][i], maps[1][j]
        ends = one.position[None], other_one.position[None], one.feature[None], other_one.feature[None]
        cost = cost_matrix(*ends, feature_scale_m=settings.association.feature_scale_m)
        pairs.append(MatchedPair(i, j, float(cost[0, 0]), float(np.hypot(*(one.position - other_one.position)))))
    return Reasoning(arm.name, _title(arm), (items(0), items(1)), tuple(pairs), own_maps=True)


def read_positions(arm: Arm, episode: Episode, sightings: Sightings, settings: Settings) -> Reasoning:
    """Return evidence from sightings: every recorded instance of the category is an object, and all are grounded."""
    category, min_mask_px = episode.category, settings.admissibility.min_mask_px
    worlds = [recorded_world(sightings.sightings[which], category, min_mask_px) for which in VISITS]
    seen = [sorted(world.category(category), key=lambda instance: (instance.x, instance.z)) for world in worlds]
    p = [np.array([(instance.x, instance.z) for instance in of], dtype=float).reshape(-1, 2) for of in seen]
    matched = associate(*p, gate_m=settings.association.gate_m, feature_scale_m=settings.association.feature_scale_m)
    nearest = _measure_gaps([dict(enumerate(points)) for points in p])

    def items(visit: int) -> tuple[Item, ...]:
        recorded = [one for one in sightings.sightings[VISITS[visit]] if one.px >= min_mask_px]
        return tuple(
            Item(
                id=i,
                at=(instance.x, instance.z),
                sightings=len(instance.track),
                similarity=None,
                grounded=True,
                track=tuple(instance.track),
                views=tuple(one.view for one in recorded if one.instance == instance.id),
                nearest_m=nearest[visit].get(i),
            )
            for i, instance in enumerate(seen[visit])
        )

    gap = distances(*p)
    pairs = tuple(MatchedPair(i, j, float(gap[i, j]), float(gap[i, j])) for i, j in matched.pairs)
    return Reasoning(arm.name, _title(arm), (items(0), items(1)), pairs, own_maps=False)


def _measure_gaps(points: Sequence[Mapping[int, np.ndarray]]) -> list[dict[int, float]]:
    """Return for both visits the distance of each object to the nearest one of the other visit."""
    if not points[0] or not points[1]:
        return [{}, {}]
    gap = distances(np.array(list(points[0].values())), np.array(list(points[1].values())))
    return [dict(zip(points[visit], gap.min(axis=1 - visit).tolist(), strict=True)) for visit in (0, 1)]


def _title(arm: Arm) -> str:
    if arm.positions is Source.HANDED:
        return "oracle positions"
    return f"own maps, {'oracle grounding' if arm.grounding is Source.HANDED else 'own grounding'}"


def _point(pair: np.ndarray) -> Point:
    return float(pair[0]), float(pair[1])

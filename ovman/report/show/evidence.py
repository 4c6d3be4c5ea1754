"""The evidence of the reference agent: the objects of its maps, those that it grounded, and those that it matched."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import VISITS
from ovman.agents.reference.reasoning import similarities
from ovman.perception.clusters import Cluster
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import Prediction
from ovman.report.show.results import Results, ShowError


@dataclass(frozen=True, slots=True)
class Item:
    """An object of the map of a visit. id: index in the map; at, track: (x, z), metres; members: its detections."""

    id: int
    at: Point
    track: Sequence[Point]
    members: Sequence[int]
    is_grounded: bool
    title: str


@dataclass(frozen=True, slots=True)
class Evidence:
    """Objects of both visits by visit, and the matched pairs of grounded ones by id."""

    items: Mapping[str, Sequence[Item]]
    pairs: Sequence[tuple[int, int]]

    @property
    def matched(self) -> str:
        """The pairs with their distances, and the grounded objects without a pair, in words."""
        first, second = (self.items[which] for which in VISITS)
        gaps = [(i, j, math.dist(first[i].at, second[j].at)) for i, j in self.pairs]
        words = [f"matched {', '.join(f'{i}–{j} ({gap:.2f} m)' for i, j, gap in gaps) or 'nothing'}"]
        for visit, which in enumerate(VISITS):
            paired = {pair[visit] for pair in self.pairs}
            alone = [str(item.id) for item in self.items[which] if item.is_grounded and item.id not in paired]
            words.append(f"{', '.join(alone) or 'nothing'} of the {which} visit is left")
        return "; ".join(words)


def read_evidence(results: Results, episode: Episode, maps: Mapping[str, Sequence[Cluster]], noun: np.ndarray) -> Evidence | None:
    """Return the evidence that the reference agent's prediction records; None without it.

    maps: Of each visit, as the agent had it. noun: (K,) embedding of the episode's noun. ShowError if the evidence names objects
    that the maps do not have.
    """
    agent = results.settings.comparisons.agent
    prediction: Prediction | None = next((one for one, _ in results.predictions(agent, episode)), None)
    if prediction is None or prediction.evidence is None:
        return None
    evidence = prediction.evidence
    grounded = dict(zip(VISITS, (evidence.grounded_1 or (), evidence.grounded_2), strict=True))
    if any(i >= len(maps[which]) for which in VISITS for i in grounded[which]):
        other = f"the prediction of {agent} was made from other maps than these"
        raise ShowError(f"{episode.id}: {other}; `make tables` makes both")
    items = {which: _list_items(which, maps[which], grounded[which], noun) for which in VISITS}
    return Evidence(items, evidence.pairs)


def _list_items(which: str, clusters: Sequence[Cluster], grounded: Sequence[int], noun: np.ndarray) -> list[Item]:
    items = []
    for i, cluster in enumerate(clusters):
        similarity = similarities(cluster.feature[None], noun)[0]
        views = ", ".join(map(str, cluster.views))
        title = f"{which} visit, object {i}: similarity {similarity:.3f}, seen in views {views}"
        track = [(float(x), float(z)) for x, z in cluster.track]
        at = float(cluster.position[0]), float(cluster.position[1])
        items.append(Item(i, at, track, cluster.members.tolist(), i in grounded, title))
    return items

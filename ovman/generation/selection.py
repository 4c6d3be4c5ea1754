"""Which certified trials a split releases: one per pair of tours; scenes, instances and sizes take turns. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ovman.generation.drawing import KIND_OF, SHOWN_IN
from ovman.records.task import Relation
from ovman.records.trial import Trial

TourPair = tuple[str, frozenset[str]]
"""A scene and the names of the recorded tours of its two visits, in any order."""


@dataclass(frozen=True)
class Size:
    """Rank of the scripted change by size. largest: whether no like change looks larger; among: the number of like ones."""

    largest: bool
    among: int


def rank_size(trial: Trial) -> Size:
    """Return the rank of a certified trial of a split with others, by the largest masks in the tour that shows the instance."""
    candidate, measured = trial.candidate, trial.measured
    assert measured.sightings is not None
    kind = KIND_OF[candidate.relation]
    changes = candidate.first if kind == "enable" else candidate.second
    written = "disable" if kind == "enable" else kind
    alike = [one.instance for one in changes if one.kind == written]
    which = SHOWN_IN[kind]
    px = dict.fromkeys(alike, 0)
    for seen in measured.sightings[which]:
        if seen.instance in px:
            px[seen.instance] = max(px[seen.instance], seen.px)
    px |= {one: (measured.other_px or {})[one][which] for one in alike if one in candidate.others}
    scripted = max(px[one] for one in alike if one not in candidate.others)
    return Size(scripted == max(px.values()), len(alike))


def select_in_turn(
    certified: Mapping[str, Sequence[str]],
    wanted: int,
    rng: np.random.Generator,
    instance_of: Mapping[str, str] | None = None,
    size_of: Mapping[str, Size] | None = None,
) -> list[str]:
    """Return `wanted` of the certified ids: scene after scene in random order, one id per scene and round.

    instance_of: the instance of each id, if instances take turns: in all scenes, ids about a new instance come before ids about
    an instance that has one. size_of: if sizes take turns: of the possible next ids, take the first that brings the number of
    largest changes nearer to its expectation, the sum of one over the number of like changes.
    """
    order = sorted(certified)
    queues = {scene: [sorted(certified[scene])[k] for k in rng.permutation(len(certified[scene]))] for scene in order}
    scenes = [order[k] for k in rng.permutation(len(order))]
    turns: list[tuple[int, int, int, str]] = []
    for place, scene in enumerate(scenes):
        asked, length = Counter[str](), Counter[int]()
        for k in queues[scene]:
            instance = k if instance_of is None else instance_of[k]
            turns.append((asked[instance], length[asked[instance]], place, k))
            length[asked[instance]] += 1
            asked[instance] += 1
    rounds: dict[int, list[str]] = {}
    for number, _, _, k in sorted(turns):
        rounds.setdefault(number, []).append(k)
    in_turn = rounds.values() if size_of is None else _by_size(list(rounds.values()), size_of)
    return list(chain.from_iterable(in_turn))[:wanted]


def _by_size(rounds: Sequence[Sequence[str]], size_of: Mapping[str, Size]) -> list[list[str]]:
    """Return the ids of each round reordered, so that largest changes are as frequent as by chance, from first to last."""
    largest, chance = 0, 0.0
    ordered: list[list[str]] = []
    for ids in map(list, rounds):
        ordered.append([])
        while ids:
            due = largest + 0.5 < chance + 1 / size_of[ids[0]].among
            k = next((one for one in ids if size_of[one].largest == due), ids[0])
            ids.remove(k)
            ordered[-1].append(k)
            largest, chance = largest + size_of[k].largest, chance + 1 / size_of[k].among
    return ordered


def tour_pair(trial: Trial) -> TourPair:
    """Return the pair of tours of a certified trial, in any order."""
    visits = trial.measured.visits
    assert visits is not None
    return trial.candidate.scene, frozenset((visits.first, visits.second))


def select_independent(
    pairs: Mapping[str, TourPair], relation_of: Mapping[str, Relation], wanted: Mapping[Relation, int], rng: np.random.Generator
) -> list[str]:
    """Return the trials that remain when each pair of tours serves one trial, sorted.

    pairs: by the id of a trial. A pair that several relations could use goes to the relation that lacks most of its `wanted`
    number; pairs are in random order within each scene, so that no relation gets the better scenes. Of trials of one relation the
    first is taken.
    """
    claims: dict[TourPair, dict[Relation, str]] = {}
    for k in sorted(pairs):
        claims.setdefault(pairs[k], {}).setdefault(relation_of[k], k)
    kept = [k for claim in claims.values() if len(claim) == 1 for k in claim.values()]
    has = Counter(relation_of[k] for k in kept)
    contested = sorted((pair for pair, claim in claims.items() if len(claim) > 1), key=lambda pair: (pair[0], sorted(pair[1])))
    order = sorted(rng.permutation(len(contested)), key=lambda k: contested[k][0])
    for pair in (contested[k] for k in order):
        claim = claims[pair]
        lacks_most = max((r for r in Relation if r in claim), key=lambda r: wanted[r] - has[r])
        has[lacks_most] += 1
        kept.append(claim[lacks_most])
    return sorted(kept)


def find_sharing(pairs: Mapping[str, TourPair], released: Iterable[str]) -> list[str]:
    """Return the unreleased trials whose pair of tours serves a released one, in their order."""
    released = set(released)
    taken = {pairs[k] for k in released}
    return [k for k, pair in pairs.items() if k not in released and pair in taken]

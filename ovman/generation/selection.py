"""Which certified trials of a relation a split releases: scenes, instances and sizes take turns. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ovman.generation.script import KIND_OF, SHOWN_IN
from ovman.records.trial import Trial


@dataclass(frozen=True)
class Size:
    """How the scripted change is ranked by size. largest: whether none that is alike looks larger; among: how many are alike."""

    largest: bool
    among: int


def size(trial: Trial) -> Size:
    """Of a measured trial of a split with others: by the largest masks in the tour that shows a change's instance.

    ValueError for a trial that ended before its tours.
    """
    candidate, measured = trial.candidate, trial.measured
    if measured.sightings is None:
        raise ValueError(f"{candidate.id}: the trial ended early and has no tours")
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


def select(
    certified: Mapping[str, Sequence[str]],
    wanted: int,
    rng: np.random.Generator,
    instance_of: Mapping[str, str] | None = None,
    size_of: Mapping[str, Size] | None = None,
) -> list[str]:
    """`wanted` of the certified ids by scene: one scene after another in random order, one id of each per round.

    instance_of: the instance that each id asks about, where instances take turns: all ids that ask about another instance of
    their scene come before any that ask about one for the second time, in all scenes. size_of: where sizes take turns: of the
    ids that may come next the first is taken that brings the number of those whose change is the largest nearer to the sum of
    one over the number of changes that are alike.
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
    """The ids of each round in another order, in which the largest changes are as many as chance has them, from first to last."""
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

"""Attack a crossed split with all that is released about it: `python -m bench.attacks [SPLIT] [RESULTS]`.

Each attack knows the true places of all things, so it is stronger than any agent. It lacks one thing that the task needs: looks,
a visit, or the noun. It is a conditional logit over the places of a query, fitted on other scenes. SPLIT is everyday by default,
RESULTS a folder with scenes/ and episodes/ (by default the released data). With the folder results/ of a whole run, the last
attack measures what the joint agent gains by remembering its earlier answers in a home.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ovman import seeds
from ovman.agents.interface import Abstention, Answer, Query
from ovman.agents.joint.agent import recorded_segments
from ovman.agents.joint.decision import Nouns, answer
from ovman.agents.joint.segments import Segments
from ovman.analysis.outcomes import find_successes
from ovman.evaluation.context import EpisodeContext
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import Prediction
from ovman.records.scene import Scene
from ovman.records.task import Relation
from ovman.shipped import EMBEDDED, HOME
from training.noun_blind import Asked, choose_apart, open_contexts

PRIOR = 0.5
"""Standard deviation of the weights' prior, per standard deviation of a feature."""
FOLDS = 8
"""Parts of the scenes; each is answered by weights that were fitted on the others."""
ORDERS = 5
"""Random orders of the queries of a pair that a remembering agent is asked in."""
Candidates = list[tuple[str, Point]]
"""Instances and where they are, (x, z) in metres."""


def list_new_or_old(episode: Episode) -> Candidates:
    """List the places of the noun's changes that only looks tell apart: new places for current relations, old ones for past."""
    past, kinds = episode.relation.past, {"displace", "disable" if episode.relation.past else "enable"}
    return [
        (change.instance, (at.x, at.z))
        for change in episode.scripted
        if change.kind in kinds and (at := change.before if past else change.after) is not None
    ]


def list_in_visit(episode: Episode) -> Candidates:
    """List the instances of the noun in the visit that the relation reads."""
    world = episode.world_1 if episode.relation.past else episode.world_2
    return [(one.id, (one.x, one.z)) for one in world if one.category == episode.category]


def list_alike(episode: Episode) -> Candidates:
    """List the places of all changes of the kind that defines the query, whatever their noun."""
    return [
        (change.instance, (at.x, at.z))
        for change in episode.alike
        if (at := change.before if episode.relation.past else change.after) is not None
    ]


def measure(scene: Scene, episode: Episode, places: Candidates) -> np.ndarray:
    """Return features (N, F) of places: distances in metres to what tours and home show, and the sizes of the things."""
    points = np.array([at for _, at in places])
    cells, by_id = np.array(scene.reachable), {item.id: item for item in scene.objects}

    def nearest_m(others: Sequence[Point]) -> np.ndarray:
        gaps = np.linalg.norm(points[:, None] - np.array(others).reshape(1, -1, 2), axis=2)
        nearest: np.ndarray = gaps.min(axis=1, initial=9.0)
        return nearest

    low, high = cells.min(axis=0), cells.max(axis=0)
    tours = episode.tours
    columns = [
        nearest_m(tours.first.waypoints),
        nearest_m(tours.second.waypoints),
        nearest_m([scene.start]),
        nearest_m([(episode.spawn.x, episode.spawn.z)]),
        nearest_m([tuple((low + high) / 2)]),
        np.minimum(points - low, high - points).min(axis=1),
        nearest_m([item.place for item in scene.objects if item.id not in dict(places)]),
        [float(np.sort(np.linalg.norm(points - at, axis=1))[:2].max()) for at in points],
    ]
    items = [by_id[name] for name, _ in places]
    columns += [[np.log(item.size.x * item.size.y * item.size.z) for item in items], [item.bottom_y for item in items]]
    columns += [[item.size.y for item in items], [abs(item.half[0] - item.half[1]) for item in items]]
    return np.column_stack(columns)


def attack(episodes: Sequence[Episode], scenes: dict[str, Scene], candidates: Callable[[Episode], Candidates]) -> pd.DataFrame:
    """Return a row per query with two candidates or more: its relation, the chance, and whether the attack finds the answer."""
    chosen = [(one, places) for one in episodes if len(places := candidates(one)) > 1 and one.target in dict(places)]
    rows = [measure(scenes[one.scene], one, places) for one, places in chosen]
    mean, scale = np.concatenate(rows).mean(axis=0), np.maximum(np.concatenate(rows).std(axis=0), 1e-6)
    asked: list[Asked] = [
        (list(Relation).index(one.relation), (row - mean) / scale, np.array([name == one.target for name, _ in places]))
        for (one, places), row in zip(chosen, rows, strict=True)
    ]
    fold = {scene: str(number % FOLDS) for number, scene in enumerate(dict.fromkeys(one.scene for one, _ in chosen))}
    found = choose_apart(asked, [fold[one.scene] for one, _ in chosen], PRIOR)
    chance = [1 / len(places) for _, places in chosen]
    return pd.DataFrame({"relation": [one.relation.value for one, _ in chosen], "chance": chance, "found": found})


def remember(episodes: Sequence[Episode], split: str, results: Path) -> pd.DataFrame:
    """Return a row per query and order: whether the joint agent finds it, as it is and without the places that it answered."""
    contexts = dict(zip([one.id for one in episodes], open_contexts(list(episodes), split, results), strict=True))
    rng, rows = seeds.generator(0, "remember"), []
    for pair in dict.fromkeys(one.streams for one in episodes):
        asked = [one for one in episodes if one.streams == pair]
        plain = {one.id: _is_right(one, _decide(one, contexts[one.id], ())) for one in asked}
        for _ in range(ORDERS):
            answered: list[Point] = []
            for one in (asked[k] for k in rng.permutation(len(asked))):
                kept = _decide(one, contexts[one.id], answered)
                answered += [(kept.x, kept.z)] if isinstance(kept, Answer) else []
                rows.append({"relation": one.relation.value, "chance": plain[one.id], "found": _is_right(one, kept)})
    return pd.DataFrame(rows)


def _decide(episode: Episode, context: EpisodeContext, answered: Sequence[Point]) -> Answer | Abstention:
    """Answer as the joint agent, without what lies near the places that it answered."""
    constants = context.settings.joint
    segments = [_without(part, answered) for part in recorded_segments(context)]
    return answer(Query(episode.category, episode.relation), *segments, Nouns(context.noun, constants), constants)


def _without(seen: Segments, answered: Sequence[Point]) -> Segments:
    gaps = np.linalg.norm(seen.place[:, None, [0, 2]] - np.array(answered).reshape(1, -1, 2), axis=2)
    kept = gaps.min(axis=1, initial=9.0) > 0.5
    return Segments(**{name: getattr(seen, name)[kept] for name in Segments.__slots__})


def _is_right(episode: Episode, given: Answer | Abstention) -> bool:
    """Return whether a decision succeeds on the static gate."""
    predicted = [Prediction.of(episode.id, "joint", 0, given)]
    return find_successes([episode], predicted, episode.protocol.success.radius_m)[episode.id]


def _summarise(found: pd.DataFrame) -> Iterator[str]:
    for relation, of in [("all", found), *found.groupby("relation", sort=False)]:
        spread = 1.96 * of["found"].std() / np.sqrt(len(of))
        yield f"| {relation} | {len(of)} | {of['chance'].mean():.3f} | {of['found'].mean():.3f} ± {spread:.3f} |"


def main() -> None:
    """Print a table per attack."""
    split = sys.argv[1] if len(sys.argv) > 1 else "everyday"
    results = Path(sys.argv[2]) if len(sys.argv) > 2 else HOME / EMBEDDED
    episodes = Episode.load(results / "episodes" / f"{split}.jsonl")
    scenes = {scene.scene: scene for scene in Scene.read(results / "scenes" / f"{split}.jsonl")}
    attacks = {
        "no looks: which of the noun's new or old places": list_new_or_old,
        "one visit: which instance of the noun": list_in_visit,
        "no noun: which of the changes of the kind": list_alike,
    }
    still = [one for one in episodes if one.relation is not Relation.MOVING]
    for title, candidates in attacks.items():
        print(f"\n{title}\n\n| relation | queries | chance | found |\n|---|---|---|---|")
        print("\n".join(_summarise(attack(still, scenes, candidates))))
    if (results / "segments" / split).is_dir():
        print("\nthe joint agent without its earlier answers\n\n| relation | n | as it is | found |\n|---|---|---|---|")
        print("\n".join(_summarise(remember(episodes, split, results))))


if __name__ == "__main__":
    main()

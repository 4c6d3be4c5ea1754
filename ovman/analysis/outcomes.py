"""The tidy table of outcomes, one row per arm, seed and episode. Only here does an answer meet a prediction."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from ovman.evaluation.scores import is_right, success_probability
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer, Prediction
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.seeds import generator
from ovman.settings import Kind

Answered = TypeVar("Answered", Prediction, Score)
Item = TypeVar("Item")

ALL = "all"
RELATIONS = (*Relation, ALL)
EXPECTED = "expected"
MANY = 4
"""Categories with at least this many instances are one group."""
_EPISODE = "episode scene relation category instances alike arm seed outcome"
STATIC_OUTCOMES = f"{_EPISODE} reason distance_m success other_m confidence"
EMBODIED_OUTCOMES = f"{_EPISODE} success spl path_length_m actions own_success"


@dataclass(frozen=True, slots=True)
class Outcome:
    """One prediction of a static arm, or one run of an embodied arm, judged. The fields after `success` depend on which it is.

    Attributes:
        outcome: "answered", "abstained" or "expected" (the arm is a stochastic pick); of a run, how it ended.
        success: 1 or 0; a probability where `outcome` is "expected".
        reason: Why a static arm abstained.
        distance_m: From the predicted point to the answer; `other_m`: to the nearest other instance of the category.
        confidence: How probable the arm holds its answer, if it says so.
        spl: Eq. 5. `path_length_m`, `actions`: what the agent travelled.
        own_success: Whether the run succeeds on the task that the agent was made for, if it has one.
        box_distance_m: From the stop to the target's box.
        alike: Changes of the kind that defines the episode, its own included; in a world pair the queries with its relation.
        neighbour_m: Distance from the answer to the nearest other instance of the category, in the visit that the answer belongs
            to or in the second.
    """

    episode: str
    scene: str
    relation: Relation
    category: str
    instances: int
    alike: int
    arm: str
    seed: int
    outcome: str
    success: float
    reason: str | None = None
    distance_m: float | None = None
    other_m: float | None = None
    confidence: float | None = None
    spl: float | None = None
    path_length_m: float | None = None
    actions: int | None = None
    own_success: bool | None = None
    box_distance_m: float | None = None
    neighbour_m: float | None = None

    @property
    def kind(self) -> Kind:
        """The kind of the arm: a run has a path, a prediction has none."""
        return Kind.STATIC if self.path_length_m is None else Kind.EMBODIED

    @property
    def instance_group(self) -> str:
        """The number of instances, "4+" for many."""
        return str(self.instances) if self.instances < MANY else f"{MANY}+"


def is_expectation(outcome: Outcome) -> bool:
    """Tell whether the success is the expectation over a stochastic pick."""
    return outcome.outcome == EXPECTED


def static_outcomes(
    episodes: Sequence[Episode], predictions: Iterable[Prediction], *, radius_m: float, samples: int = 1, seed: int = 0
) -> list[Outcome]:
    """Judge predictions, one per arm, seed and episode, in their order.

    A point succeeds within `radius_m` of the answer on the floor plane, and if success is exclusive only nearer to the answer
    than to every rival. An abstention fails, and a stochastic pick counts with its probability of success, by `samples` Monte
    Carlo draws for a pick from a box. ValueError for an arm that does not answer each episode exactly once in each of its runs.
    """
    places = {episode.id: other_places(episode)[0] for episode in episodes}

    def judge(episode: Episode, prediction: Prediction) -> dict[str, Any]:
        match prediction.outcome:
            case Answer(x, z, confidence):
                distance_m = math.dist((x, z), episode.answer)
                return {
                    "outcome": "answered",
                    "success": float(is_right((x, z), episode, radius_m)),
                    "distance_m": distance_m,
                    "other_m": min((math.dist((x, z), point) for point in places[episode.id]), default=None),
                    "confidence": confidence,
                }
            case Abstention(reason):
                return {"outcome": "abstained", "success": 0.0, "reason": str(reason)}
            case pick:
                draws = generator(seed, "single_visit", episode.id)
                probability = success_probability(
                    pick, episode.answer, radius_m, samples=samples, generator=draws, rivals=episode.rivals()
                )
                return {"outcome": EXPECTED, "success": probability}

    return _join(episodes, predictions, judge)


def embodied_outcomes(episodes: Sequence[Episode], scores: Iterable[Score]) -> list[Outcome]:
    """Join judged runs with their episodes, in the order of the runs.

    Raises:
        ValueError: An arm does not run each episode exactly once under each of its seeds.
    """
    fields = ("outcome", "success", "spl", "path_length_m", "actions", "own_success", "box_distance_m")
    return _join(episodes, scores, lambda _, score: {field: getattr(score, field) for field in fields})


def other_places(episode: Episode) -> list[list[tuple[float, float]]]:
    """Return the places of the category's other instances in the visit that the answer belongs to, and in the second."""
    worlds = (episode.world_1 if episode.relation.past else episode.world_2, episode.world_2)
    return [[one.position for one in w if one.category == episode.category and one.id != episode.target] for w in worlds]


def _join(
    episodes: Sequence[Episode], answers: Iterable[Answered], judge: Callable[[Episode, Answered], dict[str, Any]]
) -> list[Outcome]:
    alike = count_alike(episodes)
    by_id = {episode.id: (episode, _describe(episode, alike[episode.id])) for episode in episodes}
    outcomes, answered = [], dict[tuple[str, int], set[str]]()
    for one in answers:
        if one.episode not in by_id:
            raise ValueError(f"{one.arm} answers {one.episode}, which is not among the episodes; make its records again")
        of_run, (episode, known) = answered.setdefault((one.arm, one.seed), set()), by_id[one.episode]
        if one.episode in of_run:
            raise ValueError(f"{one.arm}, seed {one.seed}: {one.episode} is there twice; make its records again")
        of_run.add(one.episode)
        outcomes.append(Outcome(arm=one.arm, seed=one.seed, **known, **judge(episode, one)))
    for (arm, seed), of_run in answered.items():
        if missing := sorted(by_id.keys() - of_run):
            raise ValueError(f"{arm}, seed {seed}: {len(missing)} episodes are missing, the first is {missing[0]}")
    return outcomes


def count_alike(episodes: Sequence[Episode]) -> dict[str, int]:
    """Return m of each episode by its id: queries of its world pair with its relation; without a pair the changes alike."""
    queries = Counter((episode.pair, episode.relation) for episode in episodes)
    return {one.id: len(one.alike) if one.pair is None else queries[one.pair, one.relation] for one in episodes}


def _describe(episode: Episode, alike: int) -> dict[str, Any]:
    near = (math.dist(place, episode.answer) for places in other_places(episode) for place in places)
    return {
        "episode": episode.id,
        "scene": episode.scene,
        "relation": episode.relation,
        "category": episode.category,
        "instances": episode.instances_in_category,
        "alike": alike,
        "neighbour_m": min(near, default=None),
    }


def find_successes(episodes: Sequence[Episode], predictions: Iterable[Prediction], radius_m: float) -> dict[str, bool]:
    """Tell of each episode whether its realised prediction succeeds, by the episode's id."""
    outcomes = static_outcomes(episodes, predictions, radius_m=radius_m)
    return {outcome.episode: outcome.success == 1.0 for outcome in outcomes}


def groups(outcomes: Iterable[Outcome], *by: str) -> dict[tuple[Any, ...], list[Outcome]]:
    """Group outcomes by columns, the first outermost, each in the order of `group_by`."""
    if not by:
        return {(): list(outcomes)}
    parts = group_by(outcomes, by[0])
    return {(key, *others): group for key, part in parts.items() for others, group in groups(part, *by[1:]).items()}


def group_by(outcomes: Iterable[Item], column: str) -> dict[Any, list[Item]]:
    """Group outcomes, or other things, by an attribute.

    Arms come as they appear, seeds ascending, scenes and other names by the number in them, and relations in the order of the
    task, followed by all of them together.
    """
    whole, parts = list(outcomes), dict[Any, list[Item]]()
    for outcome in whole:
        parts.setdefault(getattr(outcome, column), []).append(outcome)
    if column == "relation" and whole:
        parts[ALL] = whole
    return {key: parts[key] for key in (parts if column == "arm" else sorted(parts, key=_ORDERS.get(column, natural_order)))}


def natural_order(name: str) -> tuple[int, str]:
    """Return the key that sorts names by the number in them."""
    number = re.search(r"\d+", name)
    return (int(number.group()) if number else 0, name)


_ORDERS: Mapping[str, Any] = {"seed": int, "relation": RELATIONS.index, "kind": list(Kind).index}

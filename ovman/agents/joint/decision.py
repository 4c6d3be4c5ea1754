"""What the joint agent answers: the object, or the end of the track, with the greatest probability of being what is meant."""

from __future__ import annotations

import numpy as np

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Relation
from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.objects import Objects
from ovman.agents.joint.segments import Segments
from ovman.agents.joint.settings import Joint


def decide(relation: Relation, first: Objects, second: Objects, constants: Joint) -> Answer | Abstention:
    """The place of the object that is most likely named and changed as the relation says; of equal ones the first.

    FORMER, REMOVED: among the objects of visit 1, MOVED, APPEARED: of visit 2, whose place is otherwise in the other visit. MOVED
    and FORMER want a look-alike that vanished or came elsewhere, APPEARED and REMOVED want none. STABLE: among the objects of
    visit 2 whose place is the same in visit 1. Abstains with NOTHING_GROUNDED where nothing is seen, and as `best`.
    """
    here, there = (first, second) if relation.past else (second, first)
    if not len(here):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    scores = here.named + log_sigmoid(-here.changed if relation is Relation.STABLE else here.changed)
    if relation is not Relation.STABLE:
        elsewhere = counterpart(here, there, constants)
        wanted = elsewhere if relation in (Relation.MOVED, Relation.FORMER) else -elsewhere
        scores = scores + constants.identity * log_sigmoid(wanted)
    return best(here.place, scores, constants)


def best(places: np.ndarray, scores: np.ndarray, constants: Joint) -> Answer | Abstention:
    """The place (N, 3) with the highest log probability (N,), up to a factor, the first of equal ones.

    Its confidence is the share of the probability that lies no farther than `radius_m` from it. Abstains with UNSURE below
    `least_confidence`.
    """
    place = places[int(scores.argmax())]
    near = np.linalg.norm(places - place, axis=1) <= constants.radius_m
    share = np.exp(scores - scores.max())
    confidence = round(float(share[near].sum() / share.sum()), 4)
    if confidence < constants.least_confidence:
        return Abstention(AbstentionReason.UNSURE)
    return Answer(float(place[0]), float(place[2]), confidence)


def counterpart(here: Objects, there: Objects, constants: Joint) -> np.ndarray:
    """(N,) log odds that an object is to be found elsewhere in the other visit, where nothing was in its own."""
    best = np.full(len(here), constants.unlike)
    if not len(there):
        return best
    apart = np.linalg.norm(here.place[:, None] - there.place[None], axis=2)
    alike = constants.likeness * (here.feature @ there.feature.T - constants.alike) + log_sigmoid(there.changed)[None]
    alike = np.where(apart > constants.radius_m, alike, constants.unlike)
    found: np.ndarray = np.maximum(alike.max(axis=1), constants.unlike)
    return found


def moving(seen: Segments, phrase: str | None, nouns: Nouns, constants: Joint) -> Answer | Abstention:
    """The end of the most likely track of something that moves through the views of visit 2.

    A track goes from view to view no faster than a mover. Each of its segments adds the log odds that it is what the noun means,
    beside chance, and that its place is otherwise in the first visit or in other views. Abstains as `decide`.
    """
    if not len(seen):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    named = nouns.log_probability(seen.feature, phrase) if phrase else np.full(len(seen), nouns.chance)
    own = named - nouns.chance + constants.motion * log_sigmoid(np.maximum(seen.changed, seen.moving))
    total = own.copy()
    order = np.argsort(seen.view, kind="stable")
    for number, j in enumerate(order):
        before = order[:number]
        before = before[seen.view[before] < seen.view[j]]
        metres = np.hypot(*(seen.place[before] - seen.place[j])[:, [0, 2]].T)
        reach = constants.radius_m + constants.speed_m * (seen.view[j] - seen.view[before])
        possible = total[before][metres <= reach]
        total[j] = own[j] + max(float(possible.max(initial=0.0)), 0.0)
    return best(seen.place, total, constants)


def log_sigmoid(odds: np.ndarray) -> np.ndarray:
    """log(1 / (1 + exp(-odds))): the log probability of log odds."""
    found: np.ndarray = -np.logaddexp(0.0, -odds)
    return found

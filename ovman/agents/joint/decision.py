"""From segments to an answer: names, objects, and the most probable object or end of a track."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Query, Relation
from ovman.agents.joint import Joint
from ovman.agents.joint.segments import Segments
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS, nouns

NEVER = -1e9
"""Log odds of what cannot be."""


class Nouns:
    """The nouns of the vocabulary as an encoder has them. embedding: from a noun phrase to its unit embedding (K,)."""

    def __init__(self, embedding: Callable[[str], np.ndarray], constants: Joint) -> None:
        self._embedding, self._constants = embedding, constants
        self._phrases = tuple(dict.fromkeys(noun(category) for category in SYNONYMS))
        self._all = np.stack([np.asarray(embedding(phrase), np.float64) for phrase in self._phrases])

    def _meaning(self, phrase: str) -> np.ndarray:
        """Return the probability (C,) of each category: a softmax over the similarity to the nearest noun or synonym of each."""
        of_phrase = self._embedding(phrase)
        nearest = np.array([max(float(self._embedding(said) @ of_phrase) for said in nouns(c)) for c in SYNONYMS])
        scaled = np.exp((nearest - nearest.max()) / self._constants.temperature)
        found: np.ndarray = scaled / scaled.sum()
        return found

    @property
    def chance(self) -> float:
        """Log probability of a noun of which nothing is known."""
        return -float(np.log(len(self._phrases)))

    def log_probability(self, feature: np.ndarray, phrase: str | None) -> np.ndarray:
        """Return the log probability (S,) that features (S, K) show what a noun phrase means.

        It is the softmax over the vocabulary at the encoder's temperature, mixed with the uniform distribution: a noun that the
        encoder never learned to name is then as good as no noun, instead of evidence against everything. A phrase that is not a
        category's noun means each category with some probability. It is `chance` for features that are zero and without a phrase.
        """
        if phrase is None:
            return np.full(len(feature), self.chance)
        if not len(feature):
            return np.zeros(0)
        scaled = feature @ self._all.T / self._constants.temperature
        scaled -= scaled.max(axis=1, keepdims=True)
        softmax = np.exp(scaled)
        own = softmax[:, self._phrases.index(phrase)] if phrase in self._phrases else softmax @ self._meaning(phrase)
        share = own / softmax.sum(axis=1)
        astray = self._constants.astray
        mixed: np.ndarray = np.log((1 - astray) * share + astray / len(self._phrases))
        return np.where(feature.any(axis=1), mixed, self.chance)


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """N objects of a tour: the segments that show one instance at one place.

    Attributes:
        place: (N, 3) median of the segments' places, metres.
        top: (N,) median of the heights of their tops, metres.
        colour: (N, 3) mean logarithm of their light.
        feature: (N, K) unit mean of their embeddings, zeros for an object without a detection.
        named: (N,) log probability that it is what the noun means.
        changed: (N,) log odds that its place is different in the other tour.
    """

    place: np.ndarray
    top: np.ndarray
    colour: np.ndarray
    feature: np.ndarray
    named: np.ndarray
    changed: np.ndarray

    def __len__(self) -> int:
        return len(self.place)


def group_objects(seen: Segments, phrase: str | None, nouns: Nouns, constants: Joint) -> Objects:
    """Return the objects of a tour's segments. phrase: the noun that is asked for, None without one (input ablation)."""
    # Larger segments say more, but not in proportion to their areas: pixels of one view are not independent.
    weights = np.sqrt(seen.cells)

    def mean(values: np.ndarray, group: np.ndarray) -> np.ndarray:
        return np.average(values[group], axis=0, weights=weights[group])

    groups = _group(seen, np.flatnonzero(seen.named), constants)
    known = [np.median(seen.place[group], axis=0) for group in groups if mean(seen.changed, group) > 0]
    loose = [
        k
        for k in np.flatnonzero(~seen.named)
        if all(np.linalg.norm(seen.place[k] - place) > constants.radius_m for place in known)
    ]
    groups += _group(seen, np.array(loose, np.int64), constants)
    log = nouns.log_probability(seen.feature, phrase)
    feature = [mean(seen.feature, group) for group in groups]
    views = np.array([len(np.unique(seen.view[group])) for group in groups], np.int64)
    share = views / (views + constants.views)
    return Objects(
        place=np.array([np.median(seen.place[group], axis=0) for group in groups]).reshape(len(groups), 3),
        top=np.array([np.median(seen.high[group, 1]) for group in groups]),
        colour=np.array([mean(seen.colour, group) for group in groups]).reshape(len(groups), 3),
        feature=np.array([one / (np.linalg.norm(one) or 1.0) for one in feature]).reshape(len(groups), seen.feature.shape[1]),
        named=share * np.array([mean(log, group) for group in groups]) + (1 - share) * nouns.chance,
        changed=np.array([mean(seen.changed, group) for group in groups]),
    )


def _group(seen: Segments, chosen: np.ndarray, constants: Joint) -> list[np.ndarray]:
    """Group the chosen segments: average linkage over the distance of their places plus that of their features."""
    if len(chosen) < 2:
        return [chosen] if len(chosen) else []
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    place, feature = seen.place[chosen], seen.feature[chosen]
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) / constants.radius_m
    if seen.named[chosen].all():
        apart += np.maximum(1 - feature @ feature.T, 0) / constants.feature_distance
    np.fill_diagonal(apart, 0)
    of = fcluster(linkage(squareform((apart + apart.T) / 2, checks=False), "average"), 1.0, "distance")
    return [chosen[of == k] for k in np.unique(of)]


def compare_places(mine: Segments, other: Segments, constants: Joint) -> np.ndarray:
    """Return the log odds (S,) that something else stands at the place of a segment in the other tour, by looks.

    The most similar detection within `radius_m` decides. They are 0 for a segment that is not a detection.
    """
    if not len(mine) or not len(other):
        return np.where(mine.named, -constants.unlike, 0.0)
    apart = np.linalg.norm(mine.place[:, None] - other.place[None], axis=2)
    unlike = constants.likeness * (constants.alike - mine.feature @ other.feature.T)
    least = np.where((apart <= constants.radius_m) & other.named, unlike, np.inf).min(axis=1, initial=np.inf)
    return np.where(mine.named, np.clip(least, constants.unlike, -constants.unlike), 0.0)


def decide(relation: Relation, first: Objects, second: Objects, same: np.ndarray, constants: Joint) -> Answer | Abstention:
    """Answer with the place of the object that is most likely named and changed as the relation says; of equal ones the first.

    FORMER and REMOVED choose among the objects of visit 1, MOVED and APPEARED among those of visit 2, whose place is different
    in the other visit. STABLE chooses among the objects of visit 2 by what both visits show at the place. Abstains with
    NOTHING_GROUNDED if nothing is seen, and as `pick_best`. same: log odds (N, M) that an object of visit 1 is one of visit 2.
    """
    here, there = (first, second) if relation.past else (second, first)
    if not len(here):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    sign = -1 if relation is Relation.STABLE else 1
    mine, others = (one.named + constants.change * log_sigmoid(sign * one.changed) for one in (here, there))
    if relation is Relation.STABLE:
        pairs = np.where(measure_distances(here, there) <= constants.radius_m, others, NEVER)
        return pick_best(here.place, mine + pairs.max(axis=1, initial=NEVER), constants)
    same = same if relation.past else same.T
    mine, others = mine + constants.expected, log_sigmoid(others + constants.expected)
    if relation in (Relation.MOVED, Relation.FORMER):
        scores = log_sigmoid(mine) + (others + same).max(axis=1, initial=NEVER)
    else:
        rival = measure_distances(here, here) > constants.radius_m
        scores = mine + match_rivals(np.maximum(mine[:, None] + others + same, 0), rival)
    return pick_best(here.place, scores, constants)


def match_rivals(gain: np.ndarray, rival: np.ndarray) -> np.ndarray:
    """Return how well all rivals of each object of a visit are explained together, as objects of the other visit that moved.

    It is the weight (N,) of the best one-to-one match. gain: (N, M) weights of pairs, at least 0; rival: (N, N) bool, whether two
    objects stand at different places.
    """
    from scipy.optimize import linear_sum_assignment

    gain = gain[:, gain.any(axis=0)]
    rests = [gain[rivals & gain.any(axis=1)] for rivals in rival]
    return np.array([rest[linear_sum_assignment(rest, maximize=True)].sum() for rest in rests])


def compare_objects(first: Objects, second: Objects, constants: Joint) -> np.ndarray:
    """Return the log odds (N, M) that an object of visit 1 stands elsewhere in visit 2, by looks.

    Hues are compared relative to those of what stands in both visits, so that the light of the visits does not count.
    """
    apart = measure_distances(first, second)
    if not len(first) or not len(second):
        return np.zeros(apart.shape)
    stands = np.where(np.logical_and.outer(first.changed < 0, second.changed < 0), apart, np.inf)
    rows, columns = np.nonzero((stands <= constants.radius_m) & (stands == stands.min(axis=0)))
    hues = [one.colour - one.colour.mean(axis=1, keepdims=True) for one in (first, second)]
    light = np.median(hues[1][columns] - hues[0][rows], axis=0) if len(rows) else np.zeros(3)
    hue = np.linalg.norm(hues[1][None] - hues[0][:, None] - light, axis=2)
    rise = np.abs(second.top[None] - first.top[:, None])
    detected = np.logical_and.outer(first.feature.any(axis=1), second.feature.any(axis=1))
    looks = np.where(detected, constants.likeness * (first.feature @ second.feature.T - constants.alike), 0)
    odds = looks - np.minimum(constants.hue * hue, constants.most) - np.minimum(constants.rise_per_m * rise, constants.most)
    found: np.ndarray = np.where(apart > constants.radius_m, np.maximum(odds, constants.unlike), constants.unlike)
    return found


def measure_distances(some: Objects, others: Objects) -> np.ndarray:
    """Return the distances (N, M) between objects, metres."""
    metres: np.ndarray = np.linalg.norm(some.place[:, None] - others.place[None], axis=2)
    return metres


def decide_moving(seen: Segments, phrase: str | None, nouns: Nouns, constants: Joint) -> Answer | Abstention:
    """Answer with the end of the most likely track of something that moves through the views of visit 2.

    A track goes from view to view no faster than a mover. Each of its segments adds the log odds that it is what the noun means,
    relative to chance, and the log probability that its place is different in other views of the visit. A thing that
    came before the visit has changed, but does not move. Abstains as `decide`.
    """
    if not len(seen):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    named = nouns.log_probability(seen.feature, phrase)
    own = named - nouns.chance + constants.motion * log_sigmoid(seen.moving)
    total = own.copy()
    order = np.argsort(seen.view, kind="stable")
    for number, j in enumerate(order):
        before = order[:number]
        before = before[seen.view[before] < seen.view[j]]
        metres = np.hypot(*(seen.place[before] - seen.place[j])[:, [0, 2]].T)
        reach = constants.radius_m + constants.speed_m * (seen.view[j] - seen.view[before])
        possible = total[before][metres <= reach]
        total[j] = own[j] + max(float(possible.max(initial=0.0)), 0.0)
    return pick_best(seen.place, total, constants)


def answer(
    query: Query,
    first: Segments,
    second: Segments,
    nouns: Nouns,
    constants: Joint,
    compare: Callable[[Objects, Objects, Joint], np.ndarray] = compare_objects,
) -> Answer | Abstention:
    """Answer a query from the segments of both visits. Without a phrase nothing is named.

    compare: Gives the log odds (N, M) that an object of visit 1 stands elsewhere in visit 2.
    """
    phrase, relation = query.phrase or None, Relation(query.relation)
    if relation is Relation.MOVING:
        return decide_moving(second, phrase, nouns, constants)
    both = (first, second), (second, first)
    weighed = (replace(mine, changed=(mine.changed + compare_places(mine, other, constants)) / 2) for mine, other in both)
    objects_1, objects_2 = (group_objects(seen, phrase, nouns, constants) for seen in weighed)
    return decide(relation, objects_1, objects_2, compare(objects_1, objects_2, constants), constants)


def pick_best(places: np.ndarray, scores: np.ndarray, constants: Joint) -> Answer | Abstention:
    """Return the place of (N, 3) with the highest log probability (N,), known up to a factor, the first of equal ones.

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


def log_sigmoid(odds: np.ndarray) -> np.ndarray:
    """Return log(1 / (1 + exp(-odds))): the log probability of log odds."""
    found: np.ndarray = -np.logaddexp(0.0, -odds)
    return found

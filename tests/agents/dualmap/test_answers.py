"""What DualMap's maps answer: a maintained one the same to every relation, two of them as the reference agent reads its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from ovman.agents.dualmap.agent import predict_maintained, predict_two_visits
from ovman.agents.dualmap.mapped import Entry, Mapped, RunMaps, Sort
from ovman.agents.interface import Abstention, AbstentionReason, Answer, UniformPick
from ovman.evaluation.context import EpisodeContext
from ovman.language import noun
from ovman.records.visit import Sighting, Sightings, VisitPair
from ovman.settings import Kind, Reading, Settings, Source
from ovman.settings.arms import ArmJob
from ovman.task import Query, Relation
from tests.episodes import released

CHAIR, LAMP = np.eye(4)[0], np.eye(4)[1]
VISITS = {"first": "untouched", "second": "displace-Chair"}
SETTINGS = Settings.partial(
    {
        "grounding": {"similarity_margin": 0.03},
        "association": {"gate_m": 1.25, "feature_scale_m": 2.0, "track_spread_m": 0.4},
        "admissibility": {"tau_m": 0.75, "min_mask_px": 300},
    },
    "predictions",
)
EPISODE = released()[0].model_copy(update={"category": "Chair", "visits": VisitPair[str](**VISITS)})


def entry(x: float, z: float, feature: np.ndarray = CHAIR, last_seen: int = 5) -> Entry:
    return Entry(np.array([x, z]), feature, Sort.OBJECT, 0, 9, 0, last_seen)


def maps(first: list[Entry], second: list[Entry], both: list[Entry]) -> RunMaps:
    made = [Mapped(tuple(entries), 9) for entries in (first, second, both)]
    return RunMaps(dict(zip(VISITS.values(), made[:2], strict=True)), {tuple(VISITS.values()): made[2]})


class Seen:
    """A store with these runs' maps and the noun of a chair."""

    def __init__(self, *runs: RunMaps) -> None:
        self._runs = runs

    def load_artifact(self, need: Any, read: Any) -> tuple[RunMaps, ...]:
        return self._runs

    def noun(self, phrase: str) -> np.ndarray:
        assert phrase == noun("Chair")
        return CHAIR


def recorded(
    *runs: RunMaps, grounding: Source = Source.OWN, run: int = 0, places: Mapping[str, list[tuple[float, float]]] | None = None
) -> EpisodeContext:
    """places: where each visit recorded a chair."""
    seen = {
        which: tuple(Sighting(view=0, instance="k", px=900, x=x, z=z) for x, z in (places or {}).get(which, ()))
        for which in VISITS
    }
    sightings = Sightings(episode=EPISODE.id, sightings=VisitPair[tuple[Sighting, ...]](**seen))
    arm = ArmJob(name="dualmap", kind=Kind.STATIC, agent="m:f", grounding=grounding, reading=Reading.NEAREST)
    return EpisodeContext(np.random.default_rng(0), run, SETTINGS, EPISODE, arm, Seen(*runs), sightings)


STAYED, BEFORE, AFTER, OTHER = (0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (5.0, 5.0)
CHANGED = maps(
    [entry(*STAYED), entry(*BEFORE), entry(*OTHER, LAMP)],
    [entry(*STAYED), entry(*AFTER, last_seen=7), entry(*OTHER, LAMP, last_seen=8)],
    [entry(*OTHER, LAMP), entry(*STAYED, 0.8 * CHAIR + 0.6 * LAMP), entry(*BEFORE), entry(*AFTER, 0.9 * CHAIR + 0.43589 * LAMP)],
)
PLACES = {"first": [STAYED, BEFORE], "second": [STAYED, AFTER]}


@pytest.mark.parametrize("relation", Relation)
def test_a_maintained_map_answers_every_relation_with_its_best_match(relation: Relation):
    assert predict_maintained(Query("Chair", relation), recorded(CHANGED)) == (Answer(*BEFORE), None)


@pytest.mark.parametrize("relation", Relation)
def test_with_grounding_handed_over_it_picks_among_the_places_of_both_visits(relation: Relation):
    outcome, evidence = predict_maintained(Query("Chair", relation), recorded(CHANGED, grounding=Source.HANDED, places=PLACES))
    assert outcome == UniformPick((STAYED, BEFORE, AFTER)) and evidence is None


def test_what_is_farther_from_every_instance_than_the_radius_is_not_handed_over():
    given = recorded(CHANGED, grounding=Source.HANDED, places={"first": [(2.0, 1.01)], "second": [(5.9, 5.9)]})
    assert predict_maintained(Query("Chair", Relation.FORMER), given)[0] == Abstention(AbstentionReason.NOTHING_GROUNDED)
    given = recorded(CHANGED, grounding=Source.HANDED, places={"first": [(2.0, 0.99)], "second": [(5.9, 5.9)]})
    assert predict_maintained(Query("Chair", Relation.FORMER), given)[0] == UniformPick((BEFORE,))


def test_an_empty_map_abstains_in_either_reading():
    nothing = maps([], [], [])
    for grounding in Source:
        for predict in (predict_maintained, predict_two_visits):
            outcome, _ = predict(Query("Chair", Relation.MOVED), recorded(nothing, grounding=grounding, places=PLACES))
            assert outcome == Abstention(AbstentionReason.NOTHING_GROUNDED)


@pytest.mark.parametrize("grounding", Source)
@pytest.mark.parametrize(
    ("relation", "place"),
    [
        (Relation.MOVED, AFTER),
        (Relation.FORMER, BEFORE),
        (Relation.STABLE, STAYED),
        (Relation.APPEARED, AFTER),
        (Relation.REMOVED, BEFORE),
        (Relation.MOVING, AFTER),
    ],
)
def test_two_maps_are_read_by_the_rules_of_the_reference_agent(grounding: Source, relation: Relation, place: tuple[float, float]):
    given = recorded(CHANGED, grounding=grounding, places=PLACES)
    assert predict_two_visits(Query("Chair", relation), given) == (Answer(*place), None)


def test_moving_is_the_latest_seen_of_what_is_new():
    walking = [entry(3.0 + k, 3.0, last_seen=seen) for k, seen in enumerate((4, 9, 6))]
    both = maps([entry(*STAYED)], [entry(*STAYED, last_seen=12), *walking], [])
    assert predict_two_visits(Query("Chair", Relation.MOVING), recorded(both))[0] == Answer(4.0, 3.0)


def test_each_run_answers_from_its_own_maps():
    other = maps([], [], [entry(7.0, 7.0)])
    answers = [predict_maintained(Query("Chair", Relation.STABLE), recorded(CHANGED, other, run=run))[0] for run in (0, 1)]
    assert answers == [Answer(*BEFORE), Answer(7.0, 7.0)]

"""One row an (episode, arm, seed): what became of each prediction and each run. The only place where an answer meets a
prediction."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.evaluation.scores import success_probability
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer, Prediction
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.seeds import generator
from ovman.settings import Settings

OWN_SUCCESS = "own_success"
"""Key of a run record: the verdict on the agent's own task, of arms that have one."""
EXPECTED = "expected"


@dataclass(frozen=True, slots=True)
class Case:
    """What judging a prediction needs of an episode. answer: floor-plane (x, z) in metres, for MOVING where the mover was last
    seen; instances: how many instances the category has; alike: how many changes are
    of the kind that defines the episode, itself included; others: where the instances of the category other than the target were
    recorded in the visit that the answer belongs to, the first for past relations and the second for current ones; neighbour_m:
    how far the nearest of them, in that visit or in the second, is from the answer, None where there is none."""

    id: str
    scene: str
    relation: Relation
    category: str
    instances: int
    answer: tuple[float, float]
    others: tuple[tuple[float, float], ...] = ()
    neighbour_m: float | None = None
    alike: int = 1

    @classmethod
    def of(cls, episode: Episode) -> Case:
        """What judging needs of an episode."""
        world = episode.world_1 if episode.relation.past else episode.world_2
        others, later = (
            tuple(i.position for i in here if i.category == episode.category and i.id != episode.target)
            for here in (world, episode.world_2)
        )
        return cls(
            id=episode.id,
            scene=episode.scene,
            relation=episode.relation,
            category=episode.category,
            instances=episode.instances_in_category,
            alike=len(episode.alike),
            answer=episode.answer,
            others=others,
            neighbour_m=min((math.dist(place, episode.answer) for place in others + later), default=None),
        )


@dataclass(frozen=True, slots=True)
class StaticOutcome:
    """A prediction judged. outcome: "answered", "abstained" (reason says why) or "expected", where the arm is a stochastic pick.

    distance_m: from the predicted point to the answer, None unless answered. success: 1 or 0; for "expected" its probability.
    other_m: from the predicted point to the nearest of ``Case.others``, None unless answered and there is one. confidence: how
    probable the arm holds its answer, None where it does not say.
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
    reason: str | None
    distance_m: float | None
    success: float
    other_m: float | None = None
    confidence: float | None = None


@dataclass(frozen=True, slots=True)
class EmbodiedOutcome:
    """A judged run. outcome: how it ended; path_length_m: what the agent travelled; spl: Eq. 5.

    own_success: whether it succeeds on the task of its own that the agent was made for, None where it has none.
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
    success: bool
    spl: float
    path_length_m: float
    actions: int
    own_success: bool | None = None


def read_cases(episodes_file: Path) -> list[Case]:
    """The episodes of a JSONL file, in its order. RecordError, one line, as `Episode.load`."""
    return [Case.of(episode) for episode in Episode.load(episodes_file)]


def outcomes_of(episodes_file: Path, prediction_files: Sequence[Path], constants: Settings) -> list[StaticOutcome]:
    """The static outcomes of the predictions of these files, as `static_outcomes`, which see.

    constants: success.radius_m, single_visit.samples, benchmark.seed. RecordError, one line, for a file that cannot be read.
    """
    predictions = [prediction for file in prediction_files for prediction in Prediction.read(file)]
    return judged(read_cases(episodes_file), predictions, constants)


def judged(cases: Sequence[Case], predictions: Iterable[Prediction], constants: Settings) -> list[StaticOutcome]:
    """`static_outcomes` under the benchmark's success test. constants: as of `outcomes_of`."""
    return static_outcomes(
        cases,
        predictions,
        radius_m=constants.success.radius_m,
        samples=constants.single_visit.samples,
        seed=constants.benchmark.seed,
    )


def is_expectation(outcome: StaticOutcome | EmbodiedOutcome) -> bool:
    """Whether its success is the expectation over a stochastic pick, which no run is."""
    return outcome.outcome == EXPECTED


def static_outcomes(
    cases: Sequence[Case], predictions: Iterable[Prediction], *, radius_m: float, samples: int, seed: int
) -> list[StaticOutcome]:
    """Every prediction against the answer of its episode, in the order of the predictions.

    The static gate: a predicted point succeeds within radius_m of the answer on the floor plane; an abstention fails; a
    stochastic pick contributes its probability of success. samples: Monte Carlo draws of a pick from a box, seeded by ``seed``
    and the episode, so that a result does not depend on which other episodes there are.

    Raises ValueError unless each (arm, seed) answers every episode exactly once.
    """
    by_id = {case.id: case for case in cases}
    outcomes = []
    for prediction in predictions:
        case = _case(by_id, prediction.episode, prediction.arm)
        reason, distance, other, confidence = None, None, None, None
        match prediction.outcome:
            case Answer(x, z, sure):
                distance, confidence = math.dist((x, z), case.answer), sure
                other = min((math.dist((x, z), point) for point in case.others), default=None)
                outcome, success = "answered", float(distance <= radius_m)
            case Abstention(why):
                outcome, reason, success = "abstained", str(why), 0.0
            case pick:
                draws = generator(seed, "single_visit", case.id)
                outcome = EXPECTED
                success = success_probability(pick, case.answer, radius_m, samples=samples, generator=draws)
        outcomes.append(
            StaticOutcome(
                episode=case.id,
                scene=case.scene,
                relation=case.relation,
                category=case.category,
                instances=case.instances,
                alike=case.alike,
                arm=prediction.arm,
                seed=prediction.seed,
                outcome=outcome,
                reason=reason,
                distance_m=distance,
                success=success,
                other_m=other,
                confidence=confidence,
            )
        )
    _complete(by_id, outcomes)
    return outcomes


def embodied_outcomes(cases: Sequence[Case], runs: Iterable[Score]) -> list[EmbodiedOutcome]:
    """Every judged run beside its episode, in the order of the runs.

    Raises ValueError unless each (arm, seed) runs every episode exactly once.
    """
    by_id = {case.id: case for case in cases}
    outcomes = []
    for run in runs:
        case = _case(by_id, run.episode, run.arm)
        outcomes.append(
            EmbodiedOutcome(
                episode=case.id,
                scene=case.scene,
                relation=case.relation,
                category=case.category,
                instances=case.instances,
                alike=case.alike,
                arm=run.arm,
                seed=run.seed,
                outcome=run.outcome,
                success=run.success,
                spl=run.spl,
                path_length_m=run.path_length_m,
                actions=run.actions,
                own_success=run.own_success,
            )
        )
    _complete(by_id, outcomes)
    return outcomes


def _case(by_id: Mapping[str, Case], episode: str, arm: str) -> Case:
    if episode not in by_id:
        raise ValueError(f"{arm} answers {episode}, which is not among the episodes; make its records again")
    return by_id[episode]


def _complete(by_id: Mapping[str, Case], outcomes: Iterable[StaticOutcome | EmbodiedOutcome]) -> None:
    answered: dict[tuple[str, int], set[str]] = {}
    for outcome in outcomes:
        episodes = answered.setdefault((outcome.arm, outcome.seed), set())
        if outcome.episode in episodes:
            raise ValueError(f"{outcome.arm}, seed {outcome.seed}: {outcome.episode} is there twice")
        episodes.add(outcome.episode)
    for (arm, seed), episodes in answered.items():
        missing = sorted(by_id.keys() - episodes)
        if missing:
            raise ValueError(f"{arm}, seed {seed}: {len(missing)} episodes are missing, the first is {missing[0]}")

"""One run of an arm on an episode under one seed, from the record of the episode: what it is given, and what is kept of it.

An arm that is given positions needs the episode's sightings, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.interface import CameraPose, Observation, PrivilegedAnswer, SeenInstance, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import RolloutContext, agent_settings, run_settings
from ovman.evaluation.driving import Limits
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.predictions import VISITS
from ovman.evaluation.rollout import Start, alias, play, start
from ovman.evaluation.supervision import Supervised, failures, function
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer
from ovman.records.relation import Relation
from ovman.records.run import Rollout
from ovman.records.sighting import Sighting, Sightings
from ovman.settings import Source
from ovman.settings.arms import ArmJob
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from ovman.workflow.parameter import StageSettings

DRAWS = ("picks", "paths")
"""What an agent draws: its own picks, and the order of paths of equal length."""


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One run that has not begun.

    session: as `session_for` makes it. settings: of the stage `rollouts` for a job of the arm. store: of the episode's scene.
    sightings: of the episode, for an arm that is given positions. answered: what the arm that this one executes answered, offered
    to the agent; None where it is not known. Nothing else is read: the run follows from the episode.
    """

    session: Session
    episode: Episode
    arm: ArmJob
    seed: int
    settings: StageSettings
    store: ObservationStore
    sightings: Sightings | None = None
    answered: Answer | Abstention | None = None

    def context(self) -> RolloutContext:
        """What the agent is made with."""
        privileged = None
        if self.arm.answer is Source.HANDED:
            follow = self._name_of(self.episode.target) if self.episode.relation is Relation.MOVING else None
            privileged = PrivilegedAnswer(self.episode.answer, follow)
        pilot = Pilot(self.episode.protocol.primitives, self._draws("paths"))
        settings = agent_settings(self.episode, self.settings)
        return RolloutContext(self._draws("picks"), settings, pilot, self.store, privileged, self.answered)

    def tour(self, which: str, reachable: np.ndarray) -> Visit:
        """The visit "first" or "second" as the arm is given it; reachable: positions (K, 2) in metres.

        ValueError where the arm is given positions and there are no sightings.
        """
        if self.arm.positions is not Source.HANDED:
            return self.store.visit(self.episode.visits[which], reachable)
        if self.arm.answer is Source.HANDED:
            return Visit((), reachable)
        if self.sightings is None:
            raise ValueError(f"arms.{self.arm.name} is given positions: it needs the sightings of {self.episode.id}")
        seen, min_mask_px = self.sightings.sightings[which], self.settings.admissibility.min_mask_px
        return _true_tour(self.episode.visits[which], seen, self.episode.category, min_mask_px, reachable)

    def start(self) -> Start:
        """The world of visit 2 with the agent at its spawn. SimulatorError if the simulator refuses."""
        drawn_from = (self.episode.provenance.seed, "actuation", self.arm.name, self.episode.id, self.seed)
        second = self.episode.tours.second  # a run meets its light, and its own sensors err as those of the tour do
        sensed = seeds.integer(self.episode.provenance.seed, "sensors", self.arm.name, self.episode.id, self.seed)
        return start(
            self.session,
            self.episode,
            self._name_of if self.arm.positions is Source.HANDED else None,
            self._draws("mover"),
            run_settings(self.episode, self.settings),
            Limits(self.arm.budget, self.arm.marks, self.arm.any_instance),
            seeds.integer(*drawn_from) if self.session.embodiment.noisy else None,
            second.light,
            None if second.sensors is None else second.sensors.model_copy(update={"seed": sensed}),
        )

    def words(self, of: str) -> list[int]:
        """Four 64-bit words that the generator of what is drawn starts from. of: one of `DRAWS`."""
        return [int(word) for word in self._sequence(of).generate_state(4, np.uint64)]

    def _draws(self, of: str) -> np.random.Generator:
        return np.random.default_rng(self._sequence(of))

    def _sequence(self, of: str) -> np.random.SeedSequence:
        return seeds.sequence(self.episode.provenance.seed, of, self.arm.name, self.episode.id, self.seed)

    def _name_of(self, instance: str) -> str:
        return alias(self.episode.visits.second, instance)


def session_for(episode: Episode, arm: ArmJob, settings: StageSettings) -> Session:
    """A session on the scene of an episode, with the body that an arm names. A context manager."""
    measured_by = run_settings(episode, settings)
    return Session(episode.scene, measured_by, Embodiment.named(arm.embodiment, measured_by))


def run_episode(
    session: Session,
    episode: Episode,
    arm: ArmJob,
    seed: int,
    settings: StageSettings,
    store: ObservationStore | None = None,
    sightings: Sightings | None = None,
    made: Callable[[Attempt], Any] | None = None,
    answered: Answer | Abstention | None = None,
) -> Rollout:
    """One run of an embodied arm on an episode; parameters as of `Attempt`.

    made: what makes the agent, the arm's function with its context where it is None.
    AgentError, in one line, where the agent fails; ValueError
    where sightings are missing.
    """
    lens = episode.protocol.camera.field_of_view_deg
    store = ObservationStore(arm, settings, lens, VISITS / episode.scene) if store is None else store
    attempt = Attempt(session, episode, arm, seed, settings, store, sightings, answered)
    make = partial(_of_arm, function(arm.name, arm.agent)) if made is None else made
    with failures(f"arms.{arm.name}.agent is {arm.agent!r}: it"):
        agent = make(attempt)
    supervised = Supervised(agent, arm, f"{episode.id}, seed {seed}")
    started = attempt.start()
    first = attempt.tour("first", np.empty((0, 2)))
    measured = play(started, supervised, first, partial(attempt.tour, "second"), episode.query)
    return Rollout(episode=episode.id, arm=arm.name, seed=seed, trace=supervised.trace, **dict(measured))


def _of_arm(make: Callable[[RolloutContext], Any], attempt: Attempt) -> Any:
    return make(attempt.context())


def _true_tour(visit: str, sightings: Sequence[Sighting], category: str, min_mask_px: int, reachable: np.ndarray) -> Visit:
    """A recorded visit for an agent that is given positions: which instances each view recorded, and where."""
    views: dict[int, list[SeenInstance]] = {}
    for seen in sightings:
        if seen.px >= min_mask_px:
            views.setdefault(seen.view, []).append(SeenInstance(alias(visit, seen.instance), category, seen.x, seen.z))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)

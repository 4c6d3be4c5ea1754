"""The one loop in which every agent runs: the workflow's arms, `ovman eval`, remote agents and the replay of entries.

The agent gets observations and the query, and nothing else. The episode and what is measured stay on the evaluator's side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.interface import (
    LETTERS,
    Action,
    Agent,
    CameraPose,
    Instruction,
    Observation,
    PrivilegedAnswer,
    Query,
    SeenInstance,
    Visit,
)
from ovman.agents.pilot import Pilot
from ovman.env import Env, Terms, alias
from ovman.evaluation.context import RolloutContext, agent_settings, run_settings
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.supervision import SupervisedAgent, load_agent, name_failures
from ovman.evaluation.words import tell
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer
from ovman.records.run import Rollout
from ovman.records.task import Relation
from ovman.records.visit import Sighting, Sightings
from ovman.settings import Settings, Source
from ovman.settings.arms import ArmJob
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session

AGENT_DRAWS = ("picks", "paths")
"""What an agent draws: its own picks, and the order of paths of equal length."""
ACTIONS: Mapping[str, Action] = {letter: action for action, letter in LETTERS.items()}
"""Actions by the letters of a trace."""


def drive(
    env: Env, agent: Agent, tour: Callable[[str, np.ndarray], Visit], asked: Instruction, begin: Callable[[], None] = lambda: None
) -> None:
    """Run an agent to the end of an episode: both visits, the query, and actions.

    Args:
        env: Reset, without images.
        agent: Its attribute `looks`, after `ask`, says whether it takes images.
        tour: The visit "first" or "second", given the positions (K, 2) that can be reached.
        asked: The question.
        begin: Called before the agent gets its first observation.
    """
    agent.familiarise(tour("first", env.reachable_first))
    agent.revisit(tour("second", env.reachable))
    agent.ask(asked)
    begin()
    env.looks = getattr(agent, "looks", True)
    observation, done = env.observe(), False
    while not done:
        observation, done = env.step(agent.act(observation))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One run of an embodied arm on an episode under a seed. It follows from these values and from nothing else.

    Attributes:
        settings: Of the arm's job.
        store: Of the episode's scene; None for an agent that is given no observations but those of the run.
        sightings: Of the episode, for an arm with oracle positions.
        answered: The prediction of the arm that this one executes, offered to the agent; None if it is not known.
        nonce: Of the evaluation: what is sent to the agent and its draws follow from it, so that they name no episode to an agent
            that has a table of episodes. None: they follow from arm, episode and seed, and a run can be made again.
    """

    episode: Episode
    arm: ArmJob
    seed: int
    settings: Settings
    store: ObservationStore | None = None
    sightings: Sightings | None = None
    answered: Answer | Abstention | None = None
    nonce: str | None = None

    @property
    def asked(self) -> Instruction:
        """The question, as the arm is told it."""
        return tell(Query(self.episode.category, self.episode.relation), self.arm, self.episode)

    @property
    def embodiment(self) -> Embodiment:
        """The body and camera of the agent."""
        return Embodiment.named(self.arm.embodiment, run_settings(self.episode, self.settings))

    def context(self) -> RolloutContext:
        """Return the context that the agent is made with."""
        privileged = None
        if self.arm.answer is Source.HANDED:
            follow = self._name_of(self.episode.target) if self.episode.relation is Relation.MOVING else None
            privileged = PrivilegedAnswer(self.episode.answer, follow)
        picks, paths = (np.random.default_rng(self._agent_sequence(draws)) for draws in AGENT_DRAWS)
        pilot = Pilot(self.episode.protocol.primitives, paths, self.episode.rules.grid == "first")
        settings = agent_settings(self.episode, self.settings)
        store = self._store
        inputs = store.mapper, store.detections_in, store.load_artifact, store.noun, store.networks
        return RolloutContext(picks, settings, pilot, *inputs, privileged, self.answered)

    def tour(self, which: str, reachable: np.ndarray) -> Visit:
        """Return the visit "first" or "second" as the arm is given it; reachable: positions (K, 2) in metres.

        Raises:
            ValueError: The arm has oracle positions, and there are no sightings.
        """
        if self.arm.positions is not Source.HANDED:
            return self._store.visit(self.episode.visits[which], reachable)
        if self.arm.answer is Source.HANDED:
            return Visit((), reachable)
        if self.sightings is None:
            raise ValueError(f"arms.{self.arm.name} is given positions: it needs the sightings of {self.episode.id}")
        seen, min_mask_px = self.sightings.sightings[which], self.settings.admissibility.min_mask_px
        return _true_tour(self.episode.visits[which], seen, self.episode.category, min_mask_px, reachable)

    def terms(self, is_noisy: bool) -> Terms:
        """Return the terms of the run. is_noisy: Whether the moves of the arm's body are inexact.

        A run meets the light of the second tour, and its sensors err like those of that tour.
        """
        second = self.episode.tours.second
        sensors = None if second.sensors is None else second.sensors.model_copy(update={"seed": self._integer("sensors")})
        return Terms(
            mover_rng=np.random.default_rng(self._walk),
            actuation_seed=self._integer("actuation") if is_noisy else None,
            light=second.light,
            sensors=sensors,
            name_of=self._name_of if self.arm.positions is Source.HANDED else None,
            budget=self.arm.budget,
            marks=self.arm.marks,
            any_instance=self.arm.any_instance,
        )

    def words(self, draws: str) -> list[int]:
        """Return four 64-bit words from which a generator of the agent starts. draws: One of `AGENT_DRAWS`."""
        return [int(word) for word in self._agent_sequence(draws).generate_state(4, np.uint64)]

    def conceal(self, text: str | None) -> str | None:
        """Return a text as it is sent to the agent: equal for equal texts of the evaluation, unknown before it."""
        return text if text is None or self.nonce is None else seeds.conceal(self.nonce, text)

    @property
    def _walk(self) -> np.random.SeedSequence:
        if not self.episode.rules.same_walk:
            return self._sequence("mover")
        return seeds.sequence(self.episode.provenance.seed, "mover", self.episode.id, self.seed)

    @property
    def _store(self) -> ObservationStore:
        if self.store is not None:
            return self.store
        lens = self.episode.protocol.camera.field_of_view_deg
        return ObservationStore(self.arm, self.settings, lens, Path(self.episode.scene))

    def _integer(self, draws: str) -> int:
        return seeds.integer(self.episode.provenance.seed, draws, self.arm.name, self.episode.id, self.seed)

    def _sequence(self, draws: str) -> np.random.SeedSequence:
        return seeds.sequence(self.episode.provenance.seed, draws, self.arm.name, self.episode.id, self.seed)

    def _agent_sequence(self, draws: str) -> np.random.SeedSequence:
        if self.nonce is None:
            return self._sequence(draws)
        return np.random.SeedSequence(int(seeds.conceal(self.nonce, repr((draws, self.episode.id, self.seed))), 16))

    def _name_of(self, instance: str) -> str:
        return alias(self.episode.visits.second, instance)


def open_session(episode: Episode, arm: ArmJob, settings: Settings) -> Session:
    """Return a session on the scene of an episode, with the body that an arm names. A context manager."""
    measured_by = run_settings(episode, settings)
    return Session(episode.scene, measured_by, Embodiment.named(arm.embodiment, measured_by))


def open_env(session: Session, run: Run) -> Env:
    """Return the environment of a run, reset to its spawn, without images."""
    env = Env(session, run_settings(run.episode, run.settings))
    env.reset(run.episode, run.terms(session.embodiment.noisy), looks=False)
    return env


def run_episode(
    session: Session, run: Run, make_agent: Callable[[Run], Any] | None = None, begin: Callable[[], None] = lambda: None
) -> Rollout:
    """Make one run, measured and not judged.

    make_agent: Makes the agent; the function of the arm, with its context, if None. begin: As for `drive`.

    Raises:
        AgentError: The agent fails; the message is one line.
        ValueError: Sightings are missing.
        SimulatorError: The simulator refuses.
    """
    episode, arm = run.episode, run.arm
    with name_failures(f"arms.{arm.name}.agent is {arm.agent!r}: it"):
        made = make_agent(run) if make_agent is not None else load_agent(arm.name, arm.agent)(run.context())
    agent: Any = SupervisedAgent(made, arm, f"{episode.id}, seed {run.seed}")
    env = open_env(session, run)
    drive(env, agent, run.tour, run.asked, begin)
    return env.rollout(arm.name, run.seed)


def replay(session: Session, run: Run, trace: str) -> Rollout:
    """Make a run by the actions of a trace, without an agent. A run that goes on after them abstains."""
    env, done = open_env(session, run), False
    for letter in f"{trace}{LETTERS[Action.ABSTAIN]}":
        if not done:
            _, done = env.step(ACTIONS[letter])
    return env.rollout(run.arm.name, run.seed)


def _true_tour(visit: str, sightings: Sequence[Sighting], category: str, min_mask_px: int, reachable: np.ndarray) -> Visit:
    """Return a recorded visit for an agent with oracle positions: the instances that each view recorded, and their positions."""
    views: dict[int, list[SeenInstance]] = {}
    for seen in sightings:
        if seen.px >= min_mask_px:
            views.setdefault(seen.view, []).append(SeenInstance(alias(visit, seen.instance), category, seen.x, seen.z))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)

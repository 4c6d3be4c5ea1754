"""One rollout: an agent runs in the simulator from its spawn to its stop, and is measured there. The same for every agent."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Protocol

import numpy as np

from ovman.agents.interface import Action, Agent, Observation, Visit
from ovman.evaluation.driving import NO_LIMITS, Limits, cells, drive, observation
from ovman.records.change import Alteration, MoverStart
from ovman.records.geometry import Point, Spawn
from ovman.records.query import Query
from ovman.records.run import NOWHERE, InstanceTerms, Measured, Terms
from ovman.records.sensors import Light, Sensors
from ovman.settings import Settings
from ovman.sim import measurement
from ovman.sim.change import World
from ovman.sim.embodiment import Embodiment
from ovman.sim.light import illuminate
from ovman.sim.measurement import ReachableRegion
from ovman.sim.sensing import Sensing
from ovman.sim.session import AgentPose, Session
from ovman.workflow.journal import digest


class Runnable(Protocol):
    """The part of an episode that a run depends on; a trial that is being certified has it, too."""

    @property
    def query(self) -> Query:
        """What the agent is asked."""

    @property
    def target(self) -> str:
        """Id of the instance that the query means."""

    @property
    def spawn(self) -> Spawn:
        """Where the run begins."""

    @property
    def answer(self) -> Point:
        """Floor-plane point in metres; for MOVING where the mover is when the run begins."""

    @property
    def nearest_navigable(self) -> Point:
        """nu(a): the cell nearest to the answer that the benchmark's own body can reach."""

    @property
    def movers(self) -> tuple[MoverStart, ...]:
        """The states of the movers when the run begins; none where nothing moves."""

    @property
    def gone(self) -> frozenset[str]:
        """Ids of the instances that are absent from visit 2."""

    def alterations(self, visit: str) -> tuple[Alteration, ...]:
        """What differs from the untouched scene in the visit "first" or "second"."""


@cache
def alias(visit: str, instance: str) -> str:
    """The name of an instance for an agent that is given positions, within one visit; it says nothing about the other."""
    return digest(visit, instance)[:8]


def begin(session: Session, episode: Runnable, settings: Settings, rng: np.random.Generator, every_object: bool = False) -> World:
    """The world of visit 2 with its movers where the recorded visit left them; `rng` drives them.

    every_object: whether the session reports all objects from then on, or those of the query's category alone. settings: mover.*.
    SimulatorError if the simulator refuses.
    """
    category = episode.query.category

    def of_category(metadata: Mapping[str, Any]) -> bool:
        return bool(metadata["objectType"] == category)

    world = World(session, episode.alterations("second"), settings.mover, rng, None if every_object else of_category)
    world.send_movers_to(episode.movers)
    return world


def measure_at_stop(
    session: Session,
    episode: Runnable,
    world: World,
    settings: Settings,
    region: ReachableRegion | None = None,
    any_instance: bool = False,
) -> tuple[Terms, Mapping[str, InstanceTerms]]:
    """The terms of Eq. 4 where the agent stands, and with any_instance those of every instance of the category by id.

    region: what the agent could reach from its spawn; without it `nearest_navigable` holds. Where the target moves, its
    present place is the answer, and nu(a) is found anew. settings: primitives.step_m and success.sweep_deg.
    """
    answer, navigable = episode.answer, episode.nearest_navigable
    if episode.target in world.movers:
        answer = world.movers[episode.target].position
        region = ReachableRegion.around(session, session.pose, settings.primitives.step_m)
    if region is not None:
        navigable = region.navigable(*answer)
    instances: list[str] = []
    if any_instance:
        category, gone = episode.query.category, episode.gone
        instances = [k for k, o in session.objects.items() if o["objectType"] == category and k not in gone]
    sweep, past = tuple(settings.success.sweep_deg), episode.query.relation.past
    return measurement.at_stop(session, past, episode.target, answer, navigable, sweep, instances)


@dataclass(frozen=True, slots=True)
class Start:
    """A run whose agent stands at its spawn and has not acted.

    reachable: positions (K, 2) in metres that can be reached from there, none for an agent with a body of its own. drive: given
    whether the agent takes images, the run itself. It yields observations, is sent actions, and returns what was measured.
    """

    reachable: np.ndarray
    drive: Callable[[bool], Generator[Observation, Action, Measured]]


def start(
    session: Session,
    episode: Runnable,
    name_of: Callable[[str], str] | None,
    rng: np.random.Generator,
    settings: Settings,
    limits: Limits = NO_LIMITS,
    noise: int | None = None,
    light: Light | None = None,
    sensors: Sensors | None = None,
) -> Start:
    """The world of visit 2 with the agent at the spawn. Parameters as of `roll_out`. SimulatorError if the simulator refuses."""
    world = begin(session, episode, settings, rng)
    if noise is not None:
        session.step("SetRandomSeed", seed=noise)
    illuminate(session, light)
    sensing = None if sensors is None else Sensing(sensors)
    spawn = AgentPose(episode.spawn.x, episode.spawn.z, episode.spawn.yaw_deg)
    session.teleport(spawn)
    own_body = session.embodiment.mode != Embodiment.of(settings).mode
    region = None if own_body else ReachableRegion.around(session, spawn, settings.primitives.step_m)

    def run(looks: bool) -> Generator[Observation, Action, Measured]:
        sees = looks and name_of is None
        observe = partial(observation, session, sees, episode.gone, name_of, sensing)
        driven = yield from drive(session, world, observe, own_body, sees, settings, limits)
        at_stop, instances = NOWHERE, None
        if driven.outcome == "stopped":
            at_stop, found = measure_at_stop(session, episode, world, settings, region, limits.any_instance)
            instances = found or None
        return Measured(
            **dict(at_stop),
            outcome=driven.outcome,
            path_length_m=round(driven.path_length_m, 4),
            actions=driven.actions,
            instances=instances,
            path_at_m=driven.path_at_m if limits.marks else None,
        )

    return Start(np.empty((0, 2)) if region is None else cells(region), run)


def roll_out(
    session: Session,
    episode: Runnable,
    agent: Agent,
    first: Visit | None,
    second: Callable[[np.ndarray], Visit],
    name_of: Callable[[str], str] | None,
    rng: np.random.Generator,
    settings: Settings,
    limits: Limits = NO_LIMITS,
    noise: int | None = None,
    light: Light | None = None,
    sensors: Sensors | None = None,
) -> Measured:
    """One run of an agent.

    first: what the agent is familiarised with, None for an agent that needs nothing; second: its second visit, given the
    reachable positions (K, 2) around the spawn; name_of: names of the instances in the positions that an agent is given, None for
    an agent without positions. `rng` drives the movers. settings: sections camera, primitives and mover and success.sweep_deg.
    noise: seed of the actuation noise of a noisy body. light: of the run, None for the scene's own. sensors: what the agent
    senses depth and poses with, None for exact ones; it is measured by the true ones.

    Agents with a body of their own get no reachable grid and are exempt from the stall rule. An agent that is given positions, or
    whose attribute `looks` is False, gets no images. Deterministic for a deterministic simulator. SimulatorError if it refuses.
    """
    started = start(session, episode, name_of, rng, settings, limits, noise, light, sensors)
    return play(started, agent, first, second, episode.query)


def play(started: Start, agent: Agent, first: Visit | None, second: Callable[[np.ndarray], Visit], query: Query) -> Measured:
    """The run of an agent from its start: both visits, the query, and actions until it ends. Parameters as of `roll_out`."""
    if first is not None:
        agent.familiarise(first)
    agent.revisit(second(started.reachable))
    agent.ask(query)
    driving = started.drive(getattr(agent, "looks", True))
    proceed = partial(next, driving)
    while True:
        try:
            seen = proceed()
        except StopIteration as ended:
            measured: Measured = ended.value
            return measured
        proceed = partial(driving.send, agent.act(seen))

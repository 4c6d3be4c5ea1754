"""One rollout: an agent runs in the simulator from its spawn to its stop, and is measured there. The same for every agent."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Protocol

import numpy as np

from ovman.agents.interface import Action, Agent, CameraPose, Observation, SeenInstance, Visit
from ovman.models.change import Alteration, MoverStart
from ovman.models.geometry import Point, Spawn
from ovman.models.query import Query
from ovman.models.run import NOWHERE, InstanceTerms, Measured, Outcome, Terms
from ovman.models.sensors import Light, Sensors
from ovman.models.settings import Settings
from ovman.sim import measurement
from ovman.sim.change import World, dynamic, position
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


@dataclass(frozen=True, slots=True)
class Limits:
    """The terms of an arm's runs that are not the benchmark's for all.

    budget: of actions, primitives.action_budget where it is None. marks: numbers of actions at which the path length is recorded
    ("path_at_m"), for arms that cut the run there. any_instance: whether every instance of the category is measured at the stop
    ("instances"), for an agent whose own task is to reach one.
    """

    budget: int | None = None
    marks: Sequence[int] = ()
    any_instance: bool = False


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


def roll_out(
    session: Session,
    episode: Runnable,
    agent: Agent,
    first: Visit | None,
    second: Callable[[np.ndarray], Visit],
    name_of: Callable[[str], str] | None,
    rng: np.random.Generator,
    settings: Settings,
    limits: Limits = Limits(),
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
    world = begin(session, episode, settings, rng)
    if noise is not None:
        session.step("SetRandomSeed", seed=noise)
    illuminate(session, light)
    sensing = None if sensors is None else Sensing(sensors)
    spawn = AgentPose(episode.spawn.x, episode.spawn.z, episode.spawn.yaw_deg)
    session.teleport(spawn)
    own_body = session.embodiment.mode != Embodiment.of(settings).mode
    region = None if own_body else ReachableRegion.around(session, spawn, settings.primitives.step_m)
    if first is not None:
        agent.familiarise(first)
    agent.revisit(second(np.empty((0, 2)) if region is None else cells(region)))
    agent.ask(episode.query)

    looks = name_of is None and getattr(agent, "looks", True)
    observe = partial(_observation, session, looks, episode.gone, name_of, sensing)
    driven = _driven(session, world, agent, observe, own_body, looks, settings, limits)
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


@dataclass(frozen=True, slots=True)
class _Driven:
    """From the spawn to the end of a run; path_at_m: the path length by the number of actions, at each mark that was reached."""

    outcome: Outcome
    path_length_m: float
    actions: int
    path_at_m: Mapping[int, float]


def _driven(
    session: Session,
    world: World,
    agent: Agent,
    observe: Callable[[bool, np.ndarray | None], Observation],
    own_body: bool,
    looks: bool,
    settings: Settings,
    limits: Limits,
) -> _Driven:
    """observe: what the agent sees, given whether its last action succeeded, and what can be reached now (None: as before).

    Where nothing else moves after an action, the image of the action is the agent's next one.
    """
    step_m = settings.primitives.step_m
    budget = settings.primitives.action_budget if limits.budget is None else limits.budget
    travelled, actions, since_moved, succeeded = 0.0, 0, 0, True
    movers_in: list[tuple[int, int]] = []
    path_at_m: dict[int, float] = {}
    outcome: Outcome = "budget"
    while actions < budget:
        reachable = None
        if world.movers and not own_body:
            movers_in, before_in = [_cell(mover.position, step_m) for mover in world.movers.values()], movers_in
            if movers_in != before_in:
                reachable = cells(ReachableRegion.around(session, session.pose, step_m))
        action = agent.act(observe(succeeded, reachable))
        if action in (Action.STOP, Action.ABSTAIN):
            outcome = "stopped" if action is Action.STOP else "abstained"
            break
        before = session.pose
        done = session.step(action.value, image=looks and not world.movers, allowed=True)
        succeeded = bool(done.metadata["lastActionSuccess"])
        after = session.pose
        moved = math.hypot(after.x - before.x, after.z - before.z)
        travelled, actions = travelled + moved, actions + 1
        if actions in limits.marks:
            path_at_m[actions] = round(travelled, 4)
        since_moved = 0 if moved > 0 else since_moved + 1
        world.after_action()
        if since_moved >= settings.primitives.stall_after and not own_body:
            outcome = "stalled"
            break
    return _Driven(outcome, travelled, actions, path_at_m)


def _cell(point: tuple[float, float], step_m: float) -> tuple[int, int]:
    return round(point[0] / step_m), round(point[1] / step_m)


def cells(region: ReachableRegion) -> np.ndarray:
    """The positions (K, 2) in metres that can be reached, sorted."""
    return np.array([region.grid.centre(c) for c in sorted(region.grid.cells)])


def _observation(
    session: Session,
    looks: bool,
    gone: Collection[str],
    name_of: Callable[[str], str] | None,
    sensing: Sensing | None,
    succeeded: bool,
    reachable: np.ndarray | None,
) -> Observation:
    pose = session.pose if sensing is None else sensing.pose(session.pose)
    camera = CameraPose(pose.x, session.camera["y"], pose.z, pose.yaw_deg, pose.horizon_deg)
    field_of_view_deg = session.embodiment.field_of_view_deg
    if looks:
        if session.rgb is None:
            session.step("Pass", image=True)
        depth = session.depth if sensing is None or session.depth is None else sensing.depth(session.depth)
        return Observation(session.rgb, depth, camera, field_of_view_deg, succeeded, None, reachable)
    if name_of is None:
        return Observation(None, None, camera, field_of_view_deg, succeeded, None, reachable)
    present = {k: o for k, o in session.objects.items() if dynamic(o) and k not in gone}
    at = {k: position(o) for k, o in present.items()}
    positions = tuple(SeenInstance(name_of(k), present[k]["objectType"], at[k].x, at[k].z) for k in sorted(at))
    return Observation(None, None, camera, field_of_view_deg, succeeded, positions, reachable)

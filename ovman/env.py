"""One episode in the simulator, as an agent experiences it: reset, step, score. The same for every agent.

An environment gives an agent observations and nothing else. What it measures at the end stays with the evaluator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np

from ovman.agents.interface import LETTERS, Action, CameraPose, Observation, SeenInstance
from ovman.cache import digest
from ovman.evaluation.scores import score_rollout
from ovman.records.episode import Episode
from ovman.records.geometry import Point, Spawn
from ovman.records.record import METRE_DECIMALS
from ovman.records.run import NOWHERE, InstanceTerms, Measured, Outcome, Rollout, Score
from ovman.records.run import Terms as StopTerms
from ovman.records.scene import Alteration, MoverStart
from ovman.records.task import Query
from ovman.records.tour import Light, Sensors
from ovman.settings import Settings
from ovman.settings.splits import Rules
from ovman.sim import measurement
from ovman.sim.embodiment import Embodiment
from ovman.sim.measurement import ReachableRegion
from ovman.sim.sensing import Sensing
from ovman.sim.session import AgentPose, Session, illuminate
from ovman.sim.world import World, is_dynamic, position

REACHED = 64
"""Number of grids of visit 1 that a process keeps: all runs of a world pair have one in common."""
_REACHED: dict[Any, np.ndarray] = {}


class Runnable(Protocol):
    """The part of an episode that a run depends on; a trial that is being certified has it, too."""

    @property
    def query(self) -> Query:
        """The question that the agent is asked."""

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

    @property
    def rules(self) -> Rules:
        """The rules of the split's runs."""

    def rivals(self, now: Mapping[str, Point] = {}) -> tuple[Point, ...]:
        """Return the places that are wrong answers if success is exclusive, none if not. now: Present places of movers."""

    def alterations(self, visit: str) -> tuple[Alteration, ...]:
        """Return the differences from the untouched scene in the visit "first" or "second"."""


@dataclass(frozen=True, slots=True)
class Terms:
    """The terms of a run that its episode does not say.

    Attributes:
        mover_rng: Drives the movers.
        actuation_seed: Seed of the actuation noise, for a body whose moves are inexact.
        light: Light of the second visit, None for the scene's own.
        sensors: Errors of depth and pose that the agent senses, None for exact ones. The run is measured by the true ones.
        name_of: Names of instances, for an agent with oracle positions: it is given positions and no images.
        budget: Number of actions, None for primitives.action_budget.
        marks: Numbers of actions at which the path length is recorded, for arms that cut the run there.
        any_instance: Whether every instance of the category is measured at the stop, for an agent whose own task is to reach one.
    """

    mover_rng: np.random.Generator
    actuation_seed: int | None = None
    light: Light | None = None
    sensors: Sensors | None = None
    name_of: Callable[[str], str] | None = None
    budget: int | None = None
    marks: tuple[int, ...] = ()
    any_instance: bool = False


class Env:
    """The second visit of an episode with an agent in it.

    `reset` puts the agent at the spawn, `step` executes an action. A run ends when the agent stops or abstains, has spent its
    budget, or has not moved for primitives.stall_after actions; an agent with a body of its own is exempt from the last rule and
    gets no grid of reachable positions. Deterministic for a deterministic simulator.

    Attributes:
        looks: Whether observations have images. Nothing is rendered if not.
        reachable: Positions (K, 2) in metres that the agent can reach from its spawn, as the agent is told them; by a rule of the
            split those of visit 1.
        reachable_first: The same for visit 1; none without that rule.
        trace: Actions until now, one letter per action (`LETTERS`).
        measured: The measurements of the run, once it is over.
    """

    def __init__(self, session: Session, settings: Settings) -> None:
        """Prepare an environment; the simulator starts at the first reset.

        session: with the body of the agent. settings: sections camera, primitives and mover, and success.sweep_deg.
        """
        self.session, self._settings = session, settings
        self._own_body = session.embodiment.mode != Embodiment.of(settings).mode
        self.looks = True

    def reset(self, episode: Runnable, terms: Terms, looks: bool = True) -> Observation:
        """Put the agent at the spawn in the second visit, and return the first observation.

        Raises:
            SimulatorError: The simulator refuses.
        """
        self._episode, self._terms, self.looks = episode, terms, looks
        self._is_outdated = episode.rules.grid == "first" and not self._own_body
        self.reachable_first = self._reach_first() if self._is_outdated else np.empty((0, 2))
        self._world = prepare_world(self.session, episode, self._settings, terms.mover_rng)
        if terms.actuation_seed is not None:
            self.session.step("SetRandomSeed", seed=terms.actuation_seed)
        illuminate(self.session, terms.light)
        self._sensing = None if terms.sensors is None else Sensing(terms.sensors)
        spawn = AgentPose(episode.spawn.x, episode.spawn.z, episode.spawn.yaw_deg)
        self.session.teleport(spawn)
        self._region = None if self._own_body else ReachableRegion.around(self.session, spawn, self._step_m)
        self.reachable = self.reachable_first
        if self._region is not None and not self._is_outdated:
            self.reachable = _cells(self._region)
        self.trace, self._succeeded, self._path_m, self._actions, self._since_moved = "", True, 0.0, 0, 0
        self._path_at_m: dict[int, float] = {}
        self._mover_cells: list[tuple[int, int]] = []
        self._now_reachable = self._reachable_if_moved()
        self._seen = self.observe()
        return self._seen

    def step(self, action: Action) -> tuple[Observation, bool]:
        """Execute an action; return what the agent sees then, and whether the run is over.

        Nothing is rendered after the end: the observation is the one before the last action.
        """
        self.trace += LETTERS[action]
        outcome = self._execute(action)
        if outcome is not None:
            self.measured = self._measure(outcome)
            return self._seen, True
        self._now_reachable = self._reachable_if_moved()
        self._seen = self.observe()
        return self._seen, False

    def observe(self) -> Observation:
        """Return what the agent sees where it stands."""
        pose = self.session.pose if self._sensing is None else self._sensing.pose(self.session.pose)
        camera = CameraPose(pose.x, self.session.camera["y"], pose.z, pose.yaw_deg, pose.horizon_deg)
        rgb = depth = None
        if self._renders:
            if self.session.rgb is None:
                self.session.step("Pass", image=True)
            rgb, depth = self.session.rgb, self.session.depth
            if self._sensing is not None and depth is not None:
                depth = self._sensing.depth(depth)
        positions = None if self._terms.name_of is None else self._positions(self._terms.name_of)
        field_of_view_deg = self.session.embodiment.field_of_view_deg
        return Observation(rgb, depth, camera, field_of_view_deg, self._succeeded, positions, self._now_reachable)

    def rollout(self, arm: str, seed: int) -> Rollout:
        """Return the record of the run that is over, as one of an arm on a released episode under a seed."""
        assert isinstance(self._episode, Episode)
        return Rollout(episode=self._episode.id, arm=arm, seed=seed, trace=self.trace, **dict(self.measured))

    def score(self, arm: str, seed: int) -> Score:
        """Judge the run that is over."""
        assert isinstance(self._episode, Episode)
        return score_rollout(self.rollout(arm, seed), self._episode, self._terms.any_instance)

    @property
    def _step_m(self) -> float:
        return self._settings.primitives.step_m

    @property
    def _renders(self) -> bool:
        return self.looks and self._terms.name_of is None

    def _execute(self, action: Action) -> Outcome | None:
        """Execute an action; return how the run ends with it, None if it goes on."""
        if action in (Action.STOP, Action.ABSTAIN):
            return "stopped" if action is Action.STOP else "abstained"
        before = self.session.pose
        # If nothing else moves after the action, its image is the agent's next one.
        done = self.session.step(action.value, image=self._renders and not self._world.movers, allowed=True)
        self._succeeded = bool(done.metadata["lastActionSuccess"])
        moved_m = math.hypot(self.session.pose.x - before.x, self.session.pose.z - before.z)
        self._path_m, self._actions = self._path_m + moved_m, self._actions + 1
        if self._actions in self._terms.marks:
            self._path_at_m[self._actions] = round(self._path_m, 4)
        self._since_moved = 0 if moved_m > 0 else self._since_moved + 1
        self._world.after_action()
        primitives = self._settings.primitives
        if self._since_moved >= primitives.stall_after and not self._own_body:
            return "stalled"
        budget = primitives.action_budget if self._terms.budget is None else self._terms.budget
        return "budget" if self._actions >= budget else None

    def _reach_first(self) -> np.ndarray:
        """Return the positions that could be reached from the spawn in visit 1; the simulator may be left in that visit."""
        alterations, spawn = self._episode.alterations("first"), self._episode.spawn
        key = self.session.scene, alterations, (spawn.x, spawn.z), self._step_m
        if key not in _REACHED:
            World(self.session, alterations, self._settings.mover, np.random.default_rng(0))
            pose = AgentPose(spawn.x, spawn.z, spawn.yaw_deg)
            self.session.teleport(pose)
            if len(_REACHED) >= REACHED:
                _REACHED.clear()
            _REACHED[key] = _cells(ReachableRegion.around(self.session, pose, self._step_m))
            _REACHED[key].flags.writeable = False  # agents get it
        return _REACHED[key]

    def _reachable_if_moved(self) -> np.ndarray | None:
        """Return the positions that can be reached now if a mover has come to another cell, None if the last ones hold."""
        if not self._world.movers or self._own_body or self._is_outdated:
            return None
        before, self._mover_cells = self._mover_cells, [self._cell(one.position) for one in self._world.movers.values()]
        if self._mover_cells == before:
            return None
        return _cells(ReachableRegion.around(self.session, self.session.pose, self._step_m))

    def _cell(self, point: tuple[float, float]) -> tuple[int, int]:
        return round(point[0] / self._step_m), round(point[1] / self._step_m)

    def _positions(self, name_of: Callable[[str], str]) -> tuple[SeenInstance, ...]:
        gone = self._episode.gone
        present = {k: o for k, o in self.session.objects.items() if is_dynamic(o) and k not in gone}
        at = {k: position(o) for k, o in present.items()}
        return tuple(SeenInstance(name_of(k), present[k]["objectType"], at[k].x, at[k].z) for k in sorted(at))

    def _measure(self, outcome: Outcome) -> Measured:
        stop, instances = NOWHERE, None
        if outcome == "stopped":
            stop, found = measure_at_stop(
                self.session, self._episode, self._world, self._settings, self._region, self._terms.any_instance
            )
            instances = found or None
        return Measured(
            **dict(stop),
            outcome=outcome,
            path_length_m=round(self._path_m, 4),
            actions=self._actions,
            instances=instances,
            path_at_m=self._path_at_m if self._terms.marks else None,
        )


@cache
def alias(visit: str, instance: str) -> str:
    """Return the name of an instance for an agent with oracle positions: it holds within one visit only."""
    return digest(visit, instance)[:8]


def prepare_world(
    session: Session, episode: Runnable, settings: Settings, rng: np.random.Generator, every_object: bool = False
) -> World:
    """Return the world of visit 2, with its movers where the recorded visit left them.

    every_object: Whether the session reports all objects from then on, or only those of the query's category.
    """
    category = episode.query.category

    def is_of_category(metadata: Mapping[str, Any]) -> bool:
        return bool(metadata["objectType"] == category)

    world = World(session, episode.alterations("second"), settings.mover, rng, None if every_object else is_of_category)
    world.send_movers_to(episode.movers)
    return world


def measure_at_stop(
    session: Session,
    episode: Runnable,
    world: World,
    settings: Settings,
    region: ReachableRegion | None = None,
    any_instance: bool = False,
) -> tuple[StopTerms, Mapping[str, InstanceTerms]]:
    """Measure the terms of Eq. 4 where the agent stands, and with any_instance those of every instance of the category by id.

    If the target moves, its present place is the answer, and nu(a) is computed again. region: what the agent could reach from its
    spawn; without it the episode's `nearest_navigable` holds.
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
    sweep, past, stop = tuple(settings.success.sweep_deg), episode.query.relation.past, session.pose
    terms, of_instances = measurement.at_stop(session, past, episode.target, answer, navigable, sweep, instances)
    if rivals := episode.rivals({k: mover.position for k, mover in world.movers.items()}):
        nearest_m = min(math.dist((stop.x, stop.z), rival) for rival in rivals)
        terms = terms.model_copy(update={"rival_distance_m": round(nearest_m, METRE_DECIMALS)})
    return terms, of_instances


def _cells(region: ReachableRegion) -> np.ndarray:
    """Return the positions (K, 2) in metres that can be reached, sorted."""
    return np.array([region.grid.centre(c) for c in sorted(region.grid.cells)])

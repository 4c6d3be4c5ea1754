"""Runs an agent in the simulator from its spawn to its stop, and measures there. The same for the oracle and for every agent."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from ovman.agents.interface import Action, Agent, CameraPose, Observation, Sighting, Visit
from ovman.evaluation.assignment import Assignment
from ovman.models.run import Measured, Outcome
from ovman.models.run import Terms as StopTerms
from ovman.models.settings import Settings
from ovman.sim.change import World, dynamic, position
from ovman.sim.embodiment import Embodiment
from ovman.sim.measurement import ReachableRegion
from ovman.sim.session import Session
from ovman.task import Query
from ovman.workflow.journal import digest


@cache
def handed(visit: str, instance: str) -> str:
    """The name by which an agent that is handed positions knows an instance in one visit; it says nothing about the other."""
    return digest(visit, instance)[:8]


NOWHERE = StopTerms(stop=None, box_distance_m=None, answer_distance_m=None, navigable_distance_m=None, visible_px=None)
"""The terms of Eq. 4 of a run that did not stop."""


@dataclass(frozen=True, slots=True)
class Terms:
    """The terms of an arm's runs that are not the benchmark's for all.

    budget: of actions, primitives.action_budget where it is None. marks: numbers of actions at which the path length is written
    down ("path_at_m"), for those that cut the run there. any_instance: whether every instance of the category is measured at the
    stop ("instances"), for an agent whose own task is to reach one.
    """

    budget: int | None = None
    marks: Sequence[int] = ()
    any_instance: bool = False


def execute(
    session: Session,
    assignment: Assignment,
    agent: Agent,
    first: Visit | None,
    second: Callable[[np.ndarray], Visit],
    name_of: Callable[[str], str] | None,
    rng: np.random.Generator,
    constants: Settings,
    terms: Terms = Terms(),
    noise: int | None = None,
) -> Measured:
    """One run as it was measured.

    first: what the agent is familiarised with, None for an agent that needs nothing; second: its second visit, given the
    reachable positions (K, 2) around the spawn; name_of: how instances are called in the positions that are handed to it, None
    for an agent that is not handed any. `rng` drives the mover. noise: seed of what a noisy body does beside what it is told.
    A body of its own is not told where the benchmark's can go, and is not ended for standing still: CoW knows no such rule.
    An agent that is handed positions, or says that it does not look, is given no images. Deterministic for a deterministic
    simulator. SimulatorError if it refuses.
    """
    world = assignment.begun(session, constants, rng, object_filter=assignment.concerns)
    if noise is not None:
        session.step("SetRandomSeed", seed=noise)
    session.teleport(assignment.spawn)
    own_body = session.embodiment.mode != Embodiment.of(constants).mode
    ground = None if own_body else ReachableRegion.around(session, assignment.spawn, constants.primitives.step_m)
    if first is not None:
        agent.familiarise(first)
    agent.revisit(second(np.empty((0, 2)) if ground is None else cells(ground)))
    agent.ask(Query(assignment.category, assignment.relation))

    looks = name_of is None and getattr(agent, "looks", True)
    observe = partial(_observation, session, looks, assignment.gone, name_of)
    driven = _driven(session, world, agent, observe, own_body, looks, constants, terms)
    at_stop, instances = NOWHERE, None
    if driven.outcome == "stopped":
        at_stop, found = assignment.at_stop(session, world, constants, ground, terms.any_instance)
        instances = found or None
    return Measured(
        **dict(at_stop),
        outcome=driven.outcome,
        path_length_m=round(driven.path_length_m, 4),
        actions=driven.actions,
        instances=instances,
        path_at_m=driven.path_at_m if terms.marks else None,
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
    constants: Settings,
    terms: Terms,
) -> _Driven:
    """observe: what the agent sees, given whether its last action succeeded, and what can be reached now (None: as before).

    Where nothing else moves after an action, its own image is what the agent sees next.
    """
    step_m = constants.primitives.step_m
    budget = constants.primitives.action_budget if terms.budget is None else terms.budget
    travelled, actions, since_moved, succeeded = 0.0, 0, 0, True
    mover_in: tuple[int, int] | None = None
    path_at_m: dict[int, float] = {}
    outcome: Outcome = "budget"
    while actions < budget:
        reachable = None
        if world.mover is not None and not own_body:
            mover_in, before_in = _cell(world.mover.position, step_m), mover_in
            if mover_in != before_in:
                reachable = cells(ReachableRegion.around(session, session.pose, step_m))
        action = agent.act(observe(succeeded, reachable))
        if action in (Action.STOP, Action.ABSTAIN):
            outcome = "stopped" if action is Action.STOP else "abstained"
            break
        before = session.pose
        done = session.step(action.value, image=looks and world.mover is None, allowed=True)
        succeeded = bool(done.metadata["lastActionSuccess"])
        after = session.pose
        moved = math.hypot(after.x - before.x, after.z - before.z)
        travelled, actions = travelled + moved, actions + 1
        if actions in terms.marks:
            path_at_m[actions] = round(travelled, 4)
        since_moved = 0 if moved > 0 else since_moved + 1
        world.after_action()
        if since_moved >= constants.primitives.stall_after and not own_body:
            outcome = "stalled"
            break
    return _Driven(outcome, travelled, actions, path_at_m)


def _cell(point: tuple[float, float], step_m: float) -> tuple[int, int]:
    return round(point[0] / step_m), round(point[1] / step_m)


def cells(ground: ReachableRegion) -> np.ndarray:
    """The positions (K, 2) in metres that can be reached, sorted."""
    return np.array([ground.grid.centre(c) for c in sorted(ground.grid.cells)])


def _observation(
    session: Session,
    looks: bool,
    gone: Collection[str],
    name_of: Callable[[str], str] | None,
    succeeded: bool,
    reachable: np.ndarray | None,
) -> Observation:
    pose = session.pose
    camera = CameraPose(pose.x, session.camera["y"], pose.z, pose.yaw_deg, pose.horizon_deg)
    field_of_view_deg = session.embodiment.field_of_view_deg
    if looks:
        if session.rgb is None:
            session.step("Pass", image=True)
        return Observation(session.rgb, session.depth, camera, field_of_view_deg, succeeded, None, reachable)
    if name_of is None:
        return Observation(None, None, camera, field_of_view_deg, succeeded, None, reachable)
    present = {k: o for k, o in session.objects.items() if dynamic(o) and k not in gone}
    at = {k: position(o) for k, o in present.items()}
    positions = tuple(Sighting(name_of(k), present[k]["objectType"], at[k].x, at[k].z) for k in sorted(at))
    return Observation(None, None, camera, field_of_view_deg, succeeded, positions, reachable)

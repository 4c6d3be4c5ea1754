"""From the spawn to the end of a run: what the agent sees, and what becomes of what it does. Nothing is measured here."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Action, CameraPose, Observation, SeenInstance
from ovman.records.run import Outcome
from ovman.settings import Settings
from ovman.sim.change import World, dynamic, position
from ovman.sim.measurement import ReachableRegion
from ovman.sim.sensing import Sensing
from ovman.sim.session import Session


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


NO_LIMITS = Limits()


@dataclass(frozen=True, slots=True)
class Driven:
    """From the spawn to the end of a run; path_at_m: the path length by the number of actions, at each mark that was reached."""

    outcome: Outcome
    path_length_m: float
    actions: int
    path_at_m: Mapping[int, float]


def drive(
    session: Session,
    world: World,
    observe: Callable[[bool, np.ndarray | None], Observation],
    own_body: bool,
    looks: bool,
    settings: Settings,
    limits: Limits,
) -> Generator[Observation, Action, Driven]:
    """From the spawn to the end of a run: yields what the agent sees and is sent what it does.

    observe: what the agent sees, given whether its last action succeeded, and what can be reached now (None: as before).

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
        action = yield observe(succeeded, reachable)
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
    return Driven(outcome, travelled, actions, path_at_m)


def _cell(point: tuple[float, float], step_m: float) -> tuple[int, int]:
    return round(point[0] / step_m), round(point[1] / step_m)


def cells(region: ReachableRegion) -> np.ndarray:
    """The positions (K, 2) in metres that can be reached, sorted."""
    return np.array([region.grid.centre(c) for c in sorted(region.grid.cells)])


def observation(
    session: Session,
    looks: bool,
    gone: Collection[str],
    name_of: Callable[[str], str] | None,
    sensing: Sensing | None,
    succeeded: bool,
    reachable: np.ndarray | None,
) -> Observation:
    """What the agent sees where it stands.

    looks: whether it takes images. gone: ids of the instances that are absent. name_of: names of the instances for an agent that
    is given positions, None for any other. sensing: what it senses depth and pose with, None for exact ones. reachable: (K, 2).
    """
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

"""Dense tours: the tour of a visit repeated with frames between its views, like a video.

A dense tour passes the views of the recorded tour in their order. At a waypoint it spins once around with a frame per turn. To
the next one it follows a shortest path on the navigation grid with a frame per step, looking ahead. World time stands still
except at the tour's own views: movers take their steps at exactly those, and physics stops between them. A dense tour therefore
ends in the state that the recorded visit ended in.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.navigation.grid import Grid, shortest_path
from ovman.perception.backprojection import Camera
from ovman.records.visit import Visit
from ovman.sim import visit
from ovman.sim.session import AgentPose, Session, bearing_deg
from ovman.sim.world import World, position

SAME_M, SAME_DEG = 1e-3, 1e-3
"""Tolerances within which two places, or two yaws, are the same."""
ENDED_M = 0.01
"""Tolerance of final positions, metres: the physics of a simulator need not repeat exactly."""


class WalkError(RuntimeError):
    """A walk that ended otherwise than the visit that it follows; one line with the visit, the difference and the remedy."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One frame of a walk.

    rgb: (H, W, 3) uint8; depth: (H, W) float32 metres along the optical axis; camera: of both, in Unity's world frame; pose:
    where the agent stands; view: which view of the recorded tour this is, None between them; masks: the instances of a body that
    sees them, as the client keeps them (`colour_numbers`).
    """

    rgb: np.ndarray
    depth: np.ndarray
    camera: Camera
    pose: AgentPose
    view: int | None
    masks: Any = None


def frames(
    session: Session, world: World, views: Sequence[AgentPose], turn_deg: float, step_m: float, field_of_view_deg: float
) -> Iterator[Frame]:
    """Yield the frames of the dense tour along `views` in `world`, which was just made on `session`.

    It spins by `turn_deg` and steps by `step_m`, the spacing of the navigation grid. Without a way from one waypoint to the next,
    because something was placed or moves there, it goes on at the next one. SimulatorError if the simulator refuses a pose.
    """
    grid: Grid | None = None

    def seen(pose: AgentPose, number: int | None = None) -> Frame:
        if number is None and world.movers:
            session.step("PausePhysicsAutoSim")
        event = session.teleport(pose, image=True) if number is None else visit.look(session, world, pose)
        at = session.camera
        camera = Camera((at["x"], at["y"], at["z"]), pose.yaw_deg, pose.horizon_deg, field_of_view_deg)
        masks = event.instance_masks if session.embodiment.instances else None
        return Frame(event.frame, event.depth_frame, camera, pose, number, masks)

    first = before = views[0]
    for number, pose in enumerate(views):
        if number and math.dist((before.x, before.z), (pose.x, pose.z)) <= SAME_M:
            yield from map(seen, spin(before, pose.yaw_deg, turn_deg))
        elif number:
            yield from map(seen, spin(before, first.yaw_deg, turn_deg))
            # What was placed may part the room, and a grid holds only what can be reached from where the body stands.
            if grid is None or world.movers or grid.cell_at(before.x, before.z) is None:
                grid = Grid.from_positions(session.reachable(), step_m)
            yield from map(seen, way(grid, before, pose))
            first = pose
        yield seen(pose, number)
        before = pose
    yield from map(seen, spin(before, first.yaw_deg, turn_deg))


def spin(here: AgentPose, yaw_deg: float, turn_deg: float) -> list[AgentPose]:
    """Return the poses strictly between `here` and the next time that a spin to the right looks along `yaw_deg`.

    The last turn may be a smaller one.
    """
    left = (yaw_deg - here.yaw_deg) % 360.0 or 360.0
    count = math.ceil((left - SAME_DEG) / turn_deg)
    return [AgentPose(here.x, here.z, (here.yaw_deg + turn_deg * k) % 360.0, here.horizon_deg) for k in range(1, count)]


def way(grid: Grid, here: AgentPose, there: AgentPose) -> list[AgentPose]:
    """Return the poses strictly between two waypoints on a shortest path, looking along each step; none if there is no way."""
    start, goal = grid.cell_at(here.x, here.z), grid.cell_at(there.x, there.z)
    path = None if start is None or goal is None else shortest_path(grid, start, goal)
    if path is None:
        return []
    points = [(round(x, 4), round(z, 4)) for x, z in map(grid.centre, path)]
    return [
        AgentPose(*point, round(bearing_deg(*before, *point), 4) % 360.0, there.horizon_deg)
        for before, point in zip(points, points[1:-1], strict=False)
    ]


def check(session: Session, world: World, recorded: Visit) -> None:
    """Raise WalkError if a walk that has just ended left the world in another state than the recorded visit ended in."""
    where = f"{session.scene}: the walk of {recorded.visit}"
    for was in recorded.movers:
        now = world.movers[was.instance]
        if (now.position, now.heading_deg) != (was.position, was.heading_deg):
            says = f"{where} left the mover {was.instance} at {now.position}, not where the visit did ({was.position})"
            raise WalkError(f"{says}; record the visits again")
    session.step("ResetObjectFilter")
    objects = session.objects
    for instance, ended in recorded.positions[-1].items():
        at = position(objects[instance])
        if math.dist((at.x, at.y, at.z), (ended.x, ended.y, ended.z)) > ENDED_M:
            raise WalkError(f"{where} left {instance} at {at!r}, not at {ended!r}; record the visits again")

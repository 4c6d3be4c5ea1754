"""A box-shaped room of boxes whose depth images are exact, for an agent that walks in it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ovman.agents.cow.agent import CowAgent
from ovman.agents.interface import Action, CameraPose, Observation, Visit
from ovman.task import Query, Relation
from tests.arms import CONFIG

CONSTANTS, PRIMITIVES = CONFIG.cow.model_copy(update={"image_px": 96}), CONFIG.primitives
SIDE = CONSTANTS.image_px
FIELD_OF_VIEW_DEG = 90.0
EYE_M, RADIUS_M = CONSTANTS.camera_height_m, 0.175
NOWHERE = CameraPose(math.nan, math.nan, math.nan, math.nan, math.nan)


@dataclass
class Room:
    """Walls around (0, 0) to (width, depth), 2.5 m high; boxes (x_0, x_1, y_0, y_1, z_0, z_1), the first is the target. Metres.

    The agent stands at x, z and looks along yaw_deg; what it does is exact, and a move into something fails.
    """

    x: float
    z: float
    yaw_deg: float
    width: float = 8.0
    depth: float = 6.0
    boxes: tuple[tuple[float, ...], ...] = ()
    blocked: int = field(default=0)

    def look(self) -> tuple[np.ndarray, np.ndarray]:
        """Depth (S, S) and which box is seen, -1 for none."""
        rows, columns = np.indices((SIDE, SIDE)) + 0.5
        right, up = (columns - SIDE / 2) / (SIDE / 2), (SIDE / 2 - rows) / (SIDE / 2)
        sine, cosine = math.sin(math.radians(self.yaw_deg)), math.cos(math.radians(self.yaw_deg))
        way = np.stack([cosine * right + sine, up, -sine * right + cosine])
        way[np.abs(way) < 1e-9] = 1e-9
        eye = np.array([self.x, EYE_M, self.z])[:, None, None]
        room = np.array([[0.0, self.width], [0.0, 2.5], [0.0, self.depth]])[:, :, None, None]
        depth = np.maximum((room[:, 0] - eye) / way, (room[:, 1] - eye) / way).min(axis=0)
        seen = np.full(depth.shape, -1)
        for number, box in enumerate(self.boxes):
            sides = np.array(box).reshape(3, 2)[:, :, None, None]
            near, far = (sides[:, 0] - eye) / way, (sides[:, 1] - eye) / way
            enter, leave = np.minimum(near, far).max(axis=0), np.maximum(near, far).min(axis=0)
            hit = (enter < leave) & (enter > 0) & (enter < depth)
            depth, seen = np.where(hit, enter, depth), np.where(hit, number, seen)
        return depth.astype(np.float32), seen

    def do(self, action: Action) -> bool:
        if action is Action.MOVE_AHEAD:
            x = self.x + 0.25 * math.sin(math.radians(self.yaw_deg))
            z = self.z + 0.25 * math.cos(math.radians(self.yaw_deg))
            if not self.fits(x, z):
                self.blocked += 1
                return False
            self.x, self.z = x, z
        elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            self.yaw_deg = (self.yaw_deg + (30.0 if action is Action.ROTATE_RIGHT else -30.0)) % 360.0
        return True

    def fits(self, x: float, z: float) -> bool:
        inside = RADIUS_M <= x <= self.width - RADIUS_M and RADIUS_M <= z <= self.depth - RADIUS_M
        return inside and all(
            math.hypot(max(b[0] - x, x - b[1], 0.0), max(b[4] - z, z - b[5], 0.0)) >= RADIUS_M for b in self.boxes if b[2] < 0.9
        )

    def distance(self, number: int = 0) -> float:
        """From the agent to a box, on the floor plane."""
        b = self.boxes[number]
        return math.hypot(max(b[0] - self.x, self.x - b[1], 0.0), max(b[4] - self.z, self.z - b[5], 0.0))


class Sight:
    """A localiser that knows which pixels show the target, from so many of them on; blind where `least` is None."""

    def __init__(self, least: int | None = 20) -> None:
        self.least, self.shown = least, np.zeros((SIDE, SIDE), bool)
        self.found = 0
        self.category = ""

    def look_for(self, category: str) -> None:
        self.category = category

    def relevance(self, rgb: np.ndarray) -> np.ndarray:
        relevance = np.zeros((SIDE, SIDE), np.float32)
        if self.least is not None and self.shown.sum() >= self.least:
            pixels = np.argwhere(self.shown)
            relevance[tuple(pixels[np.argmin(np.abs(pixels - pixels.mean(axis=0)).sum(axis=1))])] = 1.0
            self.found += 1
        return relevance


def walked(room: Room, sight: Sight, budget: int, camera: CameraPose = NOWHERE):
    """The agent after its walk, the actions that it asked for, and after each of them the true and the believed place."""
    agent = CowAgent(sight, CONSTANTS, PRIMITIVES)
    agent.familiarise(Visit((), np.empty((0, 2))))
    agent.revisit(Visit((), np.empty((0, 2))))
    agent.ask(Query("Mug", Relation.REMOVED))
    start, actions, places, succeeded = (room.x, room.z, room.yaw_deg), [], [], True
    while len(actions) < budget:
        depth, seen = room.look()
        sight.shown = seen == 0
        rgb = np.zeros((*depth.shape, 3), np.uint8)
        action = agent.act(Observation(rgb, depth, camera, FIELD_OF_VIEW_DEG, succeeded))
        places.append(((room.x, room.z), believed(agent, start)))
        actions.append(action)
        if action is Action.STOP:
            break
        succeeded = room.do(action)
    return agent, actions, places


def believed(agent: CowAgent, start: tuple[float, float, float]) -> tuple[float, float]:
    """Where the agent believes to be, in the room's frame."""
    x, z, yaw_deg = start
    sine, cosine = math.sin(math.radians(yaw_deg)), math.cos(math.radians(yaw_deg))
    return x + cosine * agent.pose.x + sine * agent.pose.z, z - sine * agent.pose.x + cosine * agent.pose.z

"""CoW's policy: spin, explore, exploit; stop at the first detection of the category."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from ovman.agents.cow import Cow
from ovman.agents.cow.localiser import OpenVocabularyLocaliser, make_localiser
from ovman.agents.cow.map import Cell, Pose, Scan, VoxelMap, VoxelState, has_failed, scan, square
from ovman.agents.cow.planning import Paths, face, find_frontiers, steer, turns
from ovman.agents.interface import Action, AgentContext, Observation, Query, Visit
from ovman.settings.benchmark import Primitives


class Mode(StrEnum):
    """SPIN: look around. EXPLORE: go to the frontiers, the nearest first. EXPLOIT: go to a detection of the category."""

    SPIN = "spin"
    EXPLORE = "explore"
    EXPLOIT = "exploit"


class CowAgent:
    """CoW's agent for one episode. It uses the RGB and depth images and the field of view of an observation, nothing else.

    It ignores the tours and the relation. Deterministic.
    """

    def __init__(self, localiser: OpenVocabularyLocaliser, constants: Cow, primitives: Primitives) -> None:
        self._localiser, self._constants, self._primitives = localiser, constants, primitives
        self._begin()

    def familiarise(self, visit: Visit) -> None:
        """Forget the last episode. Nothing is kept of a tour."""
        self._begin()

    def revisit(self, visit: Visit) -> None:
        """Keep nothing."""

    def ask(self, query: Query) -> None:
        """Set the goal: any instance of the category."""
        self._localiser.look_for(query.category)

    def _begin(self) -> None:
        self.pose = Pose()
        self.mode = Mode.SPIN
        self.map = VoxelMap(self._constants)
        self._proxies: dict[Cell, Cell] = {}
        self._queue: list[Action] = []
        self._spun = 0
        self._depth: np.ndarray | None = None
        self._last: Action | None = None
        self._failed: Action | None = None

    @property
    def cell(self) -> Cell:
        """The voxel of the believed pose."""
        return self.pose.cell(self._constants.voxel_m)

    def act(self, observation: Observation) -> Action:
        """Return the next action for the images at the current pose."""
        constants = self._constants
        assert observation.rgb is not None and observation.depth is not None, "CoW needs images"
        if self._queue and self._queue[-1] is Action.STOP:
            # The final turns before STOP: no image changes them, so none is processed.
            return self._queue.pop(0)
        depth = square(observation.depth, constants.image_px)
        self._reckon(depth)
        relevance = self._localiser.relevance(observation.rgb)
        seen = scan(depth, relevance, self.pose, observation.field_of_view_deg, constants)
        self.map.update(seen, self.cell)
        self._last = self._decide(seen)
        return self._last

    def _reckon(self, depth: np.ndarray) -> None:
        """Move the believed pose by the last action, unless the depth image has hardly changed."""
        self._failed = None
        if self._last is not None and self._depth is not None:
            if has_failed(self._depth, depth, self._constants.unchanged_depth_m):
                self._failed = self._last
            else:
                self.pose = self.pose.after(self._last, self._primitives.step_m, self._primitives.turn_deg)
        self._depth = depth

    def _decide(self, seen: Scan) -> Action:
        if self.map.regions and self.mode is not Mode.EXPLOIT:
            self.mode, self._queue = Mode.EXPLOIT, []
        if self.mode is Mode.SPIN:
            if self._spun < self._constants.spin_turns:
                self._spun += 1
                return Action.ROTATE_LEFT
            self.mode = Mode.EXPLORE
        if not self._queue:
            self._queue = list(self._explore() if self.mode is Mode.EXPLORE else self._exploit())
        if not self._queue:
            return self._confused(seen)
        return self._queue.pop(0)

    def _confused(self, seen: Scan) -> Action:
        """Forget the map except for the current view, and look around again: no path is left."""
        self.map = VoxelMap(self._constants)
        self.map.update(seen, self.cell)
        self._proxies = {}
        self.mode, self._spun = Mode.SPIN, 1
        return Action.ROTATE_LEFT

    def _explore(self) -> tuple[Action, ...]:
        """Return actions towards the nearest frontier with a path to it; none without such a frontier."""
        paths = Paths(self.map, self.cell)
        for target in find_frontiers(self.map, self.cell, self._constants):
            if self.map.is_visited(target) or (way := paths.to(target)) is None:
                continue
            waypoint = self._waypoint(way)
            if waypoint is not None:
                return self._steer(waypoint)
            self.map.visit(target)
        return ()

    def _exploit(self) -> tuple[Action, ...]:
        """Return actions towards the nearest region of interest; STOP near it."""
        paths = Paths(self.map, self.cell)
        for region in self.map.regions:
            proxy = self._proxy(region)
            if proxy is None:
                return (Action.STOP,)
            if self._away(region) < self._constants.stop_voxels:
                return (*face(self.pose, region, self._constants, self._primitives), Action.STOP)
            if (way := paths.to(proxy)) is not None:
                return self._follow(way)
        targets = find_frontiers(self.map, self.cell, self._constants)
        for target in sorted(targets, key=lambda t: min(math.dist(t, region) for region in self.map.regions)):
            if (way := paths.to(target)) is not None:
                return self._follow(way)
        return ()

    def _follow(self, way: list[Cell]) -> tuple[Action, ...]:
        waypoint = self._waypoint(way)
        return turns(1) if waypoint is None else self._steer(waypoint)

    def _steer(self, waypoint: Cell) -> tuple[Action, ...]:
        return steer(self.map, self.pose, waypoint, self._constants, self._primitives, self._failed) or ()

    def _away(self, cell: Cell) -> float:
        """Return the distance to a cell in voxels."""
        return math.dist(self.cell, cell)

    def _waypoint(self, way: list[Cell]) -> Cell | None:
        """Return the first cell of a path that is not reached yet."""
        return next((cell for cell in way if self._away(cell) > self._constants.waypoint_voxels), None)

    def _proxy(self, region: Cell) -> Cell | None:
        """Return the goal for a region: the first known cell that is not occupied on the line from the region to the agent.

        It stays the same until the map marks it as occupied.
        """
        kept = self._proxies.get(region)
        if kept is not None and self.map.at(kept) is not VoxelState.OCCUPIED:
            return kept
        self._proxies.pop(region, None)
        start, end = np.array(region, dtype=float), np.array(self.cell, dtype=float)
        count = max(int(math.dist(region, self.cell) / self._constants.ray_step_voxels), 1)
        cells = np.rint(start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)).astype(int)
        states = self.map.states(cells)
        there = np.flatnonzero((states != VoxelState.UNKNOWN) & (states != VoxelState.OCCUPIED))
        if not len(there):
            return None
        self._proxies[region] = int(cells[there[0], 0]), int(cells[there[0], 1])
        return self._proxies[region]


def agent(context: AgentContext) -> CowAgent:
    """Make the agent of the arm `cow`: needs the networks, and of the settings cow.*, locobot.* and section perception."""
    settings = context.settings
    return CowAgent(make_localiser(settings, *context.networks()), settings.cow, settings.primitives)

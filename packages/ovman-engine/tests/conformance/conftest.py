"""Conformance to AI2-THOR 5.0.0, tested through the unmodified Controller.

CONFORMANCE_SEED draws other scenes, poses and objects; CONFORMANCE_SCENES draws more scenes for each test. `make test` runs each
test on the first of its scenes, `make soak` on all.
"""

from __future__ import annotations

import math
import os
import random
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

SCENES = (
    "FloorPlan3",
    "FloorPlan12",
    "FloorPlan28",
    "FloorPlan203",
    "FloorPlan212",
    "FloorPlan302",
    "FloorPlan320",
    "FloorPlan403",
    "FloorPlan418",
)
"""Scenes that tests draw from: all four kinds of room, none of the benchmark's scenes."""
WIDTH, HEIGHT = 200, 150
BASE = {
    "gridSize": 0.25,
    "snapToGrid": True,
    "rotateStepDegrees": 90,
    "fieldOfView": 90,
    "visibilityDistance": 1.5,
    "renderDepthImage": True,
    "renderInstanceSegmentation": True,
    "agentMode": "default",
}
SEED = int(os.environ.get("CONFORMANCE_SEED", "0"))
USUAL_SCENES = int(os.environ.get("CONFORMANCE_SCENES", "1"))
"""Default number of scenes of a test."""


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "scenes(count): number of scenes that a test runs on")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "scene" in metafunc.fixturenames:
        marker = metafunc.definition.get_closest_marker("scenes")
        count = marker.args[0] if marker else USUAL_SCENES
        first, *others = random.Random(f"{SEED} {metafunc.function.__name__}").sample(SCENES, count)
        metafunc.parametrize("scene", [first, *(pytest.param(scene, marks=pytest.mark.soak) for scene in others)])


class Thor:
    """A Controller on one scene, with queries on its last event."""

    def __init__(self, reset: Callable[..., Any], scene: str, seed: str) -> None:
        self._reset = reset
        self.scene = scene
        self.random = random.Random(seed)
        self.controller = reset(scene, width=WIDTH, height=HEIGHT, renderImage=False, **BASE)

    def reset(self, scene: str | None = None, **initialize: Any) -> Any:
        """The untouched scene, initialised with `BASE` and `initialize`."""
        options = {**BASE, "renderImage": False, **initialize}
        return self._reset(scene or self.scene, width=WIDTH, height=HEIGHT, **options).last_event

    def step(self, action: str, **arguments: Any) -> Any:
        """The event of an action, without images."""
        return self.controller.step(action=action, renderImage=False, **arguments)

    def ok(self, action: str, **arguments: Any) -> Any:
        """The event of an action that must succeed."""
        event = self.step(action, **arguments)
        assert event, event.metadata["errorMessage"]
        assert event.metadata["errorMessage"] == "" and not event.metadata["errorCode"]
        return event

    def refused(self, action: str, message: str = "", **arguments: Any) -> Any:
        """The event of an action that must fail with a message that contains `message`, and leave the agent's pose as it is."""
        before = self.pose
        event = self.step(action, **arguments)
        assert not event
        assert message.lower() in event.metadata["errorMessage"].lower(), event.metadata["errorMessage"]
        assert self.pose == before
        return event

    def look(self, **pose: Any) -> Any:
        """The event at a pose, with images."""
        if pose:
            self.ok("TeleportFull", **pose)
        event = self.controller.step("Pass")
        assert event.frame is not None
        return event

    @property
    def metadata(self) -> Mapping[str, Any]:
        return self.controller.last_event.metadata

    @property
    def agent(self) -> Mapping[str, Any]:
        return self.metadata["agent"]

    @property
    def position(self) -> np.ndarray:
        return xyz(self.agent["position"])

    @property
    def yaw(self) -> float:
        return self.agent["rotation"]["y"]

    @property
    def pose(self) -> tuple[float, ...]:
        """x, y, z, yaw, horizon, standing."""
        return (*self.position.tolist(), self.yaw, self.agent["cameraHorizon"], self.agent["isStanding"])

    @property
    def objects(self) -> dict[str, Mapping[str, Any]]:
        return {o["objectId"]: o for o in self.metadata["objects"]}

    def reachable(self, **arguments: Any) -> list[dict[str, float]]:
        return self.ok("GetReachablePositions", **arguments).metadata["actionReturn"]

    def pickupable(self, number: int = 1) -> list[Mapping[str, Any]]:
        """Random objects that can be picked up and are in no receptacle that can be closed."""
        closed = {o["objectId"] for o in self.metadata["objects"] if o["openable"]}
        free = [o for o in self.metadata["objects"] if o["pickupable"] and not closed & set(o["parentReceptacles"] or [])]
        return self.random.sample(free, number)

    def movables(self) -> list[Mapping[str, Any]]:
        return [o for o in self.metadata["objects"] if o["pickupable"] or o["moveable"]]

    def poses(self) -> list[dict[str, Any]]:
        """The pose of every movable object, as SetObjectPoses takes it."""
        return [{"objectName": o["name"], "position": o["position"], "rotation": o["rotation"]} for o in self.movables()]

    def free_cell(self) -> dict[str, float]:
        """A random reachable position."""
        return self.random.choice(self.reachable())

    def go(self, cell: Mapping[str, float], yaw: float = 0.0, horizon: float = 0.0, standing: bool = True) -> Any:
        return self.ok("TeleportFull", position=dict(cell), rotation=yaw, horizon=horizon, standing=standing)


def xyz(point: Mapping[str, float]) -> np.ndarray:
    return np.array([point["x"], point["y"], point["z"]])


def heading(yaw_deg: float) -> np.ndarray:
    """The contract's unit vector of a yaw."""
    return np.array([math.sin(math.radians(yaw_deg)), 0.0, math.cos(math.radians(yaw_deg))])


@pytest.fixture
def thor(reset: Callable[..., Any], scene: str, request: pytest.FixtureRequest) -> Thor:
    """The shared engine on an untouched scene."""
    return Thor(reset, scene, f"{SEED} {request.node.name}")

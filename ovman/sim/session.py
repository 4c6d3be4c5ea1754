"""A scene on a Controller in the units of the benchmark: floor-plane metres, degrees, pixel counts."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, TypeVar, cast

import numpy as np

from ovman.records.tour import Light
from ovman.settings import Settings
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.scenes import load_scene

DEATHS = 3
"""Number of dead simulators after which a piece of work is given up."""

Result = TypeVar("Result")


class SimulatorError(RuntimeError):
    """The simulator refused an action; the message is the simulator's."""


class SimulatorDied(Exception):
    """The simulator's process ended, or its answers are unreadable. Not a SimulatorError: no action was refused."""


@dataclass(frozen=True)
class AgentPose:
    """Pose of the agent: floor plane in metres, degrees; yaw 0 looks along +z, 90 along +x; a positive horizon looks down."""

    x: float
    z: float
    yaw_deg: float
    horizon_deg: float = 0.0


def bearing_deg(from_x: float, from_z: float, to_x: float, to_z: float) -> float:
    """Return the yaw in [0, 360) from one floor-plane point to another; 0 for equal points."""
    return math.degrees(math.atan2(to_x - from_x, to_z - from_z)) % 360.0


class Session:
    """One scene on a simulator, which starts at the first reset. A context manager.

    scene: the name of a floor plan or a home, loaded by the next reset; it may be changed between two pieces of work. constants:
    benchmark.backend, camera.*, primitives.step_m and primitives.turn_deg. embodiment: None for that of the benchmark. start:
    returns the Controller, None for `controller.start`. A failed step raises SimulatorError unless failure is allowed, and
    SimulatorDied if the simulator ended (`with_restarts`).
    """

    def __init__(
        self, scene: str, constants: Settings, embodiment: Embodiment | None = None, start: controller.Start | None = None
    ) -> None:
        self.scene = scene
        self.embodiment = Embodiment.of(constants) if embodiment is None else embodiment
        self._start = start
        self._masks_only = controller.masks_only(constants.benchmark.backend) if start is None else {}
        self._constants = constants
        self._controller: Any = None
        self._event: Any = None

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._stop()

    def _stop(self) -> None:
        if self._controller is not None:
            with suppress(OSError):  # closing the pipes of a dead simulator fails
                self._controller.stop()
            self._controller = None

    def with_restarts(self, work: Callable[[], Result]) -> Result:
        """Return the result of `work`. If the simulator dies, repeat `work` from its beginning on a new one.

        work: begins with a reset and does not depend on its own changes. SimulatorDied after DEATHS simulators.
        """
        for _ in range(DEATHS - 1):
            try:
                return work()
            except SimulatorDied as death:
                print(f"{self.scene}: {death} Starting another one.", flush=True)
        return work()

    @contextmanager
    def _watched(self, doing: str) -> Iterator[None]:
        """Turn failures of the connection into SimulatorDied: the Controller stops its simulator and is unusable afterwards."""
        try:
            yield
        except Exception as error:
            mistaken = isinstance(error, ValueError)  # no such scene, action or argument; or half a message
            if mistaken and (self._controller is None or not controller.ended(self._controller)):
                raise
            self._stop()
            raise SimulatorDied(f"The simulator died during {doing}: {type(error).__name__}: {error}") from error

    def reset(self) -> None:
        """Load the untouched scene, at rest; start the simulator the first time."""
        with self._watched("Reset"):
            if self._controller is None:
                start = self._start or controller.start
                self._controller = start(self._constants.benchmark.backend, load_scene(self.scene), self.embodiment)
                self._event = self._controller.last_event
            else:
                self._event = self._controller.reset(load_scene(self.scene))
        self._height_m = self._event.metadata["agent"]["position"]["y"]
        self.settle()

    def step(self, action: str, image: bool = False, allowed: bool = False, **arguments: Any) -> Any:
        """Execute an action and return its event. image: with RGB, depth, ids. allowed: a failure does not raise."""
        with self._watched(action):
            self._event = self._controller.step(action=action, renderImage=image, **arguments)
        if not self._event.metadata["lastActionSuccess"] and not allowed:
            why = self._event.metadata["errorMessage"] or f"refused without a reason: {arguments}"
            raise SimulatorError(f"{self.scene}: {action}: {why}")
        return self._event

    @property
    def pose(self) -> AgentPose:
        """The agent's pose after the last step."""
        agent = self._event.metadata["agent"]
        return AgentPose(agent["position"]["x"], agent["position"]["z"], agent["rotation"]["y"] % 360.0, agent["cameraHorizon"])

    @property
    def camera(self) -> Mapping[str, float]:
        """Position of the camera, x, y, z in metres, after the last step."""
        return cast(Mapping[str, float], self._event.metadata["cameraPosition"])

    @property
    def rgb(self) -> np.ndarray | None:
        """RGB image (H, W, 3) uint8 of the last step, None for a step without an image."""
        return cast(np.ndarray | None, self._event.frame)

    @property
    def depth(self) -> np.ndarray:
        """Depth image (H, W) float32 of the last step, metres along the optical axis."""
        return cast(np.ndarray, self._event.depth_frame)

    @property
    def objects(self) -> Mapping[str, Mapping[str, Any]]:
        """Metadata of every object by objectId, as of the last step."""
        return {o["objectId"]: o for o in self._event.metadata["objects"]}

    def filter_objects(self, object_ids: Collection[str]) -> None:
        """Report only these objects until the next reset; metadata are most of the cost of a step without an image."""
        self.step("SetObjectFilter", objectIds=sorted(object_ids))

    def teleport(self, pose: AgentPose, image: bool = False, allowed: bool = False, **arguments: Any) -> Any:
        """Put the agent at `pose` and return the event, which is false if the pose is blocked (only with `allowed`)."""
        # An embodiment that cannot crouch has None in its metadata and refuses the argument.
        stands = self._event.metadata["agent"]["isStanding"] is not None
        return self.step(
            "TeleportFull",
            image=image,
            allowed=allowed,
            position={"x": pose.x, "y": self._height_m, "z": pose.z},
            rotation={"x": 0.0, "y": pose.yaw_deg, "z": 0.0},
            horizon=pose.horizon_deg,
            **({"standing": True} if stands else {}),
            **arguments,
        )

    def images(self, masks_only: bool) -> dict[str, Any]:
        """Return the arguments of a step whose event has images: all kinds, or masks where the simulator can draw them alone."""
        return {"image": True, **(self._masks_only if masks_only else {})}

    def reachable(self) -> list[tuple[float, float]]:
        """Return the floor-plane points (x, z) of the navigation grid around the agent in the present world, metres."""
        return [(p["x"], p["z"]) for p in self.step("GetReachablePositions").metadata["actionReturn"]]

    def pixels(self, object_id: str) -> int:
        """Return the size of an object's mask in the last image, in pixels of the benchmark's camera for every embodiment."""
        mask = self._event.instance_masks.mask(object_id)
        return 0 if mask is None else int(np.count_nonzero(self.embodiment.seen_by(Embodiment.of(self._constants), mask)))

    def sweep(self, object_ids: Collection[str], pose: AgentPose, pitches_deg: tuple[int, ...]) -> dict[str, dict[int, int]]:
        """Return mask sizes in pixels by object id and pitch, over the look-down sweep from `pose` (Eq. 4, vis)."""
        seen: dict[str, dict[int, int]] = {k: {} for k in object_ids}
        for pitch in pitches_deg:
            self.teleport(AgentPose(pose.x, pose.z, pose.yaw_deg, float(pitch)), **self.images(masks_only=True))
            for object_id in object_ids:
                seen[object_id][int(pitch)] = self.pixels(object_id)
        return seen

    def settle(self, limit: int = 50) -> None:
        """Run the physics until nothing moves, at most `limit` Pass actions."""
        for _ in range(limit):
            if self._event.metadata["isSceneAtRest"]:
                return
            self.step("Pass")


def illuminate(session: Session, light: Light | None) -> None:
    """Give a scene that was just reset the light of a visit; None leaves its own.

    Every range of AI2-THOR's action has equal ends, so it draws nothing; its draws of materials have a seed.
    """
    if light is not None:
        if light.materials is not None:
            session.step("SetRandomSeed", seed=light.materials)
            session.step("RandomizeMaterials")
        session.step(
            "RandomizeLighting",
            synchronized=True,
            randomizeColor=True,
            brightness=[light.brightness] * 2,
            hue=[light.hue] * 2,
            saturation=[light.saturation] * 2,
        )

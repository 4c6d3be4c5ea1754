"""Actions that load a scene and set how it is shown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ovman_engine.actions.registry import action, null_reference
from ovman_engine.actions.values import MAX_COMPONENT
from ovman_engine.bodies.embodiment import DEFAULT, EMBODIMENTS, ActionNoise
from ovman_engine.client.resolution import objection
from ovman_engine.client.session import PROCEDURAL, SCENE_SUFFIX, Session
from ovman_engine.client.settings import Settings
from ovman_engine.plan import floorplan
from ovman_engine.world.errors import Refused

if TYPE_CHECKING:
    import numpy as np

MAX_GRID_M = 5.0
NEAR_CORNER = 1e-3
"""Fraction of the grid's spacing within which an agent is on the grid: recorded starts have single precision."""


@action("GetScenesInBuild")
def scenes_in_build(session: Session) -> list[str]:
    """GetScenesInBuild: the names of all scenes."""
    return [*(name + SCENE_SUFFIX for name in floorplan.names()), PROCEDURAL]


@action("Reset")
def reset(session: Session, sceneName: str | None = None, **rest: Any) -> None:
    """Reset: loads a scene, or the current one again. Refused if no scene has this name."""
    scene = sceneName or session.scene_name
    try:
        session.load(scene)
    except KeyError:
        raise Refused(f"Scene '{scene}' couldn't be loaded because it is not in this build.") from None


@action("Initialize")
def initialize(
    session: Session,
    gridSize: float = Settings.grid_m,
    snapToGrid: bool = Settings.snap_to_grid,
    rotateStepDegrees: float = Settings.turn_deg,
    fieldOfView: float | None = None,
    visibilityDistance: float = Settings.visibility_m,
    visibilityScheme: str = Settings.visibility_scheme,
    renderDepthImage: bool = False,
    renderInstanceSegmentation: bool = False,
    renderSemanticSegmentation: bool = False,
    renderNormalsImage: bool = False,
    cameraNearPlane: float = Settings.near_m,
    cameraFarPlane: float = Settings.far_m,
    autoSimulation: bool = True,
    fastActionEmit: bool = Settings.fast_emit,
    maxUpwardLookAngle: float = Settings.look_up_deg,
    maxDownwardLookAngle: float = Settings.look_down_deg,
    timeScale: float = 1.0,
    agentMode: str | None = DEFAULT.mode,
    agentCount: int = 1,
    makeAgentsVisible: bool = Settings.agent_visible,
    applyActionNoise: bool = True,
    movementGaussianMu: float = 0.0,
    movementGaussianSigma: float = 0.0,
    rotateGaussianMu: float = 0.0,
    rotateGaussianSigma: float = 0.0,
    renderObjectImage: bool = False,
    renderClassImage: bool = False,
    **rest: Any,
) -> dict[str, float]:
    """Initialize. Values that are not positive leave planes, visibility distance, look angles and noise at their defaults."""
    if agentMode is None:
        raise null_reference()
    embodiment = EMBODIMENTS.get(agentMode.lower())
    if embodiment is None:
        modes = " and ".join(f"'{mode}'" for mode in sorted({e.mode for e in EMBODIMENTS.values()}))
        raise Refused(f"Unsupported agent mode: {agentMode}. This engine has the agent modes {modes}.")
    if agentCount > 1:
        raise Refused(f"Unsupported number of agents: {agentCount}. This engine has one agent.")
    fov = embodiment.field_of_view_deg if fieldOfView is None else fieldOfView
    if not 0 < fov < 180:
        raise Refused("fov must be set to (0, 180) noninclusive.")
    if timeScale <= 0:
        raise Refused("Time scale must be > 0")
    if rotateStepDegrees <= 0:
        raise Refused("rotateStepDegrees must be a non-zero, non-negative float")
    if embodiment.noise is not None:
        snapToGrid = False
    if snapToGrid and rotateStepDegrees not in (90, 180, 270) and rotateStepDegrees % 360 != 0:
        raise Refused(
            f"Invalid values 'rotateStepDegrees': ${rotateStepDegrees:g} and 'snapToGrid':$True. 'snapToGrid': 'True' is not "
            "supported when 'rotateStepDegrees' is different from grid rotation steps of 0, 90, 180, 270 or 360."
        )
    for name, angle in (("maxDownwardLookAngle", maxDownwardLookAngle), ("maxUpwardLookAngle", maxUpwardLookAngle)):
        if angle < 0:
            raise Refused(f"{name} must be a non-negative float")
    if not 0 < gridSize <= MAX_GRID_M:
        raise Refused("grid size must be in the range (0,5]")
    near = cameraNearPlane if cameraNearPlane > 0 else Settings.near_m
    far = cameraFarPlane if cameraFarPlane > 0 else Settings.far_m
    if not near < far <= MAX_COMPONENT:
        raise Refused(f"The camera's planes must satisfy 0 < near < far. You gave {cameraNearPlane:g} and {cameraFarPlane:g}.")
    noise = embodiment.noise if applyActionNoise else None
    if noise is not None:
        move = (movementGaussianMu, movementGaussianSigma)
        turn = (rotateGaussianMu, rotateGaussianSigma)
        noise = ActionNoise(_positive(move, noise.move), _positive(turn, noise.turn))
    session.change(
        grid_m=gridSize,
        snap_to_grid=snapToGrid,
        turn_deg=rotateStepDegrees,
        field_of_view_deg=fov,
        visibility_m=visibilityDistance if visibilityDistance > 0 else Settings.visibility_m,
        visibility_scheme="Distance" if (visibilityScheme or "").lower() == "distance" else "Collider",
        near_m=near,
        far_m=far,
        look_up_deg=maxUpwardLookAngle or Settings.look_up_deg,
        look_down_deg=maxDownwardLookAngle or Settings.look_down_deg,
        noise=noise,
        depth=renderDepthImage,
        instances=renderInstanceSegmentation or renderObjectImage,
        classes=renderSemanticSegmentation or renderClassImage,
        normals=renderNormalsImage,
        agent_visible=makeAgentsVisible,
        fast_emit=fastActionEmit,
    )
    session.auto_simulation = autoSimulation
    agent = session.world.agent
    agent.embodiment, agent.standing = embodiment, True
    agent.position = _on_grid(session)
    return {"cameraNearPlane": near, "cameraFarPlane": far}


def _positive(given: tuple[float, float], otherwise: tuple[float, float]) -> tuple[float, float]:
    return (given[0] if given[0] > 0 else otherwise[0], given[1] if given[1] > 0 else otherwise[1])


def _on_grid(session: Session) -> np.ndarray:
    """Return the start position (3,) metres.

    It is the first corner of the agent's grid cell that it can move to, or its own position if no corner is free.
    """
    import numpy as np

    world, grid = session.world, session.settings.grid_m
    here = world.agent.position
    cell = np.floor(here[[0, 2]] / grid + NEAR_CORNER)
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        x, z = (cell + (i, j)) * grid
        corner = np.array([x, here[1], z])
        if np.abs(corner - here).max() < NEAR_CORNER * grid:
            return session.snapped(here)
        if session.in_bounds(corner) and world.blocker(here[[0, 2]], corner[[0, 2]]) is None:
            return corner
    return here


@action("ChangeResolution")
def change_resolution(session: Session, x: int, y: int) -> None:
    """ChangeResolution: the size of all images, pixels."""
    if problem := objection(x, y, 1 + len(session.cameras)):
        raise Refused(problem)
    session.width, session.height = x, y


@action("ChangeQuality")
def change_quality(session: Session, quality: str) -> None:
    """ChangeQuality: accepted without effect; the engine has one quality."""


@action("SetRandomSeed")
def set_random_seed(session: Session, seed: int) -> None:
    """SetRandomSeed: restarts all later random draws."""
    session.seed, session.draws = seed, 0
    session.random.seed(seed)


@action("SetObjectFilter")
def set_object_filter(session: Session, objectIds: list[str]) -> None:
    """SetObjectFilter: metadata list only these objects."""
    session.change(shown=frozenset(objectIds))


@action("ResetObjectFilter")
def reset_object_filter(session: Session) -> None:
    """ResetObjectFilter: metadata list all objects."""
    session.change(shown=None)

"""Actions that set up the scene and the way it is shown."""

from __future__ import annotations

from typing import Any

from ovman.engine import floorplan
from ovman.engine.actions.registry import action
from ovman.engine.engine import SCENE_SUFFIX, Engine
from ovman.engine.settings import Settings
from ovman.engine.world import Refused

LARGEST_PX = 8192
"""Longest side of a picture that a client may ask for."""
LARGEST_GRID_M = 5.0


@action("GetScenesInBuild")
def scenes_in_build(engine: Engine) -> list[str]:
    return [name + SCENE_SUFFIX for name in floorplan.names()]


@action("Reset")
def reset(engine: Engine, sceneName: str | None = None, **rest: Any) -> None:
    scene = sceneName or engine.scene_name
    try:
        engine.load(scene)
    except KeyError:
        raise Refused(f"Scene '{scene}' couldn't be loaded because it is not in this build.") from None


@action("Initialize")
def initialize(
    engine: Engine,
    gridSize: float = Settings.grid_m,
    snapToGrid: bool = Settings.snap_to_grid,
    rotateStepDegrees: float = Settings.turn_deg,
    fieldOfView: float | None = None,
    visibilityDistance: float = Settings.visibility_m,
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
    agentMode: str = "default",
    agentCount: int = 1,
    **rest: Any,
) -> dict[str, float]:
    world = engine.world
    fov = Settings.field_of_view_deg if fieldOfView is None else fieldOfView
    if agentMode.lower() != "default":
        raise Refused(f"Unsupported agent mode: {agentMode}. This engine has the agent mode 'default'.")
    if agentCount != 1:
        raise Refused(f"Unsupported number of agents: {agentCount}. This engine has one agent.")
    if not 0 < fov < 180:
        raise Refused(f"fov must be set to (0, 180) noninclusive. You gave {fov:g}.")
    if not 0 < gridSize <= LARGEST_GRID_M:
        raise Refused("grid size must be in the range (0,5]")
    if rotateStepDegrees <= 0:
        raise Refused("rotateStepDegrees must be a non-zero, non-negative float")
    if snapToGrid and rotateStepDegrees % 90 != 0:
        raise Refused(
            f"Invalid values 'rotateStepDegrees': ${rotateStepDegrees:g} and 'snapToGrid':$True. 'snapToGrid': 'True' is not "
            "supported when 'rotateStepDegrees' is different from grid rotation steps of 0, 90, 180, 270 or 360."
        )
    for name, angle in (("maxDownwardLookAngle", maxDownwardLookAngle), ("maxUpwardLookAngle", maxUpwardLookAngle)):
        if angle < 0:
            raise Refused(f"{name} must be a non-negative float")
    if not 0 < cameraNearPlane < cameraFarPlane:
        raise Refused(f"The camera's planes must satisfy 0 < near < far. You gave {cameraNearPlane:g} and {cameraFarPlane:g}.")
    engine.change(
        grid_m=gridSize,
        snap_to_grid=snapToGrid,
        turn_deg=rotateStepDegrees,
        field_of_view_deg=fov,
        visibility_m=visibilityDistance if visibilityDistance > 0 else Settings.visibility_m,
        near_m=cameraNearPlane,
        far_m=cameraFarPlane,
        look_up_deg=maxUpwardLookAngle,
        look_down_deg=maxDownwardLookAngle,
        depth=renderDepthImage,
        instances=renderInstanceSegmentation,
        classes=renderSemanticSegmentation,
        normals=renderNormalsImage,
        fast_emit=fastActionEmit,
    )
    engine.auto_simulation = autoSimulation
    world.agent.position = engine.snapped(world.agent.position)
    return {"cameraNearPlane": cameraNearPlane, "cameraFarPlane": cameraFarPlane}


@action("ChangeResolution")
def change_resolution(engine: Engine, x: int, y: int) -> None:
    if not (0 < x <= LARGEST_PX and 0 < y <= LARGEST_PX):
        raise Refused(f"Screen resolution must be within 1x1 and {LARGEST_PX}x{LARGEST_PX}, not {x}x{y}.")
    engine.width, engine.height = x, y


@action("ChangeQuality")
def change_quality(engine: Engine, quality: str) -> None:
    """There is one quality."""


@action("SetRandomSeed")
def set_random_seed(engine: Engine, seed: int) -> None:
    engine.seed, engine.draws = seed, 0


@action("SetObjectFilter")
def set_object_filter(engine: Engine, objectIds: list[str]) -> None:
    engine.change(shown=frozenset(objectIds))


@action("ResetObjectFilter")
def reset_object_filter(engine: Engine) -> None:
    engine.change(shown=None)

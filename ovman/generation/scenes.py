"""Stage `scenes`: what is in a scene before anything changes, where the agent can stand, and the waypoints of its tours."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ovman.cache import Cache, digest
from ovman.generation.placement import FreeFloor
from ovman.generation.roaming import roam
from ovman.navigation.grid import Cell, Grid, farthest_points
from ovman.processes import map_items
from ovman.records.geometry import Point, Position
from ovman.records.record import DEGREE_DECIMALS
from ovman.records.scene import Alteration, Scene, SceneObject, Spare
from ovman.settings import Settings
from ovman.settings.splits import Homes
from ovman.sim.scenes import SceneError, load_scene
from ovman.sim.session import Session, SimulatorError
from ovman.sim.world import AGENT_RADIUS_M, World, is_dynamic, position

AREA_M2 = 1.6
"""Floor within reach for each waypoint of a home's tour: both tours then show 96 % of the large movable things (300 pixels)"""


def survey(session: Session, waypoints: int, step_m: float) -> Scene:
    """Return the record of an untouched scene, without the instances that the simulator can move (`survey_with_movers`).

    waypoints: of each of its tours, at least; step_m: spacing of the navigation grid, metres. A home has a waypoint for every
    AREA_M2 of floor that the agent reaches. SceneError for a scene with fewer cells than waypoints.
    """
    session.reset()
    start = session.pose
    points = session.reachable()
    grid = Grid.from_positions(points, step_m)
    objects = session.objects
    spawn = grid.nearest(start.x, start.z)
    component = grid.component(spawn)
    found = {k: _record(k, o) for k, o in sorted(objects.items())}
    house, rooms = load_scene(session.scene), None
    if not isinstance(house, str):
        waypoints = max(waypoints, math.ceil(len(component) * step_m**2 / AREA_M2))
        spares = house["metadata"].get("spares", {})
        found = {k: _furnished(one, objects[k], spares.get(k)) for k, one in found.items()}
        corners = [[(round(float(p["x"]), 4), round(float(p["z"]), 4)) for p in room["floorPolygon"]] for room in house["rooms"]]
        rooms = tuple(map(tuple, corners))
    if len(component) < waypoints:
        says = f"{session.scene} has {len(component)} cells to stand on; lower it, or leave the scene out of its splits"
        raise SceneError(f"tour.waypoints is {waypoints}, but {says}")

    def placed(cells: Iterable[Cell]) -> tuple[Point, ...]:
        return tuple((round(x, 4), round(z, 4)) for x, z in map(grid.centre, cells))

    floor = next(o for o in objects.values() if o["objectType"] == "Floor")["axisAlignedBoundingBox"]
    scene = Scene(
        scene=session.scene,
        start=(round(start.x, 4), round(start.z, 4)),
        floor_y=round(floor["center"]["y"] + floor["size"]["y"] / 2, 4),
        reachable=tuple(sorted((round(x, 4), round(z, 4)) for x, z in points)),
        components=tuple(sorted((len(c) for c in grid.components()), reverse=True)),
        waypoints=(),
        other_waypoints=(),
        mobile=(),
        rooms=rooms,
        objects=tuple(found.values()),
    )
    cells = sorted(component)
    off_spares = scene.are_off_spares(np.array(placed(cells)), AGENT_RADIUS_M)
    stands = [cell for cell, off in zip(cells, off_spares, strict=True) if off]
    # The other tour begins at the next cell after those of the first, or at the last of them if none follows.
    farthest = farthest_points(grid, stands, min(waypoints + 1, len(stands)), spawn)
    other = farthest_points(grid, stands, waypoints, farthest[-1])
    return scene.model_copy(update={"waypoints": placed(farthest[:waypoints]), "other_waypoints": placed(other)})


def _record(name: str, metadata: Mapping[str, Any]) -> SceneObject:
    return SceneObject(
        id=name,
        category=metadata["objectType"],
        moveable=metadata["moveable"],
        pickupable=metadata["pickupable"],
        receptacle=metadata["receptacle"],
        position=position(metadata),
        size=Position(**{axis: round(metadata["axisAlignedBoundingBox"]["size"][axis], 4) for axis in "xyz"}),
        parents=tuple(metadata["parentReceptacles"] or ()),
    )


def _furnished(item: SceneObject, metadata: Mapping[str, Any], spare: Mapping[str, Any] | None) -> SceneObject:
    """Return an object of a home with its shape, its yaw and its second place."""
    second = None
    if spare is not None:
        second = Spare(x=spare["position"]["x"], z=spare["position"]["z"], yaw_deg=spare["rotation"]["y"])
    yaw_deg = round(float(metadata["rotation"]["y"]), DEGREE_DECIMALS)
    return item.model_copy(update={"asset": metadata["assetId"] or None, "yaw_deg": yaw_deg, "spare": second})


def survey_with_movers(session: Session, constants: Settings) -> Scene:
    """Return the record of an untouched scene, with the instances that the simulator can move by a step.

    Resets the session for each of them.
    """
    scene, found = survey(session, constants.tour.waypoints, constants.primitives.step_m), []
    for item in (one for one in scene.objects if one.dynamic):
        floor = FreeFloor.of(scene, item, constants.primitives.step_m, scene.waypoints)
        walk = roam(scene, item, floor, constants.mover.step_m)
        if walk is not None:
            alteration = Alteration(kind="motion", instance=item.id, roam=walk)
            with suppress(SimulatorError):
                World(session, [alteration], constants.mover, np.random.default_rng(0), is_dynamic)
                found.append(item.id)
    return scene.model_copy(update={"mobile": tuple(found)})


def draw_homes(homes: Homes, workers: int = 1) -> list[str]:
    """Draw the homes of a split, and return their names. The log says which were drawn again, and why."""
    return map_items(_draw_home, homes.stems, workers)


def _draw_home(stem: str) -> str:
    from ovman.homes.generate import draw

    _, assets, rooms, seed = stem.split("-")
    home = draw(seed, int(rooms), assets)
    again = "".join(f"; drawn again: {faults[0]}" for faults in home.redraws)
    print(f"{home.name}: {sum(home.report.areas_m2.values()):.0f} m2{again}", flush=True)
    return home.name


def run(scenes: Sequence[str], settings: Settings, output: Path, cache: Cache, workers: int = 1) -> None:
    """Survey scenes and write their records to `output`, one per line, in their order."""
    records = map_items(partial(_survey, settings=settings, cache=cache), scenes, workers)
    output.write_text("".join(records), encoding="utf-8")


def _survey(scene: str, settings: Settings, cache: Cache) -> str:
    def survey() -> Any:
        with Session(scene, settings) as session:
            return session.with_restarts(lambda: survey_with_movers(session, settings).to_json())

    found = Scene.from_json(cache.get_or_compute(digest(scene, settings.constants()), survey))
    moving = sum(one.dynamic for one in found.objects)
    print(f"{scene}: {len(found.reachable)} cells, {len(found.objects)} objects, {moving} of them movable", flush=True)
    return found.to_line()

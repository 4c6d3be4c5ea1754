"""Stage `scenes`: what is in a scene before anything changes, where the agent can stand, and the waypoints of its tour."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ovman.navigation import Grid, farthest_points
from ovman.sim.change import dynamic, position
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

SCHEMA = "ovman-scene/1"


class SceneError(ValueError):
    """A scene that the settings do not fit; one line: the setting, the scene and the remedy."""

    says_all = True


def survey(session: Session, waypoints: int, step_m: float) -> dict[str, Any]:
    """The record of an untouched scene: objects, reachable points, components, tour waypoints. Metres, floor plane (x, z).

    SceneError for a scene with fewer cells than waypoints.
    """
    session.reset()
    start = session.pose
    points = session.reachable()
    grid = Grid.from_positions(points, step_m)
    objects = session.objects
    spawn = grid.nearest(start.x, start.z)
    component = grid.component(spawn)
    if len(component) < waypoints:
        says = f"{session.scene} has {len(component)} cells to stand on; lower it, or leave the scene out of benchmark.scenes"
        raise SceneError(f"tour.waypoints is {waypoints}, but {says}")
    floor = next(o for o in objects.values() if o["objectType"] == "Floor")["axisAlignedBoundingBox"]
    return {
        "schema": SCHEMA,
        "scene": session.scene,
        "start": {"x": round(start.x, 4), "z": round(start.z, 4)},
        "floor_y": round(floor["center"]["y"] + floor["size"]["y"] / 2, 4),
        "reachable": sorted([round(x, 4), round(z, 4)] for x, z in points),
        "components": sorted((len(c) for c in grid.components()), reverse=True),
        "waypoints": [
            {"x": round(x, 4), "z": round(z, 4)} for x, z in map(grid.centre, farthest_points(grid, component, waypoints, spawn))
        ],
        "objects": [
            {
                "id": k,
                "category": o["objectType"],
                "moveable": o["moveable"],
                "pickupable": o["pickupable"],
                "receptacle": o["receptacle"],
                "position": position(o),
                "size": {axis: round(o["axisAlignedBoundingBox"]["size"][axis], 4) for axis in "xyz"},
                "parents": o["parentReceptacles"] or [],
            }
            for k, o in sorted(objects.items())
        ],
    }


def run(scene: str, constants: StageSettings, output: Path, journal: Path) -> None:
    """Write the record of `scene` to `output`; `journal` keeps it for the next run under the same constants."""
    kept = Journal(journal)
    with Session(scene, constants) as session:
        record = kept.unit(
            digest(scene, constants.canonical),
            lambda: session.surviving(lambda: survey(session, constants.tour.waypoints, constants.primitives.step_m)),
        )
    output.write_text(json.dumps(record, separators=(",", ":")) + "\n")
    moving = sum(map(dynamic, record["objects"]))
    print(f"{scene}: {len(record['reachable'])} cells, {len(record['objects'])} objects, {moving} of them movable", flush=True)

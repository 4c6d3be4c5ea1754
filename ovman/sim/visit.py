"""Visits: the tour of a scene in one world state, and its recording as a zip file of files in common formats.

`visit.json` has the poses, the instances seen and the place of every dynamic instance. View i has `{i:02d}_rgb.png`,
`{i:02d}_depth.png` (16 bit, millimetres) and `{i:02d}_ids.png` (16 bit; 0 is nothing, k is the k-th entry of "instances").
A visit that exists is whole.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.atomic import clear_partials
from ovman.cache import digest
from ovman.records.geometry import Point, Position
from ovman.records.scene import Alteration, MoverRecord
from ovman.records.tour import Light, Sensors, Tour
from ovman.records.visit import MILLIMETRES, RECORD, Present, SensedPose, View, ViewPose, Visit, picture_name, write_tour
from ovman.sim.images import encode_png, index_instances
from ovman.sim.sensing import Sensing, placed
from ovman.sim.session import AgentPose, Session, illuminate
from ovman.sim.world import World, is_dynamic, position


def mover_seed(root: int, of: str, alterations: Sequence[Alteration]) -> int | None:
    """Return the part of a visit's name that stands for the draws of its movers, or None if nothing moves.

    root: of the benchmark; of: id of the candidate or the episode for which the tour is recorded.
    """
    return seeds.integer(root, *seeds.tour_movers(of)) if any(one.kind == "motion" for one in alterations) else None


def visit_name(alterations: Sequence[Alteration], seed: int | None, tour: Tour, waypoints: tuple[Point, ...]) -> str:
    """Return the name of the visit of a world state; equal visits of a scene share it.

    seed: from `mover_seed`. waypoints: of the scene's own tour, which names do not mention.
    """
    own = [] if tour == Tour(waypoints=waypoints, headings=tour.headings) else [digest(tour.to_json())[:6]]
    if not alterations:
        return "-".join(["untouched", *own])
    content = digest([a.to_json() for a in alterations], seed)
    return "-".join([alterations[0].kind, alterations[0].instance.split("|")[0], content[:10], *own])


def views(tour: Tour) -> list[AgentPose]:
    """Return the views of a tour, in order."""
    return [AgentPose(pose.x, pose.z, pose.yaw_deg) for pose in tour.poses]


def look(session: Session, world: World, pose: AgentPose, masks_only: bool = False) -> Any:
    """Return the event of the agent's view from `pose`, after every mover of the world has taken its step.

    masks_only: RGB and depth are not needed.
    """
    images = session.images(masks_only)
    if not world.movers:
        return session.teleport(pose, **images)
    session.step("UnpausePhysicsAutoSim")  # a dense tour stops time between its views; every view takes the same time
    session.teleport(pose)
    world.after_action()
    return session.step("Pass", **images)


def observe(
    session: Session, world: World, name: str, alterations: Sequence[Alteration], views: Sequence[AgentPose], min_mask_px: int
) -> Visit:
    """Walk the tour `views` in `world` with exact sensors and without pictures. Arguments and errors as for `record`."""
    return _walk(session, world, name, alterations, views, min_mask_px)


def record(
    session: Session,
    world: World,
    name: str,
    alterations: Sequence[Alteration],
    views: Sequence[AgentPose],
    min_mask_px: int,
    file: Path,
    key: str,
    light: Light | None = None,
    sensors: Sensors | None = None,
) -> Visit:
    """Walk the tour `views` in `world` and record it as `file`. SimulatorError if a view is not free.

    min_mask_px: masks of fewer pixels are not written down. key: of the recording (`VisitFiles.key`), written with the digests of
    all files. light: of the visit, None for the scene's own. sensors: what the agent senses with; the depth that is written is
    the sensed one, None for exact ones. Masks and positions are true.
    """
    clear_partials(file)
    contents = dict[str, bytes]()
    illuminate(session, light)
    sensing = None if sensors is None else Sensing(sensors)

    def keep(number: int, event: Any, index: np.ndarray) -> None:
        contents[picture_name(number, "rgb")] = encode_png(event.frame)
        depth = event.depth_frame if sensing is None else sensing.depth(event.depth_frame)
        depth_mm = np.clip(np.round(depth * MILLIMETRES), 0, np.iinfo(np.uint16).max)
        contents[picture_name(number, "depth")] = encode_png(depth_mm.astype(np.uint16))
        contents[picture_name(number, "ids")] = encode_png(index)

    visit = _walk(session, world, name, alterations, views, min_mask_px, sensing, keep)
    write_tour(file, contents | {RECORD: visit.to_line().encode()}, key)
    return visit


def _walk(
    session: Session,
    world: World,
    name: str,
    alterations: Sequence[Alteration],
    views: Sequence[AgentPose],
    min_mask_px: int,
    sensing: Sensing | None = None,
    keep: Callable[[int, Any, np.ndarray], None] | None = None,
) -> Visit:
    """Walk a tour; `keep` gets the number, the event and the index picture of each view. Without it there are masks alone."""
    gone = {a.instance for a in alterations if a.kind == "disable"}

    def there() -> dict[str, Mapping[str, Any]]:
        return {k: o for k, o in session.objects.items() if is_dynamic(o) and k not in gone}

    present = {k: Present(category=o["objectType"], position=position(o)) for k, o in there().items()}
    here: dict[str, Position] = {k: v.position for k, v in present.items()}
    recorded = []
    for i, pose in enumerate(views):
        event = look(session, world, pose, masks_only=keep is None)
        index, names, sizes = index_instances(event.instance_masks, min_mask_px)
        now = {k: position(o) for k, o in there().items()}
        camera = event.metadata["cameraPosition"]
        recorded.append(
            View(
                pose=ViewPose(x=pose.x, z=pose.z, yaw_deg=pose.yaw_deg, horizon_deg=pose.horizon_deg),
                camera=(at := Position(x=round(camera["x"], 4), y=round(camera["y"], 4), z=round(camera["z"], 4))),
                sensed=None if sensing is None else _sensed(sensing, pose, at),
                instances=tuple(names),
                seen=sizes,
                moved={k: p for k, p in now.items() if p != here[k]},
            )
        )
        here = now
        if keep is not None:
            keep(i, event, index)
    return Visit(
        scene=session.scene,
        visit=name,
        alterations=tuple(alterations),
        placed=world.placed,
        present=present,
        movers=tuple(
            MoverRecord(instance=k, position=mover.position, heading_deg=mover.heading_deg, path=tuple(world.paths[k]))
            for k, mover in world.movers.items()
        ),
        views=tuple(recorded),
    )


def _sensed(sensing: Sensing, pose: AgentPose, camera: Position) -> SensedPose:
    sensed = sensing.pose(pose)
    x, y, z = placed((camera.x, camera.y, camera.z), pose, sensed)
    return SensedPose(
        pose=ViewPose(x=sensed.x, z=sensed.z, yaw_deg=sensed.yaw_deg, horizon_deg=sensed.horizon_deg),
        camera=Position(x=x, y=y, z=z),
    )


def drift_m(visit: Visit, instance: str, placement: Point) -> float:
    """Return the farthest distance of an instance from `placement` (x, z) at any view of a visit, metres on the floor plane."""
    return max(float(np.hypot(p[instance].x - placement[0], p[instance].z - placement[1])) for p in visit.positions)

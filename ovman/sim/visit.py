"""Visits: the tour of a scene in one world state, recorded as files that anyone can open.

`visit.json` has the poses, what was seen and where every dynamic instance was; beside it lie, for view i, `{i:02d}_rgb.png`,
`{i:02d}_depth.png` (16 bit, millimetres) and `{i:02d}_ids.png` (16 bit; 0 is nothing, k is the k-th entry of "instances").
A visit is written to a temporary directory and renamed, so that what exists is whole.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ovman.sim.change import Alteration, World, dynamic, position
from ovman.sim.session import AgentPose, Session
from ovman.workflow import journal

SCHEMA = "ovman-visit/1"
MILLIMETRES = 1000.0
PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP)
"""Hardly larger than what tries every filter on every row, in half the time."""


@dataclass(frozen=True)
class Visit:
    """A recorded visit: the content of its visit.json, with the questions that are asked of it."""

    record: Mapping[str, Any]

    @staticmethod
    def load(directory: Path) -> Visit:
        return Visit(json.loads((directory / "visit.json").read_text()))

    @property
    def name(self) -> str:
        return str(self.record["visit"])

    @property
    def views(self) -> Sequence[Mapping[str, Any]]:
        return self.record["views"]

    @cached_property
    def category(self) -> Mapping[str, str]:
        """Category of every dynamic instance that is present."""
        return {k: v["category"] for k, v in self.record["present"].items()}

    @cached_property
    def positions(self) -> Sequence[Mapping[str, Mapping[str, float]]]:
        """Position of every present dynamic instance at each view, metres."""
        here = {k: v["position"] for k, v in self.record["present"].items()}
        at_views = []
        for view in self.views:
            here = here | view["moved"]
            at_views.append(here)
        return at_views

    def sightings(self, category: str, also: Sequence[str] = ()) -> list[dict[str, Any]]:
        """Views of the instances of a category (and of `also`): view, instance, px, x, z, in the order of the tour."""
        return [
            {"view": i, "instance": k, "px": px, "x": here[k]["x"], "z": here[k]["z"]}
            for i, (view, here) in enumerate(zip(self.views, self.positions, strict=True))
            for k, px in view["seen"].items()
            if k in here and (self.category[k] == category or k in also)
        ]

    def drift_m(self, instance: str, placement: tuple[float, float]) -> float:
        """Farthest that an instance was from `placement` (x, z) at any view, metres on the floor plane."""
        return max(float(np.hypot(p[instance]["x"] - placement[0], p[instance]["z"] - placement[1])) for p in self.positions)


def visit_name(alterations: Sequence[Alteration], seed: int | None) -> str:
    """Name of the visit of a world state: equal states share it. `seed` is the mover's and None where nothing moves."""
    if not alterations:
        return "untouched"
    content = journal.digest([a.to_json() for a in alterations], seed)
    return "-".join([alterations[0].kind, alterations[0].instance.split("|")[0], content[:10]])


def write_png(path: Path, image: np.ndarray) -> None:
    """Writes an image (H, W) or, blue first, (H, W, 3) of 8 or 16 bit. OSError where it cannot be."""
    if not cv2.imwrite(str(path), image, PNG):
        raise OSError(f"{path}: could not be written; is the disk full?")


def _seen(event: Any, min_mask_px: int) -> tuple[np.ndarray, list[str], dict[str, int]]:
    """Index image (0 nothing, k the k-th name), the names of the instances in it, and mask sizes of at least `min_mask_px`."""
    names = sorted(event.instance_masks.keys())
    index = np.zeros(event.depth_frame.shape, np.uint16)
    sizes = {}
    for k, name in enumerate(names, start=1):
        mask = event.instance_masks[name]
        index[mask] = k
        size = int(np.count_nonzero(mask))
        if size >= min_mask_px:
            sizes[name] = size
    return index, names, sizes


def tour(waypoints: Sequence[tuple[float, float]], headings: int) -> list[AgentPose]:
    """The views of a tour: `headings` equally spaced yaws at each waypoint, in order."""
    return [AgentPose(x, z, 360.0 * h / headings) for x, z in waypoints for h in range(headings)]


def look(session: Session, world: World, pose: AgentPose) -> Any:
    """The event of the agent's view from `pose`, after the mover, if there is one, has taken its step."""
    if world.mover is None:
        return session.teleport(pose, image=True)
    session.teleport(pose)
    world.after_action()
    return session.step("Pass", image=True)


def record(
    session: Session,
    world: World,
    name: str,
    alterations: Sequence[Alteration],
    views: Sequence[AgentPose],
    min_mask_px: int,
    directory: Path,
    key: str,
) -> Visit:
    """Walk the tour `views` in `world` and record it under `directory`. SimulatorError if a view is not free.

    `key` is written beside it, so that who finds the directory later knows whether it is what it would record itself.
    """
    partial = directory.with_name(directory.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)

    def there() -> dict[str, Mapping[str, Any]]:
        return {k: o for k, o in session.objects.items() if dynamic(o) and k not in gone}

    gone = {a.instance for a in alterations if a.kind == "disable"}
    present = {k: {"category": o["objectType"], "position": position(o)} for k, o in there().items()}
    here = {k: v["position"] for k, v in present.items()}
    records = []
    for i, pose in enumerate(views):
        event = look(session, world, pose)
        index, names, sizes = _seen(event, min_mask_px)
        now = {k: position(o) for k, o in there().items()}
        camera = event.metadata["cameraPosition"]
        records.append(
            {
                "pose": {"x": pose.x, "z": pose.z, "yaw_deg": pose.yaw_deg, "horizon_deg": pose.horizon_deg},
                "camera": {axis: round(camera[axis], 4) for axis in "xyz"},
                "instances": names,
                "seen": sizes,
                "moved": {k: p for k, p in now.items() if p != here[k]},
            }
        )
        here = now
        write_png(partial / f"{i:02d}_rgb.png", event.frame[..., ::-1])
        depth_mm = np.clip(np.round(event.depth_frame * MILLIMETRES), 0, np.iinfo(np.uint16).max)
        write_png(partial / f"{i:02d}_depth.png", depth_mm.astype(np.uint16))
        write_png(partial / f"{i:02d}_ids.png", index)
    mover = None
    if world.mover is not None:
        mover = {
            "instance": world.mover_id,
            "path": [{"x": x, "z": z} for x, z in world.path],
            "along_m": round(world.mover.along_m, 4),
            "direction": world.mover.direction,
        }
    visit = {
        "schema": SCHEMA,
        "scene": session.scene,
        "visit": name,
        "alterations": [a.to_json() for a in alterations],
        "placed": world.placed,
        "present": present,
        "mover": mover,
        "views": records,
    }
    (partial / "visit.json").write_text(json.dumps(visit, separators=(",", ":")) + "\n")
    (partial / "key").write_text(key)
    shutil.rmtree(directory, ignore_errors=True)
    os.replace(partial, directory)
    return Visit(visit)

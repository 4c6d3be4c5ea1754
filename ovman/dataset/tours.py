"""The table of tours: what an agent sees in both visits, and nothing that it may not see.

The rows of a tour hold neither query nor change: no instance, no mask, no light, no seed, and no true pose where the sensed one
differs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS
from ovman.dataset.columns import Column, Kind, Table
from ovman.dataset.episodes import tour_id
from ovman.evaluation.tours import TourCache
from ovman.perception.tour_files import PICTURES, cameras
from ovman.records.episode import Episode
from ovman.records.visit import VisitFiles, VisitManifest, read_verified
from ovman.settings.benchmark import Camera
from ovman.sim.session import Session

TABLE = Table(
    "tours",
    "A row is a view of a recorded tour, as an agent is given it. `first_tour` and `second_tour` of an episode name its tours. "
    "Episodes may share a tour.",
    (
        Column("tour", Kind.TEXT, "id of the tour; it says nothing about what changed"),
        Column("scene", Kind.TEXT, "iTHOR floor plan; no agent is told it"),
        Column("view", Kind.WHOLE, "number of the view in the tour, from 0, in the order in which they were taken"),
        Column("rgb", Kind.IMAGE, "colours, 8 bit a channel, row 0 at the top, without loss"),
        Column("depth", Kind.IMAGE, "depth along the optical axis, 16 bit grey, whole millimetres, 0 where unknown"),
        Column("camera_x", Kind.REAL, "position of the camera as the agent is told it, metres"),
        Column("camera_y", Kind.REAL, "the same, up"),
        Column("camera_z", Kind.REAL, "the same"),
        Column("yaw_deg", Kind.REAL, "yaw as the agent is told it, degrees; 0 along +z, 90 along +x"),
        Column("horizon_deg", Kind.REAL, "tilt of the camera, degrees; positive looks down"),
        Column("width_px", Kind.WHOLE, "width of both pictures, pixels"),
        Column("height_px", Kind.WHOLE, "height of both pictures, pixels"),
        Column("vertical_field_of_view_deg", Kind.REAL, "degrees from the upper to the lower edge"),
        Column("fx", Kind.REAL, "focal length, pixels"),
        Column("fy", Kind.REAL, "focal length, pixels; equal to fx, since pixels are square"),
        Column("cx", Kind.REAL, "principal point, pixels; the centre of pixel (0, 0) lies at 0.5"),
        Column("cy", Kind.REAL, "principal point, pixels; the centre of pixel (0, 0) lies at 0.5"),
    ),
)


@dataclass(frozen=True, slots=True)
class ToBeToured:
    """A tour, and an episode and visit "first" or "second" that it is of."""

    id: str
    episode: Episode
    which: str


def tours_of(episodes: Sequence[Episode]) -> dict[str, list[ToBeToured]]:
    """The tours of episodes by floor plan, each once, floor plans by name and tours in the order of the episodes."""
    found: dict[str, dict[str, ToBeToured]] = {scene: {} for scene in sorted({episode.scene for episode in episodes})}
    for episode in episodes:
        for which in VISITS:
            one = ToBeToured(tour_id(episode, which), episode, which)
            found[episode.scene].setdefault(one.id, one)
    return {scene: [*tours.values()] for scene, tours in found.items()}


@dataclass(frozen=True, slots=True)
class Recordings:
    """Where recorded tours lie. visits: the workflow's folder, None for none; cache: the others are recorded into it."""

    visits: Path | None
    cache: TourCache

    def places(self, scene: str, tours: Sequence[ToBeToured]) -> Iterator[tuple[ToBeToured, Path]]:
        """The tours of a floor plan with their directories. TourError for a damaged one, SimulatorError where one is refused.

        The simulator is started for the first tour that is in neither place.
        """
        manifest = self._manifest(scene)
        with Session(scene, tours[0].episode.settings) as session:
            for tour in tours:
                name = tour.episode.visits[tour.which]
                if manifest is not None and self.visits is not None and name in manifest.visits:
                    yield tour, manifest.directory(self.visits, name)
                else:
                    yield tour, self.cache.places(session, tour.episode)[name]

    def _manifest(self, scene: str) -> VisitManifest | None:
        file = None if self.visits is None else self.visits / f"{scene}.json"
        return VisitManifest.read(file)[0] if file is not None and file.is_file() else None


def rows(tour: ToBeToured, directory: Path) -> Iterator[dict[str, Any]]:
    """The rows of a recorded tour, its pictures byte for byte as they were recorded. TourError where they are not."""
    camera = tour.episode.protocol.camera
    files = VisitFiles.load(directory)
    for number, taken in enumerate(cameras(directory, camera.field_of_view_deg)):
        pictures = {kind: read_verified(directory / f"{number:02d}_{kind}.png", files) for kind in PICTURES}
        x, y, z = taken.position
        yield TABLE.row(
            {"tour": tour.id, "scene": tour.episode.scene, "view": number}
            | {kind: {"bytes": content, "path": None} for kind, content in pictures.items()}
            | {"camera_x": x, "camera_y": y, "camera_z": z, "yaw_deg": taken.yaw_deg, "horizon_deg": taken.horizon_deg}
            | intrinsics(camera)
        )


def intrinsics(camera: Camera) -> dict[str, float]:
    """Width, height, vertical field of view, focal lengths and principal point of a camera with square pixels.

    Focal lengths are rounded to 1e-6 of a pixel, so that their bytes do not depend on the processor's last bit.
    """
    focal = round(camera.height_px / 2 / math.tan(math.radians(camera.field_of_view_deg) / 2), 6)
    return {
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "vertical_field_of_view_deg": camera.field_of_view_deg,
        "fx": focal,
        "fy": focal,
        "cx": camera.width_px / 2,
        "cy": camera.height_px / 2,
    }

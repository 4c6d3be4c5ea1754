"""The record of a recorded tour, visit.json, "ovman-visit/2". Pictures lie beside it (`ovman.sim.visit`)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Literal, Self

from pydantic import Field

from ovman.records.change import Alteration, MoverRecord
from ovman.records.geometry import Position
from ovman.records.record import Count, Name, Record, Text
from ovman.records.sighting import Sighting
from ovman.records.visit_files import read_verified


class Present(Record):
    """A dynamic instance at the beginning of the tour: its category and its position in metres."""

    category: Text
    position: Position


class ViewPose(Record):
    """The agent's pose at a view: metres, degrees; a positive horizon looks down."""

    x: float
    z: float
    yaw_deg: float
    horizon_deg: float


class SensedPose(Record):
    """Where an agent whose sensors err takes itself and its camera to be."""

    pose: ViewPose
    camera: Position


class View(Record):
    """One view of a tour.

    camera: position of the camera in metres. sensed: what an agent is told instead of both, None where its sensors are exact.
    instances: ids by the values 1, 2, ... of the index picture. seen: sizes in pixels of the masks that are large enough to
    be written down. moved: positions of the instances that moved since the last view.
    """

    pose: ViewPose
    camera: Position
    sensed: SensedPose | None = None
    instances: tuple[str, ...]
    seen: Mapping[str, Count]
    moved: Mapping[str, Position]


class Visit(Record):
    """A recorded visit. Positions are centres of axis-aligned boxes, metres."""

    schema_id: Literal["ovman-visit/2"] = Field("ovman-visit/2", alias="schema")
    scene: Name
    visit: Name
    alterations: tuple[Alteration, ...]
    placed: Mapping[str, Position]
    present: Mapping[str, Present]
    movers: tuple[MoverRecord, ...]
    views: tuple[View, ...]

    @classmethod
    def load(cls, directory: Path) -> Self:
        """The record of the visit in `directory`.

        TourError where it is missing or is not what was recorded, RecordError where it is not what its schema says.
        """
        file = directory / "visit.json"
        return cls.parse(read_verified(file).decode(), str(file))

    @cached_property
    def positions(self) -> tuple[Mapping[str, Position], ...]:
        """Position of every present dynamic instance at each view."""
        here: Mapping[str, Position] = {k: v.position for k, v in self.present.items()}
        at_views = []
        for view in self.views:
            here = {**here, **view.moved}
            at_views.append(here)
        return tuple(at_views)

    def largest_px(self, instance: str) -> int:
        """The size of the largest mask of an instance in the tour, pixels; 0 where none was written down."""
        return max((view.seen.get(instance, 0) for view in self.views), default=0)

    def sightings(self, category: str) -> tuple[Sighting, ...]:
        """The views of the instances of a category, in the order of the tour."""
        return tuple(
            Sighting(view=i, instance=k, px=px, x=here[k].x, z=here[k].z)
            for i, (view, here) in enumerate(zip(self.views, self.positions, strict=True))
            for k, px in view.seen.items()
            if k in here and self.present[k].category == category
        )

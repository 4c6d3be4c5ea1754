"""The record of a scene before anything changes, "ovman-scene/2"."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ovman.records.geometry import Point, Position
from ovman.records.record import Count, Name, Record, Text


class SceneObject(Record):
    """One object of a scene. position, size: centre and size of its axis-aligned box, metres; parents: receptacles it is in."""

    id: Text
    category: Text
    moveable: bool
    pickupable: bool
    receptacle: bool
    position: Position
    size: Position
    parents: tuple[str, ...]

    @property
    def dynamic(self) -> bool:
        """Whether it can be moved or taken."""
        return self.moveable or self.pickupable


class Scene(Record):
    """An untouched scene. Metres, floor plane (x, z).

    start: where AI2-THOR puts the agent; floor_y: height of the floor; reachable: positions that the agent can reach, sorted;
    components: numbers of cells of the connected parts, largest first; waypoints: of a tour, in its order; other_waypoints:
    as many, sampled from another cell, for a second tour that is not the first again; mobile: ids
    of the instances that the simulator moves a step from where they stand, of those that have free floor beside them.
    """

    schema_id: Literal["ovman-scene/2"] = Field("ovman-scene/2", alias="schema")
    scene: Name
    start: Point
    floor_y: float
    reachable: tuple[tuple[float, float], ...]
    components: tuple[Count, ...]
    waypoints: tuple[Point, ...]
    other_waypoints: tuple[Point, ...]
    mobile: tuple[Text, ...]
    objects: tuple[SceneObject, ...]

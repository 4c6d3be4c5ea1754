"""The common parts of the maps of a page: the room, its waypoints, and the truth about the category."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ovman.agents.interface import VISITS
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.scene import Scene
from ovman.records.task import WorldState
from ovman.report.show import svg
from ovman.report.show.frame import PlanFrame
from ovman.report.show.labels import Labels
from ovman.report.show.reasoning import Reasoning

FURNITURE_M = 0.3
"""Least longer side of drawn furniture."""
FLAT_M = 0.05
"""Height below which an object is left out."""
SURROUNDINGS_M = 1.0
"""Margin around the answer; around everything else it is half of that."""
FARTHEST_M = 2.0
"""Farthest distance beyond the reachable cells at which an arm's object widens the plan."""
STEM = 30.0
"""Length of the pin's stem, in the units of a drawing."""
UNDRAWN = frozenset({"Floor", "Window", "Painting", "Curtains", "Blinds", "LightSwitch", "Mirror"})


@dataclass(frozen=True, slots=True)
class Room:
    """A scene and an episode in it, as the evaluator knows them."""

    scene: Scene
    episode: Episode

    def world(self, visit: int) -> WorldState:
        """The instances of the category that are present in the first (0) or second (1) visit."""
        return (self.episode.world_1, self.episode.world_2)[visit]

    def others(self, visit: int) -> dict[str, Point | None]:
        """Where the instances of other categories that change were at the end of a visit; None for one that is absent."""
        places = {one.instance: (one.before, one.after)[visit] for one in self.episode.others}
        return {k: None if at is None else (at.x, at.z) for k, at in places.items()}

    @property
    def paths(self) -> list[tuple[Point, ...]]:
        """The paths of movers, metres."""
        return [change.path for change in self.episode.changes if change.path]


def frame_of(room: Room, reasonings: Sequence[Reasoning], width: float, highest: float) -> PlanFrame:
    """The common frame of all maps of a page."""
    cells = list(room.scene.reachable)
    (left, right), (low, high) = ((min(axis) - FARTHEST_M, max(axis) + FARTHEST_M) for axis in zip(*cells, strict=True))
    objects = [
        item.at
        for reasoning in reasonings
        for items in reasoning.items
        for item in items
        if item.grounded and left <= item.at[0] <= right and low <= item.at[1] <= high
    ]
    instances = [k.position for visit in (0, 1) for k in room.world(visit)]
    about = [(x + dx, z + dz) for x, z in cells for dx in (-0.6, 0.6) for dz in (-0.6, 0.6)]
    x, z = room.episode.answer
    half = SURROUNDINGS_M / 2
    near = [(x + dx, z + dz) for dx in (-half, half) for dz in (-half, half)]
    return PlanFrame.around(
        [*about, *instances, *objects, *near, *(point for path in room.paths for point in path)], width, highest, half
    )


def draw_room(parent: Element, frame: PlanFrame, room: Room, visit: int) -> None:
    """The floor, the cells that the agent can reach, and the furniture as it stood in a visit."""
    floor = svg.group(parent, "room truth")
    here, moved = {k.id: k.position for k in room.world(visit)}, room.others(visit)
    for thing in sorted(room.scene.objects, key=lambda o: o.category != "Floor"):
        size, category = thing.size, thing.category
        of_category = category == room.episode.category
        if of_category and thing.id not in here:
            continue
        floor_plane = category == "Floor"
        small = max(size.x, size.z) < FURNITURE_M or size.y < FLAT_M
        if not floor_plane and not of_category and (category in UNDRAWN or small):
            continue
        if thing.id in moved and moved[thing.id] is None:
            continue
        x, z = here.get(thing.id) or moved.get(thing.id) or (thing.position.x, thing.position.z)
        corner = frame.at(x - size.x / 2, z + size.z / 2)
        name = "floor" if floor_plane else "thing of-category" if of_category else "thing"
        title = "" if floor_plane else thing.id
        svg.rectangle(floor, corner, size.x * frame.scale, size.z * frame.scale, name, title)
    cells = svg.group(parent, "grid")
    for x, z in room.scene.reachable:
        svg.circle(cells, frame.at(x, z), 1.1, "cell")


def draw_waypoints(parent: Element, frame: PlanFrame, room: Room, visit: int, labels: Labels) -> None:
    """The numbered waypoints of the tour of a visit."""
    group = svg.group(parent, "waypoints")
    for number, waypoint in enumerate(room.episode.tours[VISITS[visit]].waypoints, start=1):
        at = frame.at(*waypoint)
        svg.circle(group, at, 7.0, "waypoint", f"waypoint {number} of the tour")
        svg.text(group, at, str(number), "waypoint-number", dy="0.35em")
        labels.keep(at, 7.0)


def draw_instances(parent: Element, frame: PlanFrame, room: Room, visit: int, labels: Labels) -> None:
    """Crosses at the true instances of the category, the target and the distractor by name; the paths of movers."""
    group = svg.group(parent, "truth instances")
    episode = room.episode
    if visit == 1:
        draw_paths(group, frame, room)
    for instance in room.world(visit):
        at = frame.at(instance.x, instance.z)
        called = {episode.target: "target", episode.distractor: "distractor"}.get(instance.id)
        svg.cross(group, at, 6.0 if called else 4.5, f"instance {called or ''}".strip(), f"{instance.id} (truth)")
        labels.keep(at, 6.0)
        if called:
            size = 12.0
            box = labels.place(at, 8.0, called, size)
            svg.text(group, box.middle, called, "truth-label", dy="0.35em")


def draw_paths(parent: Element, frame: PlanFrame, room: Room) -> None:
    """The paths of movers."""
    for path in room.paths:
        points = [frame.at(x, z) for x, z in path]
        svg.polyline(parent, points, "mover", "path of the mover during the second tour (truth)")
        for u, v in points[::4]:
            svg.circle(parent, (u, v), 1.6, "mover-step")


def draw_change(parent: Element, frame: PlanFrame, room: Room) -> None:
    """Lines from the former to the new place of each displaced instance."""
    for change in room.episode.changes:
        if change.before is not None and change.after is not None:
            ends = [frame.at(end.x, end.z) for end in (change.before, change.after)]
            scripted = change.category == room.episode.category
            says = "was put elsewhere" if scripted else "was put elsewhere; it is of another category"
            svg.polyline(parent, ends, "change" if scripted else "other-change", f"{change.instance} {says} (truth)")
            svg.circle(parent, ends[0], 2.2, "change-end")


def draw_pin(parent: Element, frame: PlanFrame, room: Room, labels: Labels) -> None:
    """A star on a stem whose foot is the answer, so that it hides little of the map."""
    x, z = room.episode.answer
    foot = frame.at(x, z)
    top = foot[0], foot[1] - STEM
    group = svg.group(parent, "truth")
    svg.polyline(group, [foot, top], "stem")
    svg.circle(group, foot, 2.6, "foot")
    svg.star(group, top, 11.0, "answer-star", f"the answer ({x:.2f}, {z:.2f}) (truth)")
    labels.keep(foot, 3.0)
    labels.keep(top, 11.0)


def draw_surroundings(parent: Element, frame: PlanFrame, room: Room, radius_m: float) -> None:
    """The radius of success around the answer, the navigable cell nearest to it, and the spawn."""
    spawn, episode = room.episode.spawn, room.episode
    at = frame.at(*episode.answer)
    group = svg.group(parent, "truth answer")
    svg.circle(group, at, radius_m * frame.scale, "radius", f"within {radius_m:g} m of the answer (truth)")
    u, v = frame.at(*episode.nearest_navigable)
    svg.rectangle(group, (u - 3.5, v - 3.5), 7.0, 7.0, "navigable", "navigable cell nearest to the answer (truth)")
    begin = svg.group(parent, "spawn-mark")
    at = frame.at(spawn.x, spawn.z)
    svg.arrowhead(begin, at, spawn.yaw_deg, 9.0, "spawn", "the agent starts here")

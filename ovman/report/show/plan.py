"""Lay out the plans of a page: the frame, the furniture, and the labels of answers. The template plan.html draws them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ovman.records.episode import Episode
from ovman.records.geometry import Point, floor_point
from ovman.records.scene import Scene
from ovman.report.show.answers import FOUND, MISSED, Entry, Line
from ovman.report.show.evidence import Item

WIDTH, HIGHEST = 780.0, 660.0
"""Largest size of a drawing."""
MARGIN_M = 1.1
"""Margin around what the frame shows."""
SIGNS = {FOUND: " ✓", MISSED: " ✗"}
FURNITURE_M = 0.3
"""Least longer side of drawn furniture."""
FLAT_M = 0.05
"""Height below which an object is left out."""
UNDRAWN = frozenset({"Floor", "Window", "Painting", "Curtains", "Blinds", "LightSwitch", "Mirror"})
LETTER, PADDING = 13.0, 4.0
"""Size of the letters of labels, and the space around them."""
CHARACTER_WIDTH = 0.62
"""Width of a bold sans-serif letter, in units of its size."""
_SIDES = ((1, 0), (1, -1), (1, 1), (-1, 0), (-1, -1), (-1, 1), (0, -1), (0, 1))
_FARTHER = (1.0, 1.7, 2.6)
Box = tuple[float, float, float, float]
"""Left, top, right and bottom of an upright rectangle in a drawing."""


@dataclass(frozen=True, slots=True)
class Frame:
    """The floor plane seen from above: x to the right and z up, so yaw 0 looks up. scale: units of the drawing per metre."""

    x_min: float
    z_max: float
    scale: float
    width: float
    height: float

    @staticmethod
    def around(points: Sequence[Point], size: tuple[float, float] = (WIDTH, HIGHEST), margin_m: float = MARGIN_M) -> Frame:
        """Return the frame of points (x, z), metres, with a margin, as large as fits into a size."""
        (left, right), (low, high) = ((min(axis) - margin_m, max(axis) + margin_m) for axis in zip(*points, strict=True))
        scale = min(size[0] / (right - left), size[1] / (high - low))
        return Frame(left, high, scale, (right - left) * scale, (high - low) * scale)

    @staticmethod
    def of(scene: Scene, episode: Episode) -> Frame:
        """Return the frame of all plans of a page: reachable cells, instances, the answer, and paths of movers."""
        points = [*scene.reachable, *(one.position for world in (episode.world_1, episode.world_2) for one in world)]
        return Frame.around([*points, episode.answer, *(point for change in episode.changes for point in change.path or ())])

    def at(self, point: Point) -> Point:
        """Return where a point of the floor plane is drawn: units from the left and from the top, one decimal."""
        return round((point[0] - self.x_min) * self.scale, 1), round((self.z_max - point[1]) * self.scale, 1)


@dataclass
class Labels:
    """Place words next to points, one after the other, each where it overlaps least with what is taken already."""

    frame: Frame
    taken: list[Box] = field(default_factory=list)

    def keep(self, at: Point, radius: float) -> None:
        """Take a disc, so that no words are placed over it."""
        self.taken.append((at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius))

    def place(self, at: Point, radius: float, words: str) -> Box:
        """Take and return the box of words next to a disc."""
        half_width, half_height = len(words) * LETTER * CHARACTER_WIDTH / 2 + PADDING, LETTER * 0.6 + PADDING

        def candidate(side: Point, factor: float) -> Box:
            reach = radius * factor + 1.5
            u = at[0] + side[0] * (reach + half_width)
            v = at[1] + side[1] * (reach + half_height if not side[0] else 0.7 * reach + half_height)
            return u - half_width, v - half_height, u + half_width, v + half_height

        best = min((candidate(side, factor) for factor in _FARTHER for side in _SIDES), key=self._cost)
        self.taken.append(best)
        return best

    def _cost(self, box: Box) -> float:
        left, top, right, bottom = box
        outside = max(-left, 0) + max(-top, 0) + max(right - self.frame.width, 0) + max(bottom - self.frame.height, 0)
        return sum(overlap(box, other) for other in self.taken) + 100 * outside


def overlap(one: Box, other: Box) -> float:
    """Return the area that two boxes share."""
    wide, high = min(one[2], other[2]) - max(one[0], other[0]), min(one[3], other[3]) - max(one[1], other[1])
    return max(wide, 0.0) * max(high, 0.0)


@dataclass(frozen=True, slots=True)
class Label:
    """Words in a box for what is drawn at a place; verdict: of the answer there."""

    words: str
    box: Box
    at: Point
    verdict: str = ""


def list_furniture(scene: Scene, episodes: Sequence[Episode], visit: int) -> Iterator[tuple[str, Point, Point, str]]:
    """Yield class, centre, size and id of the floor and of furniture as it stood in the first (0) or second (1) visit.

    episodes: Of one world pair. All instances of their categories are drawn. The floor of a home is its rooms, `Scene.rooms`.
    """
    categories, changes = {episode.category for episode in episodes}, episodes[0].changes
    where: dict[str, Point | None] = {thing.id: None for thing in scene.objects if thing.category in categories}
    where |= {change.instance: floor_point((change.before, change.after)[visit]) for change in changes}
    for episode in episodes:
        where |= {instance.id: instance.position for instance in (episode.world_1, episode.world_2)[visit]}
    turned = {change.instance: change.yaw_deg for change in changes if visit == 1}
    for thing in sorted(scene.objects, key=lambda thing: thing.category != "Floor"):
        is_small = max(thing.size.x, thing.size.z) < FURNITURE_M or thing.size.y < FLAT_M
        kind = "floor" if thing.category == "Floor" else "thing of-category" if thing.category in categories else "thing"
        size, at = thing.turned(turned.get(thing.id)).size, where.get(thing.id, thing.place)
        is_left_out = scene.rooms is not None if kind == "floor" else is_small or thing.category in UNDRAWN
        if at is not None and (kind == "thing of-category" or not is_left_out):
            yield kind, at, (size.x, size.z), thing.id


def label_objects(frame: Frame, items: Sequence[Item]) -> list[Label]:
    """Return the labels of the grounded objects of a map."""
    labels, grounded = Labels(frame), [item for item in items if item.is_grounded]
    for item in grounded:
        labels.keep(frame.at(item.at), radius(item))
    return [Label(str(item.id), labels.place(frame.at(item.at), radius(item), str(item.id)), item.at) for item in grounded]


def radius(item: Item) -> float:
    """Return the radius of an object's mark, which grows with the number of detections."""
    return min(4.0 + 1.6 * math.sqrt(len(item.track)), 12.0)


def label_answers(frame: Frame, episode: Episode, entries: Sequence[Entry]) -> dict[str, list[Label]]:
    """Return the labels of the answers by the arms' keys. Runs with the same end have one.

    The labels of arms that are shown at first avoid each other. Those of another arm avoid these, and those that name its place.
    """
    shown, crowds, found = Labels(frame), dict[Point, Labels](), dict[str, list[Label]]()
    x, z = frame.at(episode.answer)
    for at in ((x, z), (x, z - 30), frame.at((episode.spawn.x, episode.spawn.z))):
        shown.keep(at, 10.0)
    for point in (point for entry in entries for line in entry.lines for point in line.path):
        shown.keep(frame.at(point), 4.0)
    for entry in sorted(entries, key=lambda entry: not entry.is_shown):
        ends: dict[tuple[Point, str], list[Line]] = {}
        for line in entry.lines:
            if line.at is not None:
                ends.setdefault((line.at, line.verdict), []).append(line)
        found[entry.key] = []
        for (at, verdict), lines in ends.items():
            labels = shown if entry.is_shown else crowds.setdefault(frame.at(at), Labels(frame, list(shown.taken)))
            numbers = f", {'run' if lines[0].yaw_deg is None else 'seed'} {' '.join(str(line.number) for line in lines)}"
            words = entry.title + numbers * (len(entry.lines) > 1) + SIGNS.get(verdict, "")
            labels.keep(frame.at(at), 6.5)
            found[entry.key].append(Label(words, labels.place(frame.at(at), 8.0, words), at, verdict))
    return found

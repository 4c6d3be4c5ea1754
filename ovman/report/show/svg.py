"""Draw SVG: elements with classes and tooltips, a frame from metres to the drawing, and labels that keep off each other.

matplotlib writes neither classes nor tooltips; the page's style sheet and its layers need both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

Point = tuple[float, float]


def start_drawing(width: float, height: float, name: str, label: str) -> Element:
    """Return an empty <svg> of class `name`; `label` describes it to screen readers."""
    box = f"0 0 {write_number(width)} {write_number(height)}"
    return Element("svg", {"class": name, "viewBox": box, "role": "img", "aria-label": label})


def add_group(parent: Element, name: str) -> Element:
    """Add a <g> of class `name`."""
    return SubElement(parent, "g", {"class": name})


def make_layer() -> Element:
    """Return a group that is not in a drawing yet."""
    return Element("g")


def to_markup(element: Element) -> str:
    """Return the element as text for an HTML page."""
    return ElementTree.tostring(element, encoding="unicode")


def circle(parent: Element, at: Point, radius: float, name: str, title: str = "", **more: str) -> None:
    """Add a disc. title: its tooltip; more: further attributes."""
    _add(parent, "circle", _place("c", at) | {"r": write_number(radius), "class": name} | more, title)


def square(parent: Element, at: Point, radius: float, name: str, title: str = "", **more: str) -> None:
    """Add a square as large as a circle of that radius."""
    half = radius * math.sqrt(math.pi) / 2
    rectangle(parent, (at[0] - half, at[1] - half), 2 * half, 2 * half, name, title, **more)


def rectangle(parent: Element, corner: Point, width: float, height: float, name: str, title: str = "", **more: str) -> None:
    """Add an upright rectangle by its upper left corner."""
    size = {"width": write_number(width), "height": write_number(height), "class": name}
    _add(parent, "rect", _place("", corner) | size | more, title)


def polyline(parent: Element, points: Iterable[Point], name: str, title: str = "") -> None:
    """Add a line through points."""
    through = " ".join(f"{write_number(u)},{write_number(v)}" for u, v in points)
    _add(parent, "polyline", {"points": through, "class": name}, title)


def cross(parent: Element, at: Point, radius: float, name: str, title: str = "") -> None:
    """Add a diagonal cross."""
    (u, v), r = at, radius
    arms = [(u - r, v - r, u + r, v + r), (u - r, v + r, u + r, v - r)]
    strokes = [tuple(map(write_number, arm)) for arm in arms]
    _add(parent, "path", {"d": "".join(f"M{a} {b}L{c} {d}" for a, b, c, d in strokes), "class": name}, title)


def polygon(parent: Element, corners: Iterable[Point], name: str, title: str = "") -> None:
    """Add a closed shape."""
    through = "L".join(f"{write_number(u)} {write_number(v)}" for u, v in corners)
    _add(parent, "path", {"d": f"M{through}Z", "class": name}, title)


def diamond(parent: Element, at: Point, radius: float, name: str, title: str = "") -> None:
    """Add a square that stands on a corner."""
    (u, v), r = at, radius
    polygon(parent, ((u, v - r), (u + r, v), (u, v + r), (u - r, v)), name, title)


def star(parent: Element, at: Point, radius: float, name: str, title: str = "") -> None:
    """Add a five-pointed star."""
    radii = (radius, 0.42 * radius) * 5
    angles = [math.pi * k / 5 for k in range(len(radii))]
    polygon(parent, [(at[0] + r * math.sin(a), at[1] - r * math.cos(a)) for r, a in zip(radii, angles, strict=True)], name, title)


def arrowhead(parent: Element, at: Point, yaw_deg: float, radius: float, name: str, title: str = "") -> None:
    """Add an arrowhead that points where a yaw looks, seen from above."""
    corners = [(radius * 1.4, 0.0), (radius, 145.0), (radius * 0.35, 180.0), (radius, 215.0)]
    around = [(length, math.radians(yaw_deg + turn)) for length, turn in corners]
    polygon(parent, [(at[0] + length * math.sin(a), at[1] - length * math.cos(a)) for length, a in around], name, title)


def text(parent: Element, at: Point, words: str, name: str, **more: str) -> None:
    """Add words whose anchor is at `at`."""
    SubElement(parent, "text", _place("", at) | {"class": name} | more).text = words


def write_number(value: float) -> str:
    """Write at most one decimal, and no sign on a zero: equal drawings have equal bytes."""
    return f"{round(value, 1) + 0.0:.1f}".removesuffix(".0")


def _place(prefix: str, at: Point) -> dict[str, str]:
    return {f"{prefix}x": write_number(at[0]), f"{prefix}y": write_number(at[1])}


def _add(parent: Element, tag: str, attributes: dict[str, str], title: str) -> None:
    element = SubElement(parent, tag, attributes)
    if title:
        SubElement(element, "title").text = title


@dataclass(frozen=True, slots=True)
class PlanFrame:
    """A drawing of the floor plane from above, x to the right and z up: yaw 0 looks up, 90 to the right.

    It has `width` x `height` units, `scale` units per metre, and its upper left corner is (x_min, z_max).
    """

    x_min: float
    z_max: float
    scale: float
    width: float
    height: float

    @staticmethod
    def around(points: Iterable[Point], width: float, highest: float, margin_m: float) -> PlanFrame:
        """Return the largest frame with the points (x, z), metres, and a margin in its middle, at most `highest` high.

        Raises:
            ValueError: No points are given.
        """
        points = list(points)
        if not points:
            raise ValueError("a frame needs a point to go around")
        (left, right), (low, high) = ((min(axis) - margin_m, max(axis) + margin_m) for axis in zip(*points, strict=True))
        scale = min(width / (right - left), highest / (high - low))
        spare = width / scale - (right - left)
        return PlanFrame(left - spare / 2, high, scale, width, (high - low) * scale)

    def at(self, x: float, z: float) -> Point:
        """Return where a point of the floor plane is drawn: units from the left and from the top."""
        return (x - self.x_min) * self.scale, (self.z_max - z) * self.scale

    def shows(self, x: float, z: float) -> bool:
        """Return whether a point of the floor plane lies within the drawing."""
        u, v = self.at(x, z)
        return 0 <= u <= self.width and 0 <= v <= self.height


CHARACTER_WIDTH = 0.62
"""Width of a bold sans-serif letter, in units of its size."""
_SIDES = ((1, 0), (1, -1), (1, 1), (-1, 0), (-1, -1), (-1, 1), (0, -1), (0, 1))
_FARTHER = (1.0, 1.7, 2.6)


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle by its corners, u to the right and v down."""

    left: float
    top: float
    right: float
    bottom: float

    @staticmethod
    def around(at: Point, half_width: float, half_height: float) -> Box:
        """Return the box around a middle."""
        return Box(at[0] - half_width, at[1] - half_height, at[0] + half_width, at[1] + half_height)

    @property
    def middle(self) -> Point:
        """Return the centre."""
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2

    def overlap(self, other: Box) -> float:
        """Return the area that two boxes share."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return max(wide, 0.0) * max(high, 0.0)


@dataclass
class Labels:
    """Place words next to points, one after the other, each where it overlaps least with what is taken already."""

    width: float
    height: float
    taken: list[Box] = field(default_factory=list)

    def copy(self) -> Labels:
        """Return labels with the same places taken, which go on by themselves."""
        return Labels(self.width, self.height, list(self.taken))

    def keep(self, at: Point, radius: float) -> None:
        """Take a disc, so that no words are placed over it."""
        self.taken.append(Box.around(at, radius, radius))

    def place(self, at: Point, radius: float, words: str, size: float, padding: float = 1.0) -> Box:
        """Take and return the box of words of a letter size next to a disc at `at`."""
        half_width = len(words) * size * CHARACTER_WIDTH / 2 + padding
        half_height = size * 0.6 + padding

        def candidate(side: Point, factor: float) -> Box:
            reach = radius * factor + 1.5
            u = at[0] + side[0] * (reach + half_width)
            v = at[1] + side[1] * (reach + half_height if not side[0] else 0.7 * reach + half_height)
            return Box.around((u, v), half_width, half_height)

        best = min((candidate(side, factor) for factor in _FARTHER for side in _SIDES), key=self._cost)
        self.taken.append(best)
        return best

    def _cost(self, box: Box) -> float:
        outside = max(-box.left, 0) + max(-box.top, 0) + max(box.right - self.width, 0) + max(box.bottom - self.height, 0)
        return sum(box.overlap(other) for other in self.taken) + 100 * outside

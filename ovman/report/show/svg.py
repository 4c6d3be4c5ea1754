"""Elements of an SVG drawing with CSS classes and tooltips. The XML writer of the standard library escapes their text.

matplotlib writes no classes and no tooltips; the page's style sheet and its layers need both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

Point = tuple[float, float]


def drawing(width: float, height: float, name: str, label: str) -> Element:
    """An empty <svg> of class `name`; `label` is read aloud in its place."""
    box = f"0 0 {number(width)} {number(height)}"
    return Element("svg", {"class": name, "viewBox": box, "role": "img", "aria-label": label})


def group(parent: Element, name: str) -> Element:
    """A <g> of class `name`."""
    return SubElement(parent, "g", {"class": name})


def layer() -> Element:
    """A group that is not in a drawing yet."""
    return Element("g")


def circle(parent: Element, at: Point, radius: float, name: str, title: str = "", **more: str) -> Element:
    """A disc; title: its tooltip; more: further attributes."""
    return _titled(SubElement(parent, "circle", _at("c", at) | {"r": number(radius), "class": name} | more), title)


def square(parent: Element, at: Point, radius: float, name: str, title: str = "", **more: str) -> Element:
    """A square as large as a circle of that radius."""
    half = radius * math.sqrt(math.pi) / 2
    return rectangle(parent, (at[0] - half, at[1] - half), 2 * half, 2 * half, name, title, **more)


def rectangle(parent: Element, corner: Point, width: float, height: float, name: str, title: str = "", **more: str) -> Element:
    """An upright rectangle by its upper left corner."""
    size = {"width": number(width), "height": number(height), "class": name}
    return _titled(SubElement(parent, "rect", _at("", corner) | size | more), title)


def polyline(parent: Element, points: Sequence[Point], name: str, title: str = "", **more: str) -> Element:
    """A line through points."""
    through = " ".join(f"{number(u)},{number(v)}" for u, v in points)
    return _titled(SubElement(parent, "polyline", {"points": through, "class": name} | more), title)


def path(parent: Element, d: str, name: str, title: str = "", **more: str) -> Element:
    """A path; d: as SVG has it."""
    return _titled(SubElement(parent, "path", {"d": d, "class": name} | more), title)


def cross(parent: Element, at: Point, radius: float, name: str, title: str = "") -> Element:
    """A diagonal cross."""
    (u, v), r = at, radius
    arms = [(u - r, v - r, u + r, v + r), (u - r, v + r, u + r, v - r)]
    return path(parent, "".join(f"M{number(a)} {number(b)}L{number(c)} {number(d)}" for a, b, c, d in arms), name, title)


def star(parent: Element, at: Point, radius: float, name: str, title: str = "") -> Element:
    """A five-pointed star."""
    points = [
        (at[0] + r * math.sin(math.pi * k / 5), at[1] - r * math.cos(math.pi * k / 5))
        for k, r in enumerate((radius, 0.42 * radius) * 5)
    ]
    return path(parent, "M" + "L".join(f"{number(u)} {number(v)}" for u, v in points) + "Z", name, title)


def arrowhead(parent: Element, at: Point, yaw_deg: float, radius: float, name: str, title: str = "") -> Element:
    """An arrowhead that points where a yaw looks in a drawing seen from above."""
    corners = [(radius * 1.4, 0.0), (radius, 145.0), (radius * 0.35, 180.0), (radius, 215.0)]
    around = [(length, math.radians(yaw_deg + turn)) for length, turn in corners]
    points = [(at[0] + length * math.sin(angle), at[1] - length * math.cos(angle)) for length, angle in around]
    return path(parent, "M" + "L".join(f"{number(u)} {number(v)}" for u, v in points) + "Z", name, title)


def text(parent: Element, at: Point, words: str, name: str, **more: str) -> Element:
    """Words whose anchor is at `at`."""
    element = SubElement(parent, "text", _at("", at) | {"class": name} | more)
    element.text = words
    return element


def markup(element: Element) -> str:
    """The element as text for an HTML page."""
    return ElementTree.tostring(element, encoding="unicode")


def number(value: float) -> str:
    """One decimal at most, no sign on a zero: equal drawings have equal bytes."""
    return f"{round(value, 1) + 0.0:.1f}".removesuffix(".0")


def _at(prefix: str, at: Point) -> dict[str, str]:
    return {f"{prefix}x": number(at[0]), f"{prefix}y": number(at[1])}


def _titled(element: Element, title: str) -> Element:
    if title:
        SubElement(element, "title").text = title
    return element

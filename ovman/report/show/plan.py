"""The maps of a page: the arms' map of each visit, and their association of both; the truth is a separate layer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree.ElementTree import Element

from ovman.agents.interface import VISITS
from ovman.models.prediction import Answer, UniformBox, UniformPick
from ovman.report.show import svg
from ovman.report.show.frame import PlanFrame
from ovman.report.show.labels import Labels
from ovman.report.show.reasoning import Item, Reasoning
from ovman.report.show.room import (
    Room,
    draw_change,
    draw_instances,
    draw_paths,
    draw_pin,
    draw_room,
    draw_surroundings,
    draw_waypoints,
    frame_of,
)
from ovman.report.show.verdicts import FOUND, MISSED, EmbodiedRow, StaticRow

VISIT_SIZE = (600.0, 560.0)
OVERLAY_SIZE = (780.0, 660.0)
PALE, DEEP = (214, 229, 243), (8, 69, 130)
"""Colours of the least and of the most similar object of a page."""
SIGNS = {FOUND: " ✓", MISSED: " ✗"}


def visit_plan(room: Room, reasonings: Sequence[Reasoning], visit: int) -> str:
    """The map of one visit (0 or 1) as SVG: all objects of each arm's map, those that it grounded in bold, the truth on top."""
    frame = frame_of(room, reasonings, *VISIT_SIZE)
    name = VISITS[visit]
    drawing = svg.drawing(frame.width, frame.height, "plan", f"map of the {name} visit, seen from above")
    draw_room(drawing, frame, room, visit)
    kept = Labels(frame.width, frame.height)
    draw_waypoints(drawing, frame, room, visit, kept)
    # Labels of the truth are placed first; the truth is drawn last.
    truth = svg.layer()
    draw_instances(truth, frame, room, visit, kept)
    for k, reasoning in enumerate(reasonings):
        labels = Labels(frame.width, frame.height, list(kept.taken))
        group = svg.group(drawing, f"evidence evidence-{k}")
        colours = Colours(reasoning)
        shown = [item for item in reasoning.items[visit] if frame.shows(*item.at)]
        for item in sorted(shown, key=lambda i: (i.grounded, i.id)):
            _item(group, frame, item, visit, colours, labels)
        for item in (item for item in shown if item.grounded):
            _track(group, frame, item)
            _name(group, frame, item, labels, str(item.id), 13.0)
    drawing.append(truth)
    return svg.markup(drawing)


def beyond(room: Room, reasoning: Reasoning, visit: int) -> int:
    """Number of objects of a map beyond the edge of its drawing."""
    frame = frame_of(room, [reasoning], *VISIT_SIZE)
    return sum(not frame.shows(*item.at) for item in reasoning.items[visit])


def overlay_plan(
    room: Room,
    reasonings: Sequence[Reasoning],
    static: Sequence[StaticRow],
    embodied: Sequence[EmbodiedRow],
    radius_m: float,
) -> str:
    """Both visits over each other as SVG: grounded objects and their pairs, predictions and stops, the answer."""
    frame = frame_of(room, reasonings, *OVERLAY_SIZE)
    drawing = svg.drawing(frame.width, frame.height, "plan overlay", "both visits, the pairs, the answer and the predictions")
    draw_room(drawing, frame, room, 1)
    truth = svg.group(drawing, "truth")
    draw_change(truth, frame, room)
    draw_paths(truth, frame, room)
    draw_surroundings(drawing, frame, room, radius_m)
    kept = Labels(frame.width, frame.height)
    for at in sorted({item.at for reasoning in reasonings for visit in (0, 1) for item in reasoning.grounded(visit)}):
        kept.keep(frame.at(*at), 5.0)
    kept.keep(frame.at(room.episode.spawn.x, room.episode.spawn.z), 8.0)
    # Labels above the evidence are placed first.
    above = svg.layer()
    draw_pin(above, frame, room, kept)
    _predictions(svg.group(above, "predictions"), frame, static, kept)
    _stops(svg.group(above, "stops"), frame, embodied, kept)
    _boxes(drawing, frame, static)
    for k, reasoning in enumerate(reasonings):
        labels = Labels(frame.width, frame.height, list(kept.taken))
        _association(svg.group(drawing, f"evidence evidence-{k}"), frame, reasoning, labels)
    drawing.append(above)
    return svg.markup(drawing)


class Colours:
    """From the similarities of both visits' objects to colours between PALE and DEEP."""

    def __init__(self, reasoning: Reasoning) -> None:
        known = [item.similarity for items in reasoning.items for item in items if item.similarity is not None]
        self.least, self.most = (min(known), max(known)) if known else (0.0, 0.0)

    def of(self, item: Item) -> str:
        """A colour; the deepest for an object without a similarity."""
        if item.similarity is None or self.most <= self.least:
            return _hex(1.0)
        return _hex((item.similarity - self.least) / (self.most - self.least))


def _hex(share: float) -> str:
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in zip(PALE, DEEP, strict=True))


def radius(item: Item) -> float:
    """Radius of an object's mark, which grows with the number of detections."""
    return min(4.0 + 1.6 * math.sqrt(item.sightings), 12.0)


def _mark(parent: Element, frame: PlanFrame, item: Item, visit: int, name: str, fill: str) -> None:
    # Squares are of the first visit, circles of the second.
    draw = (svg.square, svg.circle)[visit]
    draw(parent, frame.at(*item.at), radius(item), f"object {name}", _title(item, visit), fill=fill)


def _title(item: Item, visit: int) -> str:
    score = "" if item.similarity is None else f", similarity {item.similarity:.3f}"
    times = f"{item.sightings} detection{'s' if item.sightings != 1 else ''}"
    views = ", ".join(str(view) for view in item.views)
    return f"{('first', 'second')[visit]} visit, object {item.id}: {times}{score}, seen in views {views}"


def _item(parent: Element, frame: PlanFrame, item: Item, visit: int, colours: Colours, labels: Labels) -> None:
    _mark(parent, frame, item, visit, "grounded" if item.grounded else "other", colours.of(item))
    if item.grounded:
        labels.keep(frame.at(*item.at), radius(item))


def _track(parent: Element, frame: PlanFrame, item: Item) -> None:
    if len(item.track) > 1:
        svg.polyline(parent, [frame.at(*point) for point in item.track], "track", f"track of object {item.id}")


def _name(parent: Element, frame: PlanFrame, item: Item, labels: Labels, words: str, size: float) -> None:
    box = labels.place(frame.at(*item.at), radius(item), words, size)
    svg.text(parent, box.middle, words, "object-id", dy="0.35em")


def _association(parent: Element, frame: PlanFrame, reasoning: Reasoning, labels: Labels) -> None:
    colours = Colours(reasoning)
    by_id = [{item.id: item for item in reasoning.grounded(visit)} for visit in (0, 1)]
    for pair in reasoning.pairs:
        one, other = by_id[0][pair.first], by_id[1][pair.second]
        title = f"objects {pair.first} and {pair.second} were matched: cost {pair.cost_m:.2f} m, {pair.distance_m:.2f} m apart"
        svg.polyline(parent, [frame.at(*one.at), frame.at(*other.at)], "pair", title)
    for visit in (0, 1):
        alone = {item.id for item in reasoning.unmatched(visit)}
        for item in reasoning.grounded(visit):
            if not frame.shows(*item.at):
                continue
            if item.id in alone:
                svg.circle(parent, frame.at(*item.at), radius(item) + 4.0, "alone", "unmatched")
            _mark(parent, frame, item, visit, "grounded", colours.of(item))
            labels.keep(frame.at(*item.at), radius(item))
    paired = {pair.second: pair.first for pair in reasoning.pairs}
    for item in reasoning.grounded(1):
        if frame.shows(*item.at):
            words = f"{paired[item.id]}–{item.id}" if item.id in paired else str(item.id)
            _name(parent, frame, item, labels, words, 12.0)
    for item in reasoning.unmatched(0):
        if frame.shows(*item.at):
            _name(parent, frame, item, labels, str(item.id), 12.0)


def _boxes(parent: Element, frame: PlanFrame, static: Sequence[StaticRow]) -> None:
    group = svg.group(parent, "boxes")
    letters: dict[UniformBox, list[str]] = {}
    for row in static:
        if isinstance(row.outcome, UniformBox):
            letters.setdefault(row.outcome, []).append(row.letter)
    for box, names in letters.items():
        u, v = frame.at(box.x_min, box.z_max)
        size = (box.x_max - box.x_min) * frame.scale, (box.z_max - box.z_min) * frame.scale
        svg.rectangle(group, (u, v), *size, "box", f"{', '.join(names)}: anywhere in this box")
        svg.text(group, (u + 5.0, v + 14.0), " ".join(names), "box-label")


def _predictions(parent: Element, frame: PlanFrame, static: Sequence[StaticRow], labels: Labels) -> None:
    """Predicted points with the letters of the arms that predict them; the candidates of stochastic picks as small diamonds."""
    points: dict[tuple[float, float], list[tuple[Answer, StaticRow]]] = {}
    for row in static:
        if isinstance(row.outcome, UniformPick):
            for x, z in row.outcome.candidates:
                at = frame.at(x, z)
                svg.path(parent, _diamond(at, 4.0), "candidate", f"{row.letter}: one of its candidates")
        elif isinstance(row.outcome, Answer):
            points.setdefault((round(row.outcome.x, 2), round(row.outcome.z, 2)), []).append((row.outcome, row))
    for answers in points.values():
        rows = [row for _, row in answers]
        at = frame.at(answers[0][0].x, answers[0][0].z)
        name = rows[0].verdict
        words = " ".join(row.letter for row in rows) + SIGNS.get(name, "")
        title = "; ".join(f"{row.letter}: {row.arm.system}, {row.arm.memory}: {row.words}" for row in rows)
        svg.circle(parent, at, 5.0, f"predicted {name}", title)
        labels.keep(at, 5.0)
        _pill(parent, labels, at, 7.0, words, name)


def _stops(parent: Element, frame: PlanFrame, embodied: Sequence[EmbodiedRow], labels: Labels) -> None:
    places: dict[tuple[float, float, str], list[tuple[str, float, str]]] = {}
    for row in embodied:
        for stop in row.stops:
            if stop.at is not None:
                entry = (f"{row.letter}{stop.seed}", stop.yaw_deg, stop.words)
                places.setdefault((*stop.at, stop.verdict), []).append(entry)
    for (x, z, verdict), stops in places.items():
        at = frame.at(x, z)
        title = "; ".join(f"{name}: {words}" for name, _, words in stops)
        for yaw in sorted({yaw for _, yaw, _ in stops}):
            svg.arrowhead(parent, at, yaw, 6.5, f"stop {verdict}", title)
        labels.keep(at, 6.5)
        _pill(parent, labels, at, 8.0, " ".join(name for name, *_ in stops) + SIGNS.get(verdict, ""), f"{verdict} of-stop")


def _pill(parent: Element, labels: Labels, at: tuple[float, float], radius: float, words: str, name: str) -> None:
    box = labels.place(at, radius, words, 12.0, padding=4.0)
    svg.polyline(parent, [at, box.middle], "leader")
    size = box.right - box.left, box.bottom - box.top
    svg.rectangle(parent, (box.left, box.top), *size, f"pill {name}", rx="4")
    svg.text(parent, box.middle, words, f"pill-text {name}", dy="0.35em")


def _diamond(at: tuple[float, float], r: float) -> str:
    u, v = at
    corners = ((u, v - r), (u + r, v), (u, v + r), (u - r, v))
    return "M" + "L".join(f"{svg.number(a)} {svg.number(b)}" for a, b in corners) + "Z"

"""The maps of a page: the arms' map of each visit, and their association of both; the truth is a separate layer."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from xml.etree.ElementTree import Element

from ovman.agents.interface import VISITS
from ovman.records.geometry import Point
from ovman.records.prediction import Answer, UniformBox, UniformPick
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
from ovman.report.show.verdicts import FOUND, MISSED, Drive, EmbodiedRow, StaticRow, Stop, stop_of

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
    drives: Mapping[str, Sequence[Drive]],
    shown: Mapping[str, str],
    radius_m: float,
) -> str:
    """Draw both visits over each other as SVG: grounded objects and their pairs, the answer, and each arm in a group of its own.

    drives: the user's own runs by agent, on top. shown: titles of the arms that are visible at first, by name.
    """
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
    pin, own, arms = svg.layer(), svg.layer(), svg.layer()
    draw_pin(pin, frame, room, kept)
    _own_drives(own, frame, drives, room.episode.relation.past, kept)
    _arms(arms, frame, static, embodied, shown, kept)
    for k, reasoning in enumerate(reasonings):
        labels = Labels(frame.width, frame.height, list(kept.taken))
        _association(svg.group(drawing, f"evidence evidence-{k}"), frame, reasoning, labels)
    drawing.extend([pin, arms, own])
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


def _arms(
    parent: Element,
    frame: PlanFrame,
    static: Sequence[StaticRow],
    embodied: Sequence[EmbodiedRow],
    shown: Mapping[str, str],
    labels: Labels,
) -> None:
    """Draw every arm in a group of its own, those of `shown` on top and by their titles.

    The labels of shown arms avoid each other; those of another arm avoid these, and each other where they name one place.
    """
    crowds: dict[tuple[float, ...], Labels] = {}

    def labels_at(name: str, at: Point) -> Labels:
        if name in shown:
            return labels
        return crowds.setdefault(tuple(round(v) for v in at), Labels(labels.width, labels.height, list(labels.taken)))

    groups = {name: svg.layer() for name in (*(row.arm.name for row in static), *(one.arm.name for one in embodied))}
    for name in sorted(groups, key=lambda name: name not in shown):
        groups[name].set("class", f"of-arm arm-{name}")
        for row in static:
            if row.arm.name == name:
                _prediction(groups[name], frame, row, shown.get(name, row.letter), labels_at)
        for one in embodied:
            if one.arm.name == name:
                _stops(groups[name], frame, one.arm.system, one.stops, partial(_seeds, one, shown), partial(labels_at, name))
    for name in sorted(groups, key=lambda name: name in shown):
        parent.append(groups[name])


LabelsAt = Callable[[str, Point], Labels]


def _seeds(row: EmbodiedRow, shown: Mapping[str, str], seeds: str) -> str:
    """Return the label of a stop: the title of an arm that is shown at first and its seeds, else a letter for each."""
    title = shown.get(row.arm.name)
    return " ".join(f"{row.letter}{seed}" for seed in seeds.split()) if title is None else f"{title}, seed {seeds}"


def _prediction(parent: Element, frame: PlanFrame, row: StaticRow, words: str, labels_at: LabelsAt) -> None:
    """Draw the predicted point, the candidates of a stochastic pick as small diamonds, or its box."""
    match row.outcome:
        case UniformBox(x_min, z_min, x_max, z_max):
            u, v = frame.at(x_min, z_max)
            size = (x_max - x_min) * frame.scale, (z_max - z_min) * frame.scale
            svg.rectangle(parent, (u, v), *size, "box", f"{row.letter}: anywhere in this box")
            svg.text(parent, (u + 5.0, v + 14.0), row.letter, "box-label")
        case UniformPick(candidates):
            for x, z in candidates:
                svg.path(parent, _diamond(frame.at(x, z), 4.0), "candidate", f"{row.letter}: one of its candidates")
        case Answer(x, z):
            at, labels = frame.at(x, z), labels_at(row.arm.name, frame.at(x, z))
            title = f"{row.letter}: {row.arm.system}, {row.arm.memory}: {row.words}"
            svg.circle(parent, at, 5.0, f"predicted {row.verdict}", title)
            labels.keep(at, 5.0)
            _pill(parent, labels, at, 7.0, words + SIGNS.get(row.verdict, ""), row.verdict)


def _stops(
    parent: Element,
    frame: PlanFrame,
    name: str,
    stops: Sequence[Stop],
    words: Callable[[str], str],
    labels: Callable[[Point], Labels],
) -> None:
    """Draw where the runs of an arm stopped, runs at one place under one label. words: of the label, from its seeds."""
    places: dict[tuple[Point, str], list[Stop]] = {}
    for stop in stops:
        if stop.at is not None:
            places.setdefault((stop.at, stop.verdict), []).append(stop)
    for (place, verdict), there in places.items():
        at, title = frame.at(*place), "; ".join(f"{name}, seed {stop.seed}: {stop.words}" for stop in there)
        for yaw in sorted({stop.yaw_deg for stop in there}):
            svg.arrowhead(parent, at, yaw, 6.5, f"stop {verdict}", title)
        labels(at).keep(at, 6.5)
        said = words(" ".join(str(stop.seed) for stop in there)) + SIGNS.get(verdict, "")
        _pill(parent, labels(at), at, 8.0, said, f"{verdict} of-stop")


def _own_drives(parent: Element, frame: PlanFrame, drives: Mapping[str, Sequence[Drive]], past: bool, labels: Labels) -> None:
    """Draw the paths of the user's own runs and where they stopped, those of an agent in a group of their own."""
    for number, (name, runs) in enumerate(drives.items()):
        group = svg.group(parent, f"of-arm arm-own-{number}")
        stops = [stop_of(drive.run, past) for drive in runs]
        for drive, stop in zip(runs, stops, strict=True):
            points = [frame.at(x, z) for x, z, _ in drive.poses]
            if len(points) > 1:
                svg.polyline(group, points, f"drive {stop.verdict}", f"path of {name}, seed {stop.seed}")
            for at in points:
                labels.keep(at, 4.0)
        _stops(group, frame, name, stops, f"{name}, seed {{}}".format, lambda at: labels)


def _pill(parent: Element, labels: Labels, at: tuple[float, float], radius: float, words: str, name: str) -> None:
    box = labels.place(at, radius, words, 13.0, padding=4.0)
    svg.polyline(parent, [at, box.middle], "leader")
    size = box.right - box.left, box.bottom - box.top
    svg.rectangle(parent, (box.left, box.top), *size, f"pill {name}", rx="4")
    svg.text(parent, box.middle, words, f"pill-text {name}", dy="0.35em")


def _diamond(at: tuple[float, float], r: float) -> str:
    u, v = at
    corners = ((u, v - r), (u + r, v), (u, v + r), (u - r, v))
    return "M" + "L".join(f"{svg.number(a)} {svg.number(b)}" for a, b in corners) + "Z"

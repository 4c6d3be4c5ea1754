"""Draw the plans of a page: each visit with the objects of the arms' maps, and both visits over each other with the answers.

The truth is a layer of its own, which the page can hide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ovman.agents.interface import VISITS
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import Answer, UniformBox, UniformPick
from ovman.records.scene import Scene
from ovman.records.task import WorldState
from ovman.report.show import svg
from ovman.report.show.answers import FOUND, MISSED, Drive, EmbodiedRow, StaticRow, Stop, describe_stop
from ovman.report.show.reasoning import Item, Reasoning
from ovman.report.show.svg import Labels, PlanFrame

VISIT_SIZE = (600.0, 560.0)
OVERLAY_SIZE = (780.0, 660.0)
PALE, DEEP = (214, 229, 243), (8, 69, 130)
"""Colours of the least and of the most similar object of a page."""
SIGNS = {FOUND: " ✓", MISSED: " ✗"}
FURNITURE_M = 0.3
"""Least longer side of drawn furniture."""
FLAT_M = 0.05
"""Height below which an object is left out."""
MARGIN_M = 0.5
"""Margin around what the frame shows."""
FARTHEST_M = 2.0
"""Farthest distance beyond the reachable cells at which an arm's object widens the plan."""
UNDRAWN = frozenset({"Floor", "Window", "Painting", "Curtains", "Blinds", "LightSwitch", "Mirror"})


@dataclass(frozen=True, slots=True)
class Plan:
    """A drawing of an episode in its scene, seen from above. labels: words that are placed, and places that they keep off."""

    scene: Scene
    episode: Episode
    frame: PlanFrame
    labels: Labels
    drawing: Element

    @staticmethod
    def start(
        scene: Scene, episode: Episode, reasonings: Sequence[Reasoning], size: tuple[float, float], name: str, label: str
    ) -> Plan:
        """Start a drawing of a size at most."""
        frame = choose_frame(scene, episode, reasonings, *size)
        drawing = svg.start_drawing(frame.width, frame.height, name, label)
        return Plan(scene, episode, frame, Labels(frame.width, frame.height), drawing)

    def draw_room(self, visit: int) -> None:
        """Draw the floor, the cells that the agent can reach, and the furniture as it stood in a visit."""
        floor = svg.add_group(self.drawing, "room truth")
        here = {instance.id: instance.position for instance in _world(self.episode, visit)}
        others = {change.instance: (change.before, change.after)[visit] for change in self.episode.others}
        for thing in sorted(self.scene.objects, key=lambda thing: thing.category != "Floor"):
            is_floor, is_of_category = thing.category == "Floor", thing.category == self.episode.category
            is_small = max(thing.size.x, thing.size.z) < FURNITURE_M or thing.size.y < FLAT_M
            is_absent = (is_of_category and thing.id not in here) or (thing.id in others and others[thing.id] is None)
            if is_absent or (not is_floor and not is_of_category and (thing.category in UNDRAWN or is_small)):
                continue
            moved = others.get(thing.id) or thing.position
            x, z = here.get(thing.id) or (moved.x, moved.z)
            name = "floor" if is_floor else "thing of-category" if is_of_category else "thing"
            corner = self.frame.at(x - thing.size.x / 2, z + thing.size.z / 2)
            size = thing.size.x * self.frame.scale, thing.size.z * self.frame.scale
            svg.rectangle(floor, corner, *size, name, "" if is_floor else thing.id)
        cells = svg.add_group(self.drawing, "grid")
        for x, z in self.scene.reachable:
            svg.circle(cells, self.frame.at(x, z), 1.1, "cell")

    def draw_waypoints(self, visit: int) -> None:
        """Draw the numbered waypoints of the tour of a visit."""
        group = svg.add_group(self.drawing, "waypoints")
        for number, waypoint in enumerate(self.episode.tours[VISITS[visit]].waypoints, start=1):
            at = self.frame.at(*waypoint)
            svg.circle(group, at, 7.0, "waypoint", f"waypoint {number} of the tour")
            svg.text(group, at, str(number), "waypoint-number", dy="0.35em")
            self.labels.keep(at, 7.0)

    def draw_instances(self, parent: Element, visit: int) -> None:
        """Draw crosses at the true instances of the category, the target and the distractor by name; the paths of movers."""
        group = svg.add_group(parent, "truth instances")
        if visit == 1:
            self.draw_paths(group)
        roles = {self.episode.target: "target", self.episode.distractor: "distractor"}
        for instance in _world(self.episode, visit):
            at, role = self.frame.at(instance.x, instance.z), roles.get(instance.id)
            svg.cross(group, at, 6.0 if role else 4.5, f"instance {role or ''}".strip(), f"{instance.id} (truth)")
            self.labels.keep(at, 6.0)
            if role:
                box = self.labels.place(at, 8.0, role, 12.0)
                svg.text(group, box.middle, role, "truth-label", dy="0.35em")

    def draw_paths(self, parent: Element) -> None:
        """Draw the paths of movers."""
        for change in self.episode.changes:
            if change.path:
                points = [self.frame.at(x, z) for x, z in change.path]
                svg.polyline(parent, points, "mover", "path of the mover during the second tour (truth)")
                for at in points[::4]:
                    svg.circle(parent, at, 1.6, "mover-step")

    def draw_changes(self, parent: Element) -> None:
        """Draw a line from the former to the new place of each displaced instance."""
        for change in self.episode.changes:
            if change.before is not None and change.after is not None:
                ends = [self.frame.at(end.x, end.z) for end in (change.before, change.after)]
                is_scripted = change.category == self.episode.category
                words = "was put elsewhere" if is_scripted else "was put elsewhere; it is of another category"
                name = "change" if is_scripted else "other-change"
                svg.polyline(parent, ends, name, f"{change.instance} {words} (truth)")
                svg.circle(parent, ends[0], 2.2, "change-end")

    def draw_answer(self, radius_m: float) -> None:
        """Draw the radius of success around the answer, the navigable cell nearest to it, and the spawn."""
        group = svg.add_group(self.drawing, "truth answer")
        at = self.frame.at(*self.episode.answer)
        svg.circle(group, at, radius_m * self.frame.scale, "radius", f"within {radius_m:g} m of the answer (truth)")
        u, v = self.frame.at(*self.episode.nearest_navigable)
        svg.rectangle(group, (u - 3.5, v - 3.5), 7.0, 7.0, "navigable", "navigable cell nearest to the answer (truth)")
        spawn = self.episode.spawn
        group = svg.add_group(self.drawing, "spawn-mark")
        svg.arrowhead(group, self.frame.at(spawn.x, spawn.z), spawn.yaw_deg, 9.0, "spawn", "the agent starts here")

    def draw_pin(self, parent: Element) -> None:
        """Draw a star on a stem whose foot is the answer, so that it hides little of the plan."""
        x, z = self.episode.answer
        foot = self.frame.at(x, z)
        top = foot[0], foot[1] - 30.0
        group = svg.add_group(parent, "truth")
        svg.polyline(group, [foot, top], "stem")
        svg.circle(group, foot, 2.6, "foot")
        svg.star(group, top, 11.0, "answer-star", f"the answer ({x:.2f}, {z:.2f}) (truth)")
        self.labels.keep(foot, 3.0)
        self.labels.keep(top, 11.0)


def _world(episode: Episode, visit: int) -> WorldState:
    """Return the instances of the category that are present in the first (0) or second (1) visit."""
    return (episode.world_1, episode.world_2)[visit]


def choose_frame(scene: Scene, episode: Episode, reasonings: Sequence[Reasoning], width: float, highest: float) -> PlanFrame:
    """Return the frame of all plans of a page: the reachable cells, the instances, the answer, paths, and grounded objects."""
    cells = list(scene.reachable)
    (left, right), (low, high) = ((min(axis) - FARTHEST_M, max(axis) + FARTHEST_M) for axis in zip(*cells, strict=True))
    grounded = [item.at for reasoning in reasonings for visit in (0, 1) for item in reasoning.grounded(visit)]
    points = [(x + dx, z + dz) for x, z in cells for dx in (-0.6, 0.6) for dz in (-0.6, 0.6)]
    points += [(x, z) for x, z in grounded if left <= x <= right and low <= z <= high]
    points += [instance.position for visit in (0, 1) for instance in _world(episode, visit)]
    x, z = episode.answer
    points += [(x + dx, z + dz) for dx in (-MARGIN_M, MARGIN_M) for dz in (-MARGIN_M, MARGIN_M)]
    points += [point for change in episode.changes for point in change.path or ()]
    return PlanFrame.around(points, width, highest, MARGIN_M)


def draw_visit(scene: Scene, episode: Episode, reasonings: Sequence[Reasoning], visit: int) -> str:
    """Draw one visit (0 or 1) as SVG: all objects of each arm's map, those that it grounded in bold, the truth on top."""
    label = f"map of the {VISITS[visit]} visit, seen from above"
    plan = Plan.start(scene, episode, reasonings, VISIT_SIZE, "plan", label)
    plan.draw_room(visit)
    plan.draw_waypoints(visit)
    # Labels of the truth are placed first; the truth is drawn last.
    truth = svg.make_layer()
    plan.draw_instances(truth, visit)
    for k, reasoning in enumerate(reasonings):
        objects = _Objects(svg.add_group(plan.drawing, f"evidence evidence-{k}"), plan.frame, plan.labels.copy(), reasoning)
        shown = [item for item in reasoning.items[visit] if plan.frame.shows(*item.at)]
        for item in sorted(shown, key=lambda item: (item.grounded, item.id)):
            objects.mark(item, visit)
        for item in shown:
            if item.grounded:
                objects.draw_track(item)
                objects.name(item, str(item.id), 13.0)
    plan.drawing.append(truth)
    return svg.to_markup(plan.drawing)


def count_beyond(scene: Scene, episode: Episode, reasoning: Reasoning, visit: int) -> int:
    """Count the objects of a map beyond the edge of its drawing."""
    frame = choose_frame(scene, episode, [reasoning], *VISIT_SIZE)
    return sum(not frame.shows(*item.at) for item in reasoning.items[visit])


def draw_overlay(
    scene: Scene,
    episode: Episode,
    reasonings: Sequence[Reasoning],
    static: Sequence[StaticRow],
    embodied: Sequence[EmbodiedRow],
    drives: Mapping[str, Sequence[Drive]],
    shown: Mapping[str, str],
    radius_m: float,
) -> str:
    """Draw both visits over each other as SVG: grounded objects and their pairs, the answer, and each arm in a group of its own.

    Args:
        scene: The scene.
        episode: The episode.
        reasonings: Evidence of arms.
        static: Answers of arms that predict a point.
        embodied: Runs of arms that navigate.
        drives: The user's own runs by agent, on top.
        shown: Titles of the arms that are visible at first, by name.
        radius_m: Of success.
    """
    label = "both visits, the pairs, the answer and the predictions"
    plan = Plan.start(scene, episode, reasonings, OVERLAY_SIZE, "plan overlay", label)
    plan.draw_room(1)
    truth = svg.add_group(plan.drawing, "truth")
    plan.draw_changes(truth)
    plan.draw_paths(truth)
    plan.draw_answer(radius_m)
    for at in sorted({item.at for reasoning in reasonings for visit in (0, 1) for item in reasoning.grounded(visit)}):
        plan.labels.keep(plan.frame.at(*at), 5.0)
    plan.labels.keep(plan.frame.at(episode.spawn.x, episode.spawn.z), 8.0)
    # Labels above the evidence are placed first.
    pin, own, arms = svg.make_layer(), svg.make_layer(), svg.make_layer()
    plan.draw_pin(pin)
    _draw_own_drives(own, plan, drives)
    _draw_arms(arms, plan, static, embodied, shown)
    for k, reasoning in enumerate(reasonings):
        group = svg.add_group(plan.drawing, f"evidence evidence-{k}")
        _Objects(group, plan.frame, plan.labels.copy(), reasoning).draw_association()
    plan.drawing.extend([pin, arms, own])
    return svg.to_markup(plan.drawing)


class _Objects:
    """The objects of an arm's maps: squares in the first visit, circles in the second, coloured by similarity."""

    def __init__(self, parent: Element, frame: PlanFrame, labels: Labels, reasoning: Reasoning) -> None:
        self.parent, self.frame, self.labels, self.reasoning = parent, frame, labels, reasoning
        known = [item.similarity for items in reasoning.items for item in items if item.similarity is not None]
        self.least, self.most = (min(known), max(known)) if known else (0.0, 0.0)

    def mark(self, item: Item, visit: int) -> None:
        """Draw an object; words keep off a grounded one."""
        times = f"{item.sightings} detection{'s' if item.sightings != 1 else ''}"
        score = "" if item.similarity is None else f", similarity {item.similarity:.3f}"
        views = ", ".join(map(str, item.views))
        title = f"{VISITS[visit]} visit, object {item.id}: {times}{score}, seen in views {views}"
        draw, name = (svg.square, svg.circle)[visit], f"object {'grounded' if item.grounded else 'other'}"
        draw(self.parent, self.frame.at(*item.at), _radius(item), name, title, fill=self.colour(item))
        if item.grounded:
            self.labels.keep(self.frame.at(*item.at), _radius(item))

    def colour(self, item: Item) -> str:
        """Return a colour between PALE and DEEP; the deepest for an object without a similarity."""
        share = 1.0
        if item.similarity is not None and self.most > self.least:
            share = (item.similarity - self.least) / (self.most - self.least)
        return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in zip(PALE, DEEP, strict=True))

    def draw_track(self, item: Item) -> None:
        """Draw the track of an object."""
        if len(item.track) > 1:
            points = [self.frame.at(*point) for point in item.track]
            svg.polyline(self.parent, points, "track", f"track of object {item.id}")

    def name(self, item: Item, words: str, size: float) -> None:
        """Write words next to an object."""
        box = self.labels.place(self.frame.at(*item.at), _radius(item), words, size)
        svg.text(self.parent, box.middle, words, "object-id", dy="0.35em")

    def draw_association(self) -> None:
        """Draw the pairs and the grounded objects of both visits, rings around unmatched ones."""
        by_id = [{item.id: item for item in self.reasoning.grounded(visit)} for visit in (0, 1)]
        for pair in self.reasoning.pairs:
            ends = [self.frame.at(*by_id[0][pair.first].at), self.frame.at(*by_id[1][pair.second].at)]
            matched = f"objects {pair.first} and {pair.second} were matched"
            svg.polyline(self.parent, ends, "pair", f"{matched}: cost {pair.cost_m:.2f} m, {pair.distance_m:.2f} m apart")
        shown = [[item for item in self.reasoning.grounded(visit) if self.frame.shows(*item.at)] for visit in (0, 1)]
        alone = [{item.id for item in self.reasoning.unmatched(visit)} for visit in (0, 1)]
        for visit in (0, 1):
            for item in shown[visit]:
                if item.id in alone[visit]:
                    svg.circle(self.parent, self.frame.at(*item.at), _radius(item) + 4.0, "alone", "unmatched")
                self.mark(item, visit)
        paired = {pair.second: pair.first for pair in self.reasoning.pairs}
        for item in shown[1]:
            self.name(item, f"{paired[item.id]}–{item.id}" if item.id in paired else str(item.id), 12.0)
        for item in shown[0]:
            if item.id in alone[0]:
                self.name(item, str(item.id), 12.0)


def _radius(item: Item) -> float:
    """Return the radius of an object's mark, which grows with the number of detections."""
    return min(4.0 + 1.6 * math.sqrt(item.sightings), 12.0)


def _draw_arms(
    parent: Element, plan: Plan, static: Sequence[StaticRow], embodied: Sequence[EmbodiedRow], shown: Mapping[str, str]
) -> None:
    """Draw every arm in a group of its own, those of `shown` on top and by their titles.

    The labels of shown arms avoid each other. Those of another arm avoid these, and each other if they name one place.
    """
    crowds: dict[tuple[float, ...], Labels] = {}

    def labels_of(name: str) -> Callable[[Point], Labels]:
        def labels_at(at: Point) -> Labels:
            if name in shown:
                return plan.labels
            return crowds.setdefault(tuple(round(v) for v in at), plan.labels.copy())

        return labels_at

    groups = {name: svg.make_layer() for name in (*(row.arm.name for row in static), *(row.arm.name for row in embodied))}
    for name in sorted(groups, key=lambda name: name not in shown):
        groups[name].set("class", f"of-arm arm-{name}")
        for row in static:
            if row.arm.name == name:
                _draw_prediction(groups[name], plan.frame, row, shown.get(name, row.letter), labels_of(name))
        for runs in embodied:
            if runs.arm.name == name:
                _draw_stops(groups[name], plan.frame, runs.arm.system, runs.stops, _label_of(runs, shown), labels_of(name))
    for name in sorted(groups, key=lambda name: name in shown):
        parent.append(groups[name])


def _label_of(row: EmbodiedRow, shown: Mapping[str, str]) -> Callable[[list[int]], str]:
    """Return the function that writes seeds at a stop: after the title of a shown arm, else each after the letter."""
    title = shown.get(row.arm.name)

    def write(seeds: list[int]) -> str:
        if title is None:
            return " ".join(f"{row.letter}{seed}" for seed in seeds)
        return f"{title}, seed {' '.join(map(str, seeds))}"

    return write


def _draw_prediction(parent: Element, frame: PlanFrame, row: StaticRow, words: str, labels_at: Callable[[Point], Labels]) -> None:
    """Draw the predicted point, the candidates of a stochastic pick as small diamonds, or its box."""
    match row.outcome:
        case UniformBox(x_min, z_min, x_max, z_max):
            u, v = frame.at(x_min, z_max)
            size = (x_max - x_min) * frame.scale, (z_max - z_min) * frame.scale
            svg.rectangle(parent, (u, v), *size, "box", f"{row.letter}: anywhere in this box")
            svg.text(parent, (u + 5.0, v + 14.0), row.letter, "box-label")
        case UniformPick(candidates):
            for x, z in candidates:
                svg.diamond(parent, frame.at(x, z), 4.0, "candidate", f"{row.letter}: one of its candidates")
        case Answer(x, z):
            at = frame.at(x, z)
            labels = labels_at(at)
            title = f"{row.letter}: {row.arm.system}, {row.arm.memory}: {row.words}"
            svg.circle(parent, at, 5.0, f"predicted {row.verdict}", title)
            labels.keep(at, 5.0)
            _draw_pill(parent, labels, at, 7.0, words + SIGNS.get(row.verdict, ""), row.verdict)


def _draw_stops(
    parent: Element,
    frame: PlanFrame,
    name: str,
    stops: Sequence[Stop],
    write: Callable[[list[int]], str],
    labels_at: Callable[[Point], Labels],
) -> None:
    """Draw where the runs of an arm stopped, runs at one place under one label. write: the label from its seeds."""
    places: dict[tuple[Point, str], list[Stop]] = {}
    for stop in stops:
        if stop.at is not None:
            places.setdefault((stop.at, stop.verdict), []).append(stop)
    for (place, verdict), there in places.items():
        at, title = frame.at(*place), "; ".join(f"{name}, seed {stop.seed}: {stop.words}" for stop in there)
        for yaw in sorted({stop.yaw_deg for stop in there}):
            svg.arrowhead(parent, at, yaw, 6.5, f"stop {verdict}", title)
        labels_at(at).keep(at, 6.5)
        words = write([stop.seed for stop in there]) + SIGNS.get(verdict, "")
        _draw_pill(parent, labels_at(at), at, 8.0, words, f"{verdict} of-stop")


def _draw_own_drives(parent: Element, plan: Plan, drives: Mapping[str, Sequence[Drive]]) -> None:
    """Draw the paths of the user's own runs and where they stopped, those of an agent in a group of their own."""
    for number, (name, runs) in enumerate(drives.items()):
        group = svg.add_group(parent, f"of-arm arm-own-{number}")
        stops = [describe_stop(drive.run, plan.episode.relation.past) for drive in runs]
        for drive, stop in zip(runs, stops, strict=True):
            points = [plan.frame.at(x, z) for x, z, _ in drive.poses]
            if len(points) > 1:
                svg.polyline(group, points, f"drive {stop.verdict}", f"path of {name}, seed {stop.seed}")
            for at in points:
                plan.labels.keep(at, 4.0)

        def write(seeds: list[int], name: str = name) -> str:
            return f"{name}, seed {' '.join(map(str, seeds))}"

        _draw_stops(group, plan.frame, name, stops, write, lambda at: plan.labels)


def _draw_pill(parent: Element, labels: Labels, at: Point, radius: float, words: str, name: str) -> None:
    """Write words in a rounded box, with a line to the place that they name."""
    box = labels.place(at, radius, words, 13.0, padding=4.0)
    svg.polyline(parent, [at, box.middle], "leader")
    size = box.right - box.left, box.bottom - box.top
    svg.rectangle(parent, (box.left, box.top), *size, f"pill {name}", rx="4")
    svg.text(parent, box.middle, words, f"pill-text {name}", dy="0.35em")

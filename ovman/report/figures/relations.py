"""Draw the relations (Fig. 2 of the paper): one episode per column, the first visit above the second, the sentence, the answer.

Each split has two rows. Views are chosen by projecting the answer into the recorded views of both visits, none by hand. A filled
star marks an answer that is an object, which must be visible at the stop; a hollow star marks a place that the object has left.
Rings mark other changes.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS
from ovman.perception import tour_files
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.records.visit import View, Visit, tour_path
from ovman.report.figures.canvas import INK, LEGEND, PAGE_IN, SMALL_PT, open_canvas
from ovman.settings import Settings
from ovman.settings.benchmark import Camera

PIN = "#ffd23f"
OBJECT, PLACE = "the answer: an object, which must be in sight at the stop", "the answer: a place that the object has left"
OTHER = "something else that changes"
MARKS = {OBJECT: ("*", PIN, PIN, 1.6, 0.7), PLACE: ("*", INK, PIN, 1.6, 0.7), OTHER: ("o", "none", "white", 2.2, 1.0)}
"""Marker, colours of its face and edge, and widths of its dark rim and its edge, by what it marks."""
WRAP = 22
"""Characters in a line of a sentence below a panel; a page has six panels in a row."""
STEM_PX = 34
BEST_DISTANCE_M = 2.2
LARGER = 0.1
"""Weight of the logarithm of the target's mask size."""
MARGIN_IN, LEGEND_IN = 0.05, 0.3
"""Heights of the margin above the headings and of the legend."""
THERE_M = 0.15
"""Largest distance of a mover from the answer in the view that shows it."""
IN_FRONT_M = 0.5
"""A place is hidden if something stands at least this far in front of it."""


def _project(point: Sequence[float], view: View, camera: Camera) -> tuple[float, float, float]:
    """Return pixel (u, v) and planar depth in metres of a world point (x, y, z) in a view; NaN pixels out of the frame."""
    at, yaw, pitch = view.camera, math.radians(view.pose.yaw_deg), math.radians(view.pose.horizon_deg)
    offset = np.subtract(point, [at.x, at.y, at.z])
    right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    forward = np.array([math.sin(yaw) * math.cos(pitch), -math.sin(pitch), math.cos(yaw) * math.cos(pitch)])
    up = np.cross(forward, right)
    depth = float(offset @ forward)
    if depth <= 0:
        return math.nan, math.nan, depth
    focal = camera.height_px / 2 / math.tan(math.radians(camera.field_of_view_deg) / 2)
    u = camera.width_px / 2 + focal * float(offset @ right) / depth
    v = camera.height_px / 2 - focal * float(offset @ up) / depth
    return (u, v, depth) if 0 <= u < camera.width_px and 0 <= v < camera.height_px else (math.nan, math.nan, depth)


def _score_view(point: Sequence[float], view: View, camera: Camera) -> float:
    """Score how well a view shows a point: central and at a good distance; -inf if it is out of the frame."""
    u, v, depth = _project(point, view, camera)
    if math.isnan(u) or depth <= 0.3:
        return -math.inf
    off_centre = max(abs(u / camera.width_px - 0.5), abs(v / camera.height_px - 0.5))
    return -off_centre - 0.25 * abs(math.log(depth / BEST_DISTANCE_M))


def _pin_point(episode: Episode, first: Visit, second: Visit) -> tuple[float, float, float]:
    """Return the answer in space, at the height of the object that is or was there."""
    where = (first if episode.relation.past else second).positions[-1][episode.target]
    x, z = episode.answer
    return x, where.y, z


@dataclass(frozen=True, slots=True)
class Shown:
    """An episode in one view of each of its visits.

    visits: the first and the second. directory: of the recorded visits of its scene. views: numbers of the views, equal if both
    visits look from the same poses. score: how well they show the answer, -inf if they do not.
    """

    episode: Episode
    visits: tuple[Visit, Visit]
    directory: Path
    views: tuple[int, int]
    score: float

    @classmethod
    def choose(cls, episode: Episode, directory: Path, settings: Settings) -> Shown:
        """Choose the views that show the answer best; the target is in the one of the visit that the answer belongs to."""
        first, second = (Visit.load(tour_path(directory, episode.visits[v])) for v in VISITS)
        point = _pin_point(episode, first, second)
        showing, other = (first, second) if episode.relation.past else (second, first)
        one, score = _view_of_target(episode, showing, point, settings)
        two = one
        if [view.pose for view in first.views] != [view.pose for view in second.views]:
            two, of_other = _view_of_place(other, point, directory, settings)
            score += of_other
        return cls(episode, (first, second), directory, (one, two) if episode.relation.past else (two, one), score)


def _view_of_target(episode: Episode, showing: Visit, point: Sequence[float], settings: Settings) -> tuple[int, float]:
    """Return the view that shows the target best where the answer is, in the visit that the answer belongs to, and its score."""
    min_mask_px = settings.admissibility.min_mask_px
    scores = [-math.inf] * len(showing.views)
    for i, (view, here) in enumerate(zip(showing.views, showing.positions, strict=True)):
        away = math.dist((here[episode.target].x, here[episode.target].z), episode.answer)
        px = view.seen.get(episode.target, 0)
        if px >= min_mask_px and away <= THERE_M:
            scores[i] = _score_view(point, view, settings.camera) + LARGER * math.log(px / min_mask_px)
    return int(np.argmax(scores)), float(max(scores))


def _view_of_place(visit: Visit, point: Sequence[float], directory: Path, settings: Settings) -> tuple[int, float]:
    """Return the view of a visit that shows a place best, with nothing in front of it, and its score."""
    scores = [_score_view(point, view, settings.camera) for view in visit.views]
    for i in sorted(range(len(scores)), key=lambda i: -scores[i]):
        if scores[i] == -math.inf:
            break
        u, v, away = _project(point, visit.views[i], settings.camera)
        depth = tour_files.picture(tour_path(directory, visit.visit), i, "depth") / tour_files.MILLIMETRES
        if depth[int(v), int(u)] >= away - IN_FRONT_M:
            return i, scores[i]
    return 0, -math.inf


def _draw_mark(axis: Any, u: float, v: float, mark: str) -> Any:
    """Draw a mark at a point and return its two lines, rim first."""
    marker, face, edge, rim, line = MARKS[mark]
    style = {"marker": marker, "linestyle": "", "markerfacecolor": face}
    lines = axis.plot(u, v, markersize=9, markeredgecolor=INK, markeredgewidth=rim, **style)
    return *lines, *axis.plot(u, v, markersize=8 if marker == "*" else 9, markeredgecolor=edge, markeredgewidth=line, **style)


def _draw_pin(axis: Any, u: float, v: float, mark: str) -> None:
    """Draw a star on a stem whose foot is at pixel (u, v), so that it hides little."""
    top = v - STEM_PX
    for colour, width in ((INK, 1.8), (PIN, 0.8)):
        axis.plot([u, u], [v, top], color=colour, linewidth=width, solid_capstyle="round")
    axis.plot(u, v, marker="o", markersize=2.2, markerfacecolor=PIN, markeredgecolor=INK, markeredgewidth=0.5)
    _draw_mark(axis, u, top, mark)


def draw_panel(axis: Any, shown: Shown, which: int, camera: Camera) -> None:
    """Draw the chosen view of the first or second visit (0 or 1), with rings around other changes and a pin on the answer."""
    visit, index = shown.visits[which], shown.views[which]
    rgb = tour_files.picture(tour_path(shown.directory, visit.visit), index, "rgb")[..., ::-1]
    axis.imshow(np.divide(rgb, 255, dtype=np.float32))
    axis.set_xlim(0, camera.width_px - 1)
    axis.set_ylim(camera.height_px - 1, 0)
    view, here, episode = visit.views[index], visit.positions[index], shown.episode
    for instance in [change.instance for change in episode.others if change.instance in view.seen and change.instance in here]:
        at = here[instance]
        u, v, _ = _project((at.x, at.y, at.z), view, camera)
        if not math.isnan(u):
            _draw_mark(axis, u, v, OTHER)
    if which == 1:
        u, v, _ = _project(_pin_point(episode, *shown.visits), view, camera)
        _draw_pin(axis, u, v, PLACE if episode.relation.past else OBJECT)


def _draw_legend(part: Any, others: bool) -> None:
    """Draw the legend. others: whether it has rings."""
    axis = part.add_axes((0, 0, 1, 1))
    axis.set_axis_off()
    # A mark is two lines over each other: the legend draws a tuple as such.
    marks = {mark: _draw_mark(axis, math.nan, math.nan, mark) for mark in MARKS if mark != OTHER or others}
    style = {"loc": "center", "ncols": len(marks), "handletextpad": 0.8, "columnspacing": 2.0}
    axis.legend([*marks.values()], [*marks], **(LEGEND | style))


def _draw(chosen: Mapping[str, Sequence[Shown]], settings: Settings, output: Path) -> None:
    """Draw the chosen episodes of each split, one per column."""
    panel_in = PAGE_IN / len(Relation)
    columns = max((len(row) for row in chosen.values()), default=1)
    with open_canvas(output) as plt:
        heights = [MARGIN_IN, *[panel_in * 2 + 0.6] * len(chosen), LEGEND_IN]
        figure = plt.figure(figsize=(panel_in * columns, sum(heights)), layout="constrained")
        figure.get_layout_engine().set(w_pad=0.02, h_pad=0.06, hspace=0.01, wspace=0.01)
        _, *parts, below = np.ravel(figure.subfigures(len(heights), 1, height_ratios=heights))
        _draw_legend(below, any(shown.episode.others for row in chosen.values() for shown in row))
        for part, (split, row) in zip(parts, chosen.items(), strict=True):
            axes = part.subplots(2, columns, squeeze=False)
            for axis in axes.flat:
                axis.set_xticks([])
                axis.set_yticks([])
                axis.set_frame_on(False)
            for which, called in enumerate(("first visit", "second visit")):
                axes[which, 0].set_ylabel(f"{split}, {called}" if len(chosen) > 1 else called)
            for column, shown in enumerate(row):
                for which in (0, 1):
                    draw_panel(axes[which, column], shown, which, settings.camera)
                axes[0, column].set_title(shown.episode.relation.value.upper(), fontweight="bold")
                sentence = textwrap.wrap(f"“{shown.episode.sentence}”", WRAP)
                axes[1, column].set_xlabel("\n".join(sentence), fontsize=SMALL_PT)


def draw_relations(episode_files: Sequence[Path], visits: Path, settings: Settings, output: Path) -> None:
    """Draw the best shown episode of each relation of each split, each from another scene of the split if possible.

    episode_files: named after their splits. visits: directory of the recorded tours. Settings: camera, admissibility.min_mask_px.
    """
    chosen: dict[str, list[Shown]] = {}
    for file in episode_files:
        shown = [Shown.choose(episode, visits / episode.scene, settings) for episode in Episode.load(file)]
        row, scenes = chosen.setdefault(file.stem, []), set[str]()
        for relation in Relation:
            of_relation = [one for one in shown if one.episode.relation is relation]
            if of_relation:
                row.append(min(of_relation, key=lambda one: (one.episode.scene in scenes, -one.score, one.episode.id)))
                scenes.add(row[-1].episode.scene)
    _draw(chosen, settings, output)

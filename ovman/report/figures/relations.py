"""The picture of the relations (Fig. 2 of the paper): one episode a column, before above, after below, the sentence, the pin.

Views are chosen by projecting the answer into the recorded views of both visits, none by hand. The pin is a filled star where the
answer is an object that must be visible at the stop, a hollow star where it is a place that the object has left.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS
from ovman.models.episode import Episode
from ovman.models.relation import Relation
from ovman.models.settings import Settings
from ovman.models.settings.benchmark import Camera
from ovman.models.visit import View, Visit
from ovman.perception import tour_files
from ovman.report.figures.canvas import INK, PAGE_IN, SMALL_PT, drawing

PIN = "#ffd23f"
WRAP = 22
"""Characters in a line of a sentence below a panel, of which six stand side by side on a page."""
STEM_PX = 34
BEST_DISTANCE_M = 2.2
LARGER = 0.1
"""Weight of the logarithm of the target's mask size."""
THERE_M = 0.15
"""A view shows a mover where the answer is if it is no farther from it than this."""


def project(
    point: Sequence[float], view: View, width_px: int, height_px: int, field_of_view_deg: float
) -> tuple[float, float, float]:
    """Pixel (u, v) and planar depth in metres of a world point (x, y, z) in a view; nan where it lies behind the camera."""
    camera, yaw, pitch = view.camera, math.radians(view.pose.yaw_deg), math.radians(view.pose.horizon_deg)
    offset = np.subtract(point, [camera.x, camera.y, camera.z])
    right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    forward = np.array([math.sin(yaw) * math.cos(pitch), -math.sin(pitch), math.cos(yaw) * math.cos(pitch)])
    up = np.cross(forward, right)
    depth = float(offset @ forward)
    focal = height_px / 2 / math.tan(math.radians(field_of_view_deg) / 2)
    if depth <= 0:
        return math.nan, math.nan, depth
    return width_px / 2 + focal * float(offset @ right) / depth, height_px / 2 - focal * float(offset @ up) / depth, depth


def _score(point: Sequence[float], view: View, camera: Camera) -> float:
    """How well a view shows a point: central and at a good distance; -inf where it is out of the frame."""
    u, v, depth = project(point, view, camera.width_px, camera.height_px, camera.field_of_view_deg)
    if depth <= 0.3 or not (0 <= u < camera.width_px and 0 <= v < camera.height_px):
        return -math.inf
    off_centre = max(abs(u / camera.width_px - 0.5), abs(v / camera.height_px - 0.5))
    return -off_centre - 0.25 * abs(math.log(depth / BEST_DISTANCE_M))


def _pin_point(episode: Episode, first: Visit, second: Visit) -> tuple[float, float, float]:
    """The answer in space: on the floor plane where the record says, at the height of the object that is or was there."""
    where = (first if episode.relation.past else second).positions[-1][episode.target]
    x, z = episode.answer
    return x, where.y, z


def best_view(episode: Episode, first: Visit, second: Visit, constants: Settings) -> tuple[int, float]:
    """The view of the tour that shows the answer best, and its score; the target is in it in the visit in which it is there."""
    point = _pin_point(episode, first, second)
    showing = first if episode.relation.past else second
    min_mask_px = constants.admissibility.min_mask_px
    target, answer = episode.target, episode.answer
    scores = [-math.inf] * len(showing.views)
    for i, (view, here) in enumerate(zip(showing.views, showing.positions, strict=True)):
        away = math.dist((here[target].x, here[target].z), answer)
        px = view.seen.get(target, 0)
        if px >= min_mask_px and away <= THERE_M:
            scores[i] = _score(point, view, constants.camera) + LARGER * math.log(px / min_mask_px)
    return int(np.argmax(scores)), float(max(scores))


def _pin(axis: Any, u: float, v: float, hollow: bool) -> None:
    """A star on a stem whose foot is at pixel (u, v), so that it hides little of what it marks."""
    top = v - STEM_PX
    for colour, width in ((INK, 1.8), (PIN, 0.8)):
        axis.plot([u, u], [v, top], color=colour, linewidth=width, solid_capstyle="round")
    axis.plot(u, v, marker="o", markersize=2.2, markerfacecolor=PIN, markeredgecolor=INK, markeredgewidth=0.5)
    face = INK if hollow else PIN
    axis.plot(u, top, marker="*", markersize=9, markerfacecolor=face, markeredgecolor=INK, markeredgewidth=1.6)
    axis.plot(u, top, marker="*", markersize=8, markerfacecolor=face, markeredgecolor=PIN, markeredgewidth=0.7)


def draw(chosen: Sequence[tuple[Episode, Visit, Visit, Path]], constants: Settings, output: Path) -> None:
    """Write the figure of the chosen (episode, first visit, second visit, directory of the visits) to `output`, and as PDF."""
    camera = constants.camera
    columns = len(chosen)
    panel_in = PAGE_IN / len(Relation)
    with drawing(output) as plt:
        figure, axes = plt.subplots(2, columns, figsize=(panel_in * columns, panel_in * 2 + 0.75), squeeze=False)
        for column, (episode, first, second, visits) in enumerate(chosen):
            relation = episode.relation
            index, _ = best_view(episode, first, second, constants)
            point = _pin_point(episode, first, second)
            for row, visit in enumerate((first, second)):
                axis = axes[row, column]
                rgb = tour_files.picture(visits / visit.visit / f"{index:02d}_rgb.png")[..., ::-1]
                axis.imshow(np.divide(rgb, 255, dtype=np.float32))
                axis.set_xticks([])
                axis.set_yticks([])
                for spine in axis.spines.values():
                    spine.set_visible(False)
                u, v, _ = project(point, visit.views[index], camera.width_px, camera.height_px, camera.field_of_view_deg)
                if row == 1:
                    _pin(axis, u, v, hollow=relation.past)
                if column == 0:
                    axis.set_ylabel("first visit" if row == 0 else "second visit")
            axes[0, column].set_title(relation.value.upper(), fontweight="bold")
            axes[1, column].set_xlabel("\n".join(textwrap.wrap(f"“{episode.sentence}”", WRAP)), fontsize=SMALL_PT)
        figure.tight_layout(pad=0.3, w_pad=0.4, h_pad=0.4)


def run(episodes_file: Path, visits_dir: Path, constants: Settings, output: Path) -> None:
    """Draw the best shown episode of each relation, each from another scene if possible."""
    episodes = Episode.load(episodes_file)
    chosen: list[tuple[Episode, Visit, Visit, Path]] = []
    scenes: set[str] = set()
    for relation in Relation:
        ranked = []
        for episode in (e for e in episodes if e.relation is relation):
            directory = Path(visits_dir) / episode.scene
            first, second = (Visit.load(directory / episode.visits[v]) for v in VISITS)
            _, score = best_view(episode, first, second, constants)
            ranked.append((episode.scene in scenes, -score, episode.id, episode, first, second, directory))
        if ranked:
            *_, episode, first, second, directory = min(ranked, key=lambda r: r[:3])
            scenes.add(episode.scene)
            chosen.append((episode, first, second, directory))
    draw(chosen, constants, Path(output))

"""Draw the paper's Fig. arch: how the reference agent gets from two tours and a sentence to a place. It shows no data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, INK, SMALL_PT, TYPE_PT, open_canvas
from ovman.report.metrics import Metrics
from ovman.settings import Settings

HEIGHT_IN = 4.05
PLAIN, NEW = "#f4f6f8", "#fbe7c4"
"""Fill of a stage, and of the two stages that are highlighted: cross-visit association and the change relations."""
LEFT, RIGHT, ASIDE = 0.60, 1.76, 2.83
"""Middle of the columns of the first visit, the second visit and the query, in inches."""
ACROSS = (LEFT + RIGHT) / 2


@dataclass(frozen=True, slots=True)
class Box:
    """One stage: a title and a line below it. x, y: its middle; lengths are in inches from the lower left of the figure."""

    title: str
    line: str
    x: float
    y: float
    width: float
    height: float = 0.36
    fill: str = PLAIN

    @property
    def top(self) -> float:
        """Return the upper edge."""
        return self.y + self.height / 2

    @property
    def bottom(self) -> float:
        """Return the lower edge."""
        return self.y - self.height / 2

    @property
    def left(self) -> float:
        """Return the left edge."""
        return self.x - self.width / 2

    @property
    def right(self) -> float:
        """Return the right edge."""
        return self.x + self.width / 2


WIDE, NARROW, QUERY = 2.2, 1.04, 0.86
FIRST = Box("tour, visit 1", "RGB-D, poses", LEFT, 3.84, NARROW)
SECOND = Box("tour, visit 2", "after the change", RIGHT, 3.84, NARROW)
PERCEPTION = Box("perception", "masks, median points, CLIP; clustered at ε", ACROSS, 3.31, WIDE)
MAP_1 = Box(r"map $\mathcal{M}_1$", r"$\{(p_i, f_i, T_i)\}$", LEFT, 2.75, 0.92)
MAP_2 = Box(r"map $\mathcal{M}_2$", r"$\{(p_j, f_j, T_j)\}$", RIGHT, 2.75, 0.92)
GROUNDING = Box("grounding", r"$G_v = \{i : s_i \geq \max_j s_j - \delta_g\}$", ACROSS, 2.11, WIDE)
ASSOCIATION = Box("cross-visit association", r"least cost $C_{ij}$ below the gate $\gamma$", ACROSS, 1.59, WIDE, fill=NEW)
RELATIONS = Box("change relations", r"pairs $\mathcal{P}$, unmatched $U_1$ and $U_2$", ACROSS, 1.11, WIDE, fill=NEW)
DECISION = Box("decision", r"the rule of $\rho$: a place $\hat{a}$, or abstain", ACROSS, 0.63, WIDE)
NAVIGATION = Box("navigation", r"A* to $\hat{a}$, stop", ACROSS, 0.2, WIDE, 0.3)
SENTENCE = Box("sentence", "“… the chair\nthat was moved”", ASIDE, 3.80, QUERY, 0.44)
PARSER = Box("parser", r"noun $c$, relation $\rho$", ASIDE, 3.20, QUERY)
BOXES = (
    FIRST, SECOND, PERCEPTION, MAP_1, MAP_2, GROUNDING, ASSOCIATION, RELATIONS, DECISION, NAVIGATION, SENTENCE, PARSER
)  # fmt: skip
RETAINED = (0.06, 2.44, 2.24, 0.60)
"""The dashed box around both maps: left, bottom, width, height in inches."""


def draw_agent(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw the agent. A dashed box says that both maps are retained; stages that a single-state agent lacks are highlighted."""
    with open_canvas(output) as plt:
        figure = plt.figure(figsize=(COLUMN_IN, HEIGHT_IN))
        axis = figure.add_axes((0, 0, 1, 1))
        axis.set_xlim(0, COLUMN_IN)
        axis.set_ylim(0, HEIGHT_IN)
        axis.set_axis_off()
        _dashed(axis)
        for box in BOXES:
            _box(axis, box)
        for x in (LEFT, RIGHT):
            _arrow(axis, (x, FIRST.bottom), (x, PERCEPTION.top))
            _arrow(axis, (x, PERCEPTION.bottom), (x, MAP_1.top))
            _arrow(axis, (x, MAP_1.bottom), (x, GROUNDING.top))
        for x, name in ((LEFT, "$G_1$"), (RIGHT, "$G_2$")):
            _arrow(axis, (x, GROUNDING.bottom), (x, ASSOCIATION.top))
            axis.text(x + 0.05, (GROUNDING.bottom + ASSOCIATION.top) / 2, name, fontsize=SMALL_PT, va="center")
        for upper, lower in ((ASSOCIATION, RELATIONS), (RELATIONS, DECISION), (DECISION, NAVIGATION)):
            _arrow(axis, (ACROSS, upper.bottom), (ACROSS, lower.top))
        _arrow(axis, (ASIDE, SENTENCE.bottom), (ASIDE, PARSER.top))
        axis.plot([ASIDE, ASIDE], [PARSER.bottom, DECISION.y], color=INK, linewidth=0.8)
        for box, words in ((GROUNDING, "noun $c$"), (DECISION, r"relation $\rho$")):
            _arrow(axis, (ASIDE, box.y), (box.right, box.y))
            axis.text(ASIDE + 0.05, box.y + 0.06, words, fontsize=SMALL_PT, va="bottom")


def _box(axis: Any, box: Box) -> None:
    from matplotlib.patches import FancyBboxPatch

    edge = AMBER if box.fill == NEW else DARK
    shape = FancyBboxPatch(
        (box.left, box.bottom), box.width, box.height, boxstyle="round,pad=0,rounding_size=0.05",
        facecolor=box.fill, edgecolor=edge, linewidth=1.2 if box.fill == NEW else 0.8, zorder=2,
    )  # fmt: skip
    axis.add_patch(shape)
    axis.text(box.x, box.top - 0.045, box.title, fontsize=TYPE_PT, fontweight="bold", ha="center", va="top", zorder=3)
    spacing = 1.0 if "\n" in box.line else 1.2
    below = {"fontsize": SMALL_PT, "ha": "center", "va": "bottom", "linespacing": spacing, "zorder": 3}
    axis.text(box.x, box.bottom + 0.045, box.line, **below)


def _arrow(axis: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
    axis.annotate("", end, start, zorder=1, arrowprops=style)


def _dashed(axis: Any) -> None:
    from matplotlib.patches import Rectangle

    left, bottom, width, height = RETAINED
    axis.add_patch(
        Rectangle((left, bottom), width, height, fill=False, edgecolor=INK, linewidth=0.9, linestyle=(0, (3, 2)), zorder=1)
    )
    axis.text(ACROSS, bottom + 0.035, "both retained", fontsize=SMALL_PT, fontstyle="italic", ha="center", va="bottom", color=INK)

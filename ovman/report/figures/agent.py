"""Draw the paper's Fig. arch: how the reference agent gets from two tours and a sentence to a place. It shows no data."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, INK, SMALL_PT, TYPE_PT, open_canvas
from ovman.report.metrics import Metrics
from ovman.settings import Settings

HEIGHT_IN = 4.05
PLAIN, NEW = "#f4f6f8", "#fbe7c4"
"""Fill of a stage, and of the two stages that are highlighted: cross-visit association and the change relations."""
LEFT, RIGHT, ASIDE = 0.60, 1.76, 2.83
"""Middle of the columns of the first visit, the second visit and the query, in inches."""
ACROSS = (LEFT + RIGHT) / 2


class Box(NamedTuple):
    """One stage: a title and a line below it. x, y: its middle; lengths are in inches from the lower left of the figure."""

    title: str
    line: str
    x: float
    y: float
    width: float = 2.2
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


FIRST = Box("tour, visit 1", "RGB-D, poses", LEFT, 3.84, 1.04)
SECOND = Box("tour, visit 2", "after the change", RIGHT, 3.84, 1.04)
PERCEPTION = Box("perception", "masks, median points, CLIP; clustered at ε", ACROSS, 3.31)
MAP_1 = Box(r"map $\mathcal{M}_1$", r"$\{(p_i, f_i, T_i)\}$", LEFT, 2.75, 0.92)
MAP_2 = Box(r"map $\mathcal{M}_2$", r"$\{(p_j, f_j, T_j)\}$", RIGHT, 2.75, 0.92)
GROUNDING = Box("grounding", r"$G_v = \{i : s_i \geq \max_j s_j - \delta_g\}$", ACROSS, 2.11)
ASSOCIATION = Box("cross-visit association", r"least cost $C_{ij}$ below the gate $\gamma$", ACROSS, 1.59, fill=NEW)
RELATIONS = Box("change relations", r"pairs $\mathcal{P}$, unmatched $U_1$ and $U_2$", ACROSS, 1.11, fill=NEW)
DECISION = Box("decision", r"the rule of $\rho$: a place $\hat{a}$, or abstain", ACROSS, 0.63)
NAVIGATION = Box("navigation", r"A* to $\hat{a}$, stop", ACROSS, 0.2, height=0.3)
SENTENCE = Box("sentence", "“… the chair\nthat was moved”", ASIDE, 3.80, 0.86, 0.44)
PARSER = Box("parser", r"noun $c$, relation $\rho$", ASIDE, 3.20, 0.86)
BOXES = (
    FIRST, SECOND, PERCEPTION, MAP_1, MAP_2, GROUNDING, ASSOCIATION, RELATIONS, DECISION, NAVIGATION, SENTENCE, PARSER
)  # fmt: skip
RETAINED = (0.06, 2.44, 2.24, 0.60)
"""The dashed box around both maps: left, bottom, width, height in inches."""


def draw_agent(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw the agent. A dashed box says that both maps are retained; stages that a single-state agent lacks are highlighted."""
    with open_canvas(output) as plt:
        axis = plt.figure(figsize=(COLUMN_IN, HEIGHT_IN)).add_axes((0, 0, 1, 1), xlim=(0, COLUMN_IN), ylim=(0, HEIGHT_IN))
        axis.set_axis_off()
        left, bottom, width, height = RETAINED
        dashes = {"fill": False, "edgecolor": INK, "linewidth": 0.9, "linestyle": (0, (3, 2)), "zorder": 1}
        axis.add_patch(plt.Rectangle((left, bottom), width, height, **dashes))
        below = {"fontsize": SMALL_PT, "fontstyle": "italic", "ha": "center", "va": "bottom", "color": INK}
        axis.text(ACROSS, bottom + 0.035, "both retained", **below)
        for box in BOXES:
            _draw_box(axis, box)
        for x in (LEFT, RIGHT):
            for upper, lower in ((FIRST, PERCEPTION), (PERCEPTION, MAP_1), (MAP_1, GROUNDING)):
                _draw_arrow(axis, (x, upper.bottom), (x, lower.top))
        for x, name in ((LEFT, "$G_1$"), (RIGHT, "$G_2$")):
            _draw_arrow(axis, (x, GROUNDING.bottom), (x, ASSOCIATION.top))
            axis.text(x + 0.05, (GROUNDING.bottom + ASSOCIATION.top) / 2, name, fontsize=SMALL_PT, va="center")
        for upper, lower in ((ASSOCIATION, RELATIONS), (RELATIONS, DECISION), (DECISION, NAVIGATION), (SENTENCE, PARSER)):
            _draw_arrow(axis, (upper.x, upper.bottom), (upper.x, lower.top))
        axis.plot([ASIDE, ASIDE], [PARSER.bottom, DECISION.y], color=INK, linewidth=0.8)
        for box, words in ((GROUNDING, "noun $c$"), (DECISION, r"relation $\rho$")):
            _draw_arrow(axis, (ASIDE, box.y), (box.x + box.width / 2, box.y))
            axis.text(ASIDE + 0.05, box.y + 0.06, words, fontsize=SMALL_PT, va="bottom")


def _draw_box(axis: Any, box: Box) -> None:
    from matplotlib.patches import FancyBboxPatch

    edge, line = (AMBER, 1.2) if box.fill == NEW else (DARK, 0.8)
    style: dict[str, Any] = {
        "boxstyle": "round,pad=0,rounding_size=0.05",
        "facecolor": box.fill,
        "edgecolor": edge,
        "linewidth": line,
    }
    axis.add_patch(FancyBboxPatch((box.x - box.width / 2, box.bottom), box.width, box.height, zorder=2, **style))
    axis.text(box.x, box.top - 0.045, box.title, fontsize=TYPE_PT, fontweight="bold", ha="center", va="top", zorder=3)
    spacing = 1.0 if "\n" in box.line else 1.2
    below = {"fontsize": SMALL_PT, "ha": "center", "va": "bottom", "linespacing": spacing, "zorder": 3}
    axis.text(box.x, box.bottom + 0.045, box.line, **below)


def _draw_arrow(axis: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
    axis.annotate("", end, start, zorder=1, arrowprops=style)

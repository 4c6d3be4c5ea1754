"""Share what all figures have: width in print, type, colours, bars with intervals, and how they are written to files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ovman.report.paper import PAPER

DARK, LIGHT, AMBER, INK, PALE = "#1f5a94", "#a9c9e6", "#dd9a2c", "#24292f", "#d0d7de"
COLUMN_IN, PAGE_IN = 3.3, 7.16
"""Width of a column and of a page of the paper, in inches."""
TYPE_PT, SMALL_PT = 7.0, 6.0
DPI = 300
DIAMOND = {"marker": "D", "markersize": 3, "markerfacecolor": "white", "markeredgewidth": 0.7, "color": INK, "linestyle": ""}
"""How a figure of the paper is marked next to ours."""
LEGEND: dict[str, Any] = {"frameon": False, "handlelength": 1.2, "columnspacing": 1.0, "handletextpad": 0.4, "borderaxespad": 0.0}
ABOVE: dict[str, Any] = LEGEND | {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
"""Legend in the line of the heading, where it hides nothing."""
_STYLE: Any = {
    "font.size": TYPE_PT,
    "axes.titlesize": TYPE_PT,
    "axes.labelsize": TYPE_PT,
    "legend.fontsize": SMALL_PT,
    "xtick.labelsize": SMALL_PT,
    "ytick.labelsize": SMALL_PT,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": PALE,
    "axes.linewidth": 0.6,
    "pdf.fonttype": 42,  # TrueType, which publishers ask for
    "hatch.linewidth": 0.6,
}
# Without the date and the release of the library, equal pictures have equal bytes.
_PLAIN: dict[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}


@contextmanager
def open_canvas(output: Path) -> Iterator[Any]:
    """Give matplotlib.pyplot in the type of print; write what is drawn to `output` (.png) and to a .pdf next to it."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    with plt.rc_context(_STYLE):
        try:
            yield plt
            for form, metadata in _PLAIN.items():
                path = output.with_suffix(f".{form}")
                plt.gcf().savefig(path, dpi=DPI, format=form, facecolor="white", metadata=metadata)
        finally:
            plt.close("all")


def draw_bar(axis: Any, place: float, ends: Sequence[float], width: float, colour: str, label: str | None = None) -> None:
    """Draw a rate as a bar, with its interval if it has one. ends: the rate and the interval's lower and upper end."""
    rate, low, high = ends
    axis.bar(place, rate, width, color=colour, label=label, zorder=2)
    if low < high:
        reach = [[max(0.0, rate - low)], [max(0.0, high - rate)]]
        axis.errorbar(place, rate, reach, color=INK, linewidth=0.6, capsize=1.2, capthick=0.6, zorder=3)


def mark_paper(axis: Any, place: float, key: str, label: str | None = None) -> None:
    """Mark the paper's figure with a diamond if it prints one."""
    if key in PAPER:
        axis.plot(place, PAPER[key].low, label=label, zorder=4, **DIAMOND)


def write_rate(axis: Any, place: float, rate: float, height: float) -> None:
    """Write a rate in digits above `height`."""
    axis.annotate(f"{rate:.3f}", (place, height), (0, 2), textcoords="offset points", ha="center", fontsize=SMALL_PT)


def frame_rates(axis: Any, title: str | None = None) -> None:
    """Set up a vertical axis of rates from 0 to 1 with grid lines."""
    axis.set_ylim(0, 1.09)
    if title:
        axis.set_ylabel(title)
    strip_frame(axis, "y")


def strip_frame(axis: Any, grid: str, pad: float = 2) -> None:
    """Leave of the frame the lower edge, and add grid lines. grid: "x" or "y", the axis of values."""
    axis.grid(axis=grid, color=PALE, linewidth=0.5)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0, pad=pad)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)


def set_heading(axis: Any, letter: str, words: str) -> None:
    """Set a heading "(a) words" above an axis, from its left edge."""
    axis.set_title(f"({letter}) {words}", loc="left")


def draw_missing(words: str, output: Path) -> None:
    """Draw a figure that says what the metrics lack for the chart of this name."""
    with open_canvas(output) as plt:
        plt.figure(figsize=(COLUMN_IN, 1.0)).text(0.5, 0.5, words, ha="center", va="center", fontsize=SMALL_PT)

"""What all figures share: their width in print, their type and colours, bars with intervals, and how they are written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DARK, LIGHT, AMBER, INK, PALE = "#1f5a94", "#a9c9e6", "#dd9a2c", "#24292f", "#d0d7de"
COLUMN_IN, PAGE_IN = 3.3, 7.16
"""Width of a column and of a page of the paper, in inches."""
TYPE_PT, SMALL_PT = 7.0, 6.0
DPI = 300
DIAMOND = {"marker": "D", "markersize": 3, "markerfacecolor": "white", "markeredgewidth": 0.7, "color": INK, "linestyle": ""}
"""How a figure of the paper is marked beside ours."""
LEGEND: dict[str, Any] = {
    "frameon": False,
    "handlelength": 1.2,
    "columnspacing": 1.0,
    "handletextpad": 0.4,
    "borderaxespad": 0.0,
}
ABOVE: dict[str, Any] = LEGEND | {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
"""Where a key stands: in the line of the heading, so that it hides nothing."""
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
# Neither when nor by which release of the library a file was written is part of the picture.
_PLAIN: dict[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}


@contextmanager
def drawing(output: Path) -> Iterator[Any]:
    """matplotlib.pyplot in the type of print; what is drawn within is written as `output` (.png) and beside it as .pdf."""
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


def bar(axis: Any, place: float, ends: tuple[float, float, float], width: float, colour: str, label: str | None = None) -> None:
    """A rate as a bar with its interval, if it has one. ends: the rate, and the interval's lower and upper end."""
    rate, low, high = ends
    axis.bar(place, rate, width, color=colour, label=label, zorder=2)
    if low < high:
        reach = [[max(0.0, rate - low)], [max(0.0, high - rate)]]
        axis.errorbar(place, rate, reach, color=INK, linewidth=0.6, capsize=1.2, capthick=0.6, zorder=3)


def value(axis: Any, place: float, rate: float, height: float) -> None:
    """A rate in figures, above `height`."""
    axis.annotate(f"{rate:.3f}", (place, height), (0, 2), textcoords="offset points", ha="center", fontsize=SMALL_PT)


def framed(axis: Any, title: str | None = None) -> None:
    """An axis of rates from 0 to 1 with lines to read them by; title: of the axis."""
    axis.set_ylim(0, 1.09)
    if title:
        axis.set_ylabel(title)
    axis.grid(axis="y", color=PALE, linewidth=0.5)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0, pad=2)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)


def lettered(axis: Any, letter: str, words: str) -> None:
    """A heading "(a) words" above an axis, from its left edge."""
    axis.set_title(f"({letter}) {words}" if letter else words, loc="left")


def absent(axis: Any, words: str) -> None:
    """Says in the middle of an axis what is not there to be drawn."""
    axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", va="center", fontsize=SMALL_PT)

"""Write the model cards of the networks: data, learning curves and results, all read from files.

`python -m training.cards models results/metrics/perception.csv config.yaml` writes models/README.md, a card and a learning
curve for each network. No choice was made by the results on the benchmark's scenes.
"""

from __future__ import annotations

import hashlib
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.analysis.perception import ALL, CATEGORIES, SIZE
from ovman.analysis.perception import PerceptionScore as Score
from ovman.analysis.rows import read_rows
from ovman.perception.graph import Graph
from ovman.perception.labels import LEAST_IOU
from ovman.report.tables.perception import SYNONYMS_BELOW, bars, by_category
from ovman.report.tables.table import EMPTY, pipe_table
from ovman.settings import Settings
from ovman.settings.config import load
from training import captions, crops, detector, pictures
from training.public import SOURCES

TEMPLATES = Path(__file__).parent / "templates"
CURVES = {"detector": ("detector_first_curve", "detector_curve"), "encoder": ("encoder_curve",)}
"""Files of the learning curves of each network, in the order of its trainings."""
SHOWN = {
    "detector": {"recall": "recall", "precision": "precision"},
    "encoder": {
        f"{kind}.{rate}": f"{kind.replace('_', ' ')}, {title}"
        for kind in ("homes", "floor_plans")
        for rate, title in (
            ("all_nouns", "all nouns"),
            ("top1", "top-1"),
            ("top5", "top-5"),
            ("synonyms_top1", "synonyms"),
            ("unseen_words", "other words"),
        )
    },
}
"""Rates of a curve's lines and their titles."""
LINES = 12
"""Most lines of a curve in its table."""
NO_PARAMETERS = ("running_mean", "running_var", "num_batches_tracked", "attn_mask")
"""Tensors of a file of weights that are not trained."""

Point = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Weights:
    """A file of weights. parameters: number of trained values; kinds: of its tensors, e.g. "F16"."""

    parameters: int
    kinds: tuple[str, ...]
    megabytes: float


def describe_weights(path: Path) -> Weights:
    """Describe a .safetensors file."""
    from safetensors import safe_open

    parameters, kinds = 0, set()
    with safe_open(str(path), framework="np") as file:
        for name in sorted(file.keys()):
            tensor = file.get_slice(name)
            if not name.endswith(NO_PARAMETERS):
                parameters += math.prod(tensor.get_shape())
                kinds.add(tensor.get_dtype())
    return Weights(parameters, tuple(sorted(kinds)), path.stat().st_size / 1e6)


def read_curve(paths: Sequence[Path]) -> list[Point]:
    """Read the lines of consecutive trainings, flat ("true.top1"), with cumulative steps and minutes.

    Raises:
        ValueError: A file has no lines.
    """
    points: list[Point] = []
    for number, path in enumerate(paths, start=1):
        lines = [json.loads(text) for text in path.read_text(encoding="utf-8").splitlines()]
        if not lines:
            raise ValueError(f"{path}: the learning curve is empty; run the training to its first evaluation")
        before = {key: points[-1][key] if points else 0 for key in ("step", "minutes")}
        points += [_flat(line) | {key: line[key] + start for key, start in before.items()} | {"part": number} for line in lines]
    return points


def _flat(line: Mapping[str, Any], beginning: str = "") -> Point:
    flat: Point = {}
    for name, value in line.items():
        flat |= _flat(value, f"{beginning}{name}.") if isinstance(value, Mapping) else {f"{beginning}{name}": value}
    return flat


def curve_table(points: Sequence[Point], shown: Mapping[str, str]) -> str:
    """Tabulate at most LINES points, with the first and the last: step, minutes, losses and rates."""
    count = min(LINES, len(points))
    chosen = [points[round(k * (len(points) - 1) / max(count - 1, 1))] for k in range(count)]
    losses = sorted({name for point in points for name in point if name.split(".")[0] == "loss"})
    losses = [name for name in losses if any(point.get(name) for point in points)]
    rates = [name for name in shown if any(name in point for point in points)]
    header = ["step", "minutes", *(name.removeprefix("loss.").replace("_", " ") for name in losses), *(shown[r] for r in rates)]
    body = [
        [f"{p['step']}", f"{p['minutes']:.1f}", *(_number(p.get(n), 2) for n in losses), *(_number(p.get(n), 3) for n in rates)]
        for p in chosen
    ]
    return pipe_table(header, body, [True] * len(header)).rstrip()


def draw_curve(points: Sequence[Point], shown: Mapping[str, str], output: Path) -> None:
    """Draw the rates over the steps (PNG)."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(6.4, 3.2))
    for name, title in shown.items():
        found = [(point["step"], point[name]) for point in points if name in point]
        if found:
            axis.plot(*zip(*found, strict=True), marker="o", markersize=3, linewidth=1.2, label=title)
    for one, other in zip(points, points[1:], strict=False):
        if one["part"] != other["part"]:
            axis.axvline(one["step"], color="grey", linewidth=0.8, linestyle="--")
    axis.set(xlabel="step", ylabel="on what is held out", ylim=(0, 1))
    axis.grid(alpha=0.3)
    axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(output, dpi=100, format="png", metadata={"Software": None})
    plt.close(figure)


def render_cards(models: Path, perception: Path, config: Settings) -> dict[str, str]:
    """Return the texts of the cards by the names of their files.

    Args:
        models: The folder that `training.models` writes.
        perception: The file "perception.csv".
        config: Settings of the trainings.

    Raises:
        FileNotFoundError: A file is missing.
        ValueError: A file is incomplete.
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["zip"] = lambda one, other: zip(one, other, strict=True)
    facts = json.loads((models / "training.json").read_text(encoding="utf-8"))
    rows = read_rows(perception, Score)
    common = {
        "config": config.perception.detector,
        "facts": facts,
        "set": facts["settings"],
        "benchmark": config.splits["main"].scenes,
        "rows": {group: [row for row in rows if row.group == group] for group in (ALL, CATEGORIES, SIZE)},
        "bars": bars(rows),
        "development": [
            name for name, one in config.splits.items() if one.scenes and {*one.scenes} <= {*facts["floor_plans"]["held_out"]}
        ],
        "pictures": pictures,
        "crops": crops,
        "captions": captions,
        "augmentation": detector.AUGMENTATION,
        "sources": SOURCES,
        "weights": {name: describe_weights(models / f"{name}.safetensors") for name in CURVES},
        "files": sorted(path.name for path in models.iterdir() if path.suffix in (".safetensors", ".onnx", ".json", ".jsonl")),
        "graphs": {name: Graph((models / f"{name}.onnx").read_bytes()).description for name in (*CURVES, "encoder.text")},
        "sha256": lambda name: hashlib.sha256((models / name).read_bytes()).hexdigest(),
        "bytes": lambda name: f"{(models / name).stat().st_size:,}",
        "least_iou": LEAST_IOU,
        "synonyms_below": SYNONYMS_BELOW,
        "worst": min((row for row in rows if row.group == SIZE and row.recall is not None), key=lambda row: row.recall or 0.0),
        "percent": lambda share: f"{100 * share:.3g} %",
        "rate": lambda value: _number(value, 3),
        "bar_table": lambda names: _bar_table(rows, names),
        "size_table": lambda columns: _group_table([row for row in rows if row.group == SIZE], "pixels", columns),
        "category_table": lambda columns: _group_table(by_category(rows), "category", columns),
    }
    texts = {}
    for name, parts in CURVES.items():
        points = read_curve([models / f"{part}.jsonl" for part in parts])
        table = curve_table(points, SHOWN[name])
        ends = [max((p for p in points if p["part"] == n), key=lambda p: p["step"]) for n in range(1, len(parts) + 1)]
        card = environment.get_template(f"{name}.md.j2").render(**common, curve=table, last=points[-1], ends=ends)
        texts[f"{name}.md"] = card.rstrip() + "\n"
    texts["README.md"] = environment.get_template("README.md.j2").render(**common).rstrip() + "\n"
    return texts


def _bar_table(rows: Sequence[Score], names: Mapping[str, str]) -> str:
    """Compare the results on the benchmark's scenes with the bars."""
    found = bars(rows)
    body = [[title, _number(found[n].reached, 3), f"≥ {found[n].least:.3f}", found[n].verdict] for n, title in names.items()]
    return pipe_table(["measure", "measured", "bar", "verdict"], body, [False, True, True, False]).rstrip()


def _group_table(rows: Sequence[Score], title: str, columns: Mapping[str, str]) -> str:
    def cell(row: Score, key: str) -> str:
        value: float | None = getattr(row, key)
        return str(value) if isinstance(value, int) else _number(value, 3)

    body = [[row.value, *(cell(row, key) for key in columns)] for row in rows]
    return pipe_table([title, *columns.values()], body, [False, *[True] * len(columns)]).rstrip() if body else "None."


def _number(value: float | None, decimals: int) -> str:
    return EMPTY if value is None or not math.isfinite(value) else f"{value:.{decimals}f}"


def run(models: Path, perception: Path, config: Path) -> None:
    """Write the cards and the pictures of the curves into the folder `models`."""
    for name, text in render_cards(models, perception, load(config)).items():
        (models / name).write_text(text, encoding="utf-8", newline="\n")
    for name, parts in CURVES.items():
        draw_curve(read_curve([models / f"{part}.jsonl" for part in parts]), SHOWN[name], models / f"{name}_curve.png")


if __name__ == "__main__":
    run(*(Path(argument) for argument in sys.argv[1:]))

"""How the cost of a run grows with its episodes and scenes. `python bench/growth.py [DIRECTORY] [--plot FILE]`.

DIRECTORY is a working directory in which `make tables` has run from nothing; where it has not, this says so and measures nothing.
What a job took stands in benchmarks/, in seconds of the wall clock: Snakemake looks at a job's processor time every half minute
alone. A job of one scene knows no other, so that scenes add up; what a scene costs is set against the tours that were recorded
in it (generation) and its episodes (evaluation). What is left are jobs of all scenes. The run is one with
evaluation.scenes_per_job 1, as a job of several scenes does not say what each took.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.records.episode import Episode
from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, drawing, lettered
from ovman_engine.plan import floorplan

ROOT = Path(__file__).resolve().parents[1]
GENERATION = frozenset({"scenes", "candidates", "trials", "admissible", "certified"})
"""Rules that are done before there are episodes."""


@dataclass(frozen=True)
class Costs:
    """Seconds of one run. generation, evaluation: by scene; pooled: of jobs of all scenes."""

    generation: Counter[str]
    evaluation: Counter[str]
    pooled: float


@dataclass(frozen=True)
class Line:
    """A line by least squares. r2: its coefficient of determination."""

    slope: float
    intercept: float
    r2: float


def costs(benchmarks: Path, scenes: list[str]) -> Costs:
    """What the jobs of a run took, but for those of scenes that are none of `scenes`."""
    every = frozenset(floorplan.names())
    generation, evaluation, pooled = Counter[str](), Counter[str](), 0.0
    if any(benchmarks.glob("rollouts/**/*-*.tsv")):
        raise SystemExit(f"{benchmarks} is of jobs of several scenes each: run with evaluation.scenes_per_job 1, then again")
    for path in sorted(benchmarks.rglob("*.tsv")):
        seconds = sum(float(row["s"]) for row in csv.DictReader(path.open(encoding="utf-8"), delimiter="\t"))
        if path.stem not in every:
            pooled += seconds
        elif path.stem not in scenes:
            continue
        elif path.relative_to(benchmarks).parts[0] in GENERATION:
            generation[path.stem] += seconds
        else:
            evaluation[path.stem] += seconds
    return Costs(generation, evaluation, pooled)


def fit(x: np.ndarray, y: np.ndarray) -> Line:
    """The line through points (N,), (N,)."""
    slope, intercept = np.polyfit(x, y, 1)
    return Line(float(slope), float(intercept), float(1 - (y - slope * x - intercept).var() / y.var()))


def drawn(axis: Any, x: np.ndarray, y: np.ndarray, line: Line, of: str) -> None:
    """A panel: a point a scene, and the line."""
    axis.plot(x, y, "o", color=DARK, markersize=2.5)
    ends = np.array([0.0, x.max()])
    axis.plot(ends, line.slope * ends + line.intercept, color=AMBER, linewidth=0.9)
    axis.set_xlabel(f"{of} of a scene")
    axis.set_xlim(left=0)
    axis.set_ylim(bottom=0)


def main() -> None:
    """Print the lines and the sums; draw them where a file is named."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("directory", type=Path, nargs="?", default=ROOT)
    parser.add_argument("--splits", nargs="+", default=["main", "multi", "everyday"], help="those of the run")
    parser.add_argument("--plot", type=Path, help="a .png, beside which a .pdf is written")
    asked = parser.parse_args()
    results = asked.directory / "results"
    files = [path for split in asked.splits if (path := results / "episodes" / f"{split}.jsonl").is_file()]
    episodes = Counter(episode.scene for path in files for episode in Episode.load(path))
    if not episodes or not (asked.directory / "benchmarks").is_dir():
        print(f"{asked.directory} has no whole run: make tables, then again")
        return
    scenes = sorted(episodes)
    tours = np.array([len(json.loads((results / "visits" / f"{scene}.json").read_text())["visits"]) for scene in scenes], float)
    asked_of = np.array([episodes[scene] for scene in scenes], float)
    took = costs(asked.directory / "benchmarks", scenes)
    generation = np.array([took.generation[scene] for scene in scenes])
    evaluation = np.array([took.evaluation[scene] for scene in scenes])
    total = generation.sum() + evaluation.sum() + took.pooled
    print(f"{len(scenes)} scenes, {tours.sum():.0f} tours, {asked_of.sum():.0f} episodes: {total:.0f} s")
    panels = {"tours": (tours, generation), "episodes": (asked_of, evaluation)}
    lines = {of: fit(x, y) for of, (x, y) in panels.items()}
    for of, (x, y) in panels.items():
        line = lines[of]
        print(f"  {y.sum():6.0f} s by {of}, {x.min():.0f} to {x.max():.0f} a scene: {line.slope:.2f} s each, R2 {line.r2:.3f}")
    print(f"  {took.pooled:6.0f} s in jobs of all scenes, {took.pooled / total:.1%}")
    if asked.plot is not None:
        with drawing(asked.plot) as plt:
            _, axes = plt.subplots(1, 2, figsize=(COLUMN_IN, 1.7), layout="constrained")
            for axis, letter, (of, (x, y)), stage in zip(axes, "ab", panels.items(), ("generation", "evaluation"), strict=True):
                drawn(axis, x, y, lines[of], of)
                lettered(axis, letter, stage)
            axes[0].set_ylabel("seconds")


if __name__ == "__main__":
    main()

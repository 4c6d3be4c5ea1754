"""The stage "charts": the figures that metrics alone are needed for, and the drawing of the agent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.report.figures import agent, budget, controls, coverage, difficulty, memory, sensitivity
from ovman.report.paper_comparison.metrics import Metrics, arms_by_row
from ovman.report.paper_comparison.paper import Paper
from ovman.settings import Settings


def run(metrics_files: Sequence[Path], paper_file: Path, constants: Settings, directory: Path) -> None:
    """Write every figure into a directory as .png and .pdf, under its own name. Byte-stable.

    metrics_files: csv files of results/metrics by their names; a figure says what it lacks. constants: what the stage owns.
    Raises ValueError in one line for files that contradict themselves.
    """
    metrics, paper = Metrics.load(metrics_files, arms_by_row(constants.comparisons, constants.paper)), Paper.read(paper_file)
    agent.draw(directory / "agent.png")
    budget.draw(metrics, paper, constants, directory / "budget.png")
    controls.draw(metrics, constants, directory / "controls.png")
    coverage.draw(metrics, constants, directory / "coverage.png")
    difficulty.draw(metrics, paper, constants, directory / "difficulty.png")
    memory.draw(metrics, paper, directory / "memory.png")
    sensitivity.draw(metrics, paper, directory / "sensitivity.png")

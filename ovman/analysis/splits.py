"""The stage "split_metrics": the arms on a split beside the benchmark's own, one row an (episode, arm, run or seed) and rates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome, embodied_outcomes, outcomes_of, read_cases
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.records.run import Score
from ovman.settings import Settings


def run(episodes_file: Path, prediction_files: Sequence[Path], constants: Settings, outcomes_out: Path, rates_out: Path) -> None:
    """Write the outcomes and the rates of the arms whose predictions these are, in the order of the files.

    constants: success.radius_m, single_visit.samples, benchmark.seed, evaluation.confidence. Raises ValueError in one line unless
    each arm answers every episode exactly once in each of its runs.
    """
    outcomes = outcomes_of(episodes_file, prediction_files, constants)
    frames.write(outcomes_out, StaticOutcome, outcomes)
    frames.write(rates_out, Rate, static_rates(outcomes, constants.evaluation.confidence))


def run_embodied(
    episodes_file: Path, score_files: Sequence[Path], constants: Settings, outcomes_out: Path, rates_out: Path
) -> None:
    """The same of the arms whose judged runs these are.

    constants: evaluation.confidence. Raises ValueError in one line unless each arm ran every episode once under each seed.
    """
    runs = [run for file in score_files for run in Score.read(file)]
    outcomes = embodied_outcomes(read_cases(episodes_file), runs)
    frames.write(outcomes_out, EmbodiedOutcome, outcomes)
    frames.write(rates_out, Rate, embodied_rates(outcomes, constants.evaluation.confidence))

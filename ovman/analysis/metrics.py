"""The stage "metrics": from episodes, predictions and judged runs to one row an (episode, arm, seed) and to rates."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from ovman.agents import prediction
from ovman.agents.arms import ARMS
from ovman.analysis.outcomes import Case, EmbodiedOutcome, StaticOutcome, embodied_outcomes, static_outcomes
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.task.record import records

STATIC_OUTCOMES, EMBODIED_OUTCOMES = "static_outcomes.csv", "embodied_outcomes.csv"
STATIC_RATES, EMBODIED_RATES = "static_rates.csv", "embodied_rates.csv"


def run(
    episodes_file: Path, prediction_files: Sequence[Path], run_files: Sequence[Path], constants: Any, output_dir: Path
) -> None:
    """Writes the four csv files named above into output_dir, which is made if need be. Either list of files may be empty.

    Rows are in the order of the arms' table, then of the seeds, then of the episodes, whatever the order of the files. Numbers
    have six decimals, counts none, what does not apply is empty.

    constants: success.radius_m, single_visit.samples, benchmark.seed, evaluation.confidence.
    Raises ValueError in one line that names the file or the episode and the remedy.
    """
    cases = read_cases(episodes_file)
    predictions = [record for path in prediction_files for record in _predictions(path, cases)]
    runs = [record for path in run_files for _, record in records(path)]
    static = static_outcomes(
        cases,
        predictions,
        radius_m=constants.success.radius_m,
        samples=constants.single_visit.samples,
        seed=constants.benchmark.seed,
    )
    embodied = embodied_outcomes(cases, runs)
    place = {case.id: index for index, case in enumerate(cases)}
    arms = [arm.name for arm in ARMS]

    def order(outcome: StaticOutcome | EmbodiedOutcome) -> tuple[int, int, int]:
        if outcome.arm not in arms:
            raise ValueError(f"{outcome.arm!r} is not an arm; there are {', '.join(arms)}")
        return arms.index(outcome.arm), outcome.seed, place[outcome.episode]

    static, embodied = sorted(static, key=order), sorted(embodied, key=order)
    confidence = constants.evaluation.confidence
    output_dir.mkdir(parents=True, exist_ok=True)
    for name, kind, rows in (
        (STATIC_OUTCOMES, StaticOutcome, static),
        (EMBODIED_OUTCOMES, EmbodiedOutcome, embodied),
        (STATIC_RATES, Rate, static_rates(static, confidence)),
        (EMBODIED_RATES, Rate, embodied_rates(embodied, confidence)),
    ):
        header = [field.name for field in fields(kind)]
        (output_dir / name).write_text(csv_text(header, map(asdict, rows)), encoding="utf-8")


def read_cases(episodes_file: Path) -> list[Case]:
    """The episodes of a file of JSON lines, in its order.

    Raises ValueError that names file and line, or the id that is there twice.
    """
    cases = []
    for place, record in records(episodes_file):
        try:
            cases.append(Case.of(record))
        except (ValueError, TypeError) as error:
            raise ValueError(f"{place}: {error}") from None
    seen: set[str] = set()
    for case in cases:
        if case.id in seen:
            raise ValueError(f"{episodes_file}: {case.id} is there twice; an episode's id is unique")
        seen.add(case.id)
    return cases


def _predictions(path: Path, cases: Sequence[Case]) -> list[prediction.Prediction]:
    answered = prediction.read(path)
    # Without this an arm that broke off before its first answer would leave the tables as silently as one that does not exist.
    if cases and not answered:
        raise ValueError(f"{path}: no predictions for {len(cases)} episodes; make the file again")
    return answered


def csv_text(header: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """RFC 4180 with a line feed at each end of line: six decimals for floats, 1 and 0 for truth values, nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([_cell(row[key]) for key in header])
    return text.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    # Adding zero drops the sign that rounding may leave on a zero.
    return f"{round(value, 6) + 0.0:.6f}" if isinstance(value, float) else str(value)

"""Metrics across splits: controls next to agents, success by coverage, the overview, and arm against arm on every split."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import kendalltau

from ovman.analysis.comparisons import Comparison, significance
from ovman.analysis.outcomes import ALL, Outcome, group_by
from ovman.analysis.rates import Rate, chances
from ovman.analysis.rows import Row, read_rows, write_csv
from ovman.analysis.statistics import draw_resamples, sum_by_scene, wilson_interval
from ovman.settings import Kind, Settings, Source

CONTROLS = (
    "split kind arm control relation n rate low high interval chance chance_of_change spl least greatest "
    "scene_low scene_high design_effect"
)
COVERAGE = "split arm coverage answered least_confidence successes rate low high"
OVERVIEW = "title split kind arm control n rate low high spl scene_low scene_high design_effect"
SPLIT_SIGNIFICANCE = "split kind title arm baseline seed n successes baseline_successes wins losses test p p_scenes"
RANKS = "split other kind systems tau low high confidence"
STEPS = 20
"""Coverages are the multiples of one over this."""


@dataclass(frozen=True, slots=True)
class SplitResults:
    """The rates and outcomes of the arms of one kind on one split."""

    split: str
    kind: Kind
    rates: Sequence[Rate]
    outcomes: Sequence[Outcome]

    @classmethod
    def read(cls, split: str, kind: Kind, directory: Path) -> SplitResults:
        """Read the files that `ovman.analysis.metrics.write_metrics` wrote into a directory."""
        rates = read_rows(directory / f"{kind}_rates.csv", Rate)
        return cls(split, kind, rates, read_rows(directory / f"{kind}_outcomes.csv", Outcome))


def write_across_splits(directories: Mapping[str, Path], settings: Settings, output_dir: Path) -> None:
    """Write controls, coverage, overview, ranks and split_significance, csv. directories: the metrics of each split.

    Settings: arms, comparisons.{controls,overview,pairs,ranks}, evaluation.confidence.
    """
    results = [SplitResults.read(split, kind, path) for split, path in directories.items() for kind in Kind]
    output_dir.mkdir(parents=True, exist_ok=True)
    write_csv(output_dir / "controls.csv", CONTROLS, controls(results, settings))
    write_csv(output_dir / "coverage.csv", COVERAGE, coverage(results, settings))
    write_csv(output_dir / "overview.csv", OVERVIEW, overview(results, settings))
    write_csv(output_dir / "ranks.csv", RANKS, ranks(results, settings))
    write_csv(output_dir / "split_significance.csv", SPLIT_SIGNIFICANCE, split_significance(results, settings))


def controls(results: Sequence[SplitResults], settings: Settings) -> list[Row]:
    """List the rates of the arms of comparisons.controls with the chances 1/n and 1/m of the same episodes."""
    rows: list[Row] = []
    for one in results:
        chance, of_arm = chances(one.outcomes), group_by(one.rates, "arm")
        for name in filter(settings.arms.__contains__, settings.comparisons.controls):
            for rate in of_arm.get(name, ()):
                of_n, of_m = chance[rate.relation]
                more = {"control": settings.arms[name].control, "chance": of_n, "chance_of_change": of_m}
                rows.append(_of_split(one, rate) | more)
    return rows


def coverage(results: Sequence[SplitResults], settings: Settings) -> list[Row]:
    """Compute the success of each agent on the share of the episodes of which it is surest.

    Of static agents that say how sure they are, in their first run; without controls and ablations.
    """
    rows = []
    for one in (one for one in results if one.kind is Kind.STATIC):
        for name, outcomes in group_by(one.outcomes, "arm").items():
            arm = settings.arms.get(name)
            if arm is None or arm.control or arm.ablates is not None or all(each.confidence is None for each in outcomes):
                continue
            first = next(iter(group_by(outcomes, "seed").values()))
            rows += [{"split": one.split, **row} for row in rate_by_coverage(first, settings.evaluation.confidence)]
    return rows


def rate_by_coverage(outcomes: Sequence[Outcome], confidence: float) -> list[Row]:
    """Compute the success of one pass by coverage, ascending. Equally sure answers count in the order of their ids."""
    surest = sorted(outcomes, key=lambda one: (-_sureness(one), one.episode))
    rows = []
    for step in range(1, STEPS + 1):
        chosen = surest[: math.ceil(step / STEPS * len(surest))]
        successes = sum(one.success > 0 for one in chosen)
        low, high = wilson_interval(successes, len(chosen), confidence)
        row = {"arm": chosen[0].arm, "coverage": step / STEPS, "answered": len(chosen), "low": low, "high": high}
        row |= {"least_confidence": _sureness(chosen[-1]), "successes": successes, "rate": successes / len(chosen)}
        rows.append(row)
    return rows


def _sureness(outcome: Outcome) -> float:
    return 0.0 if outcome.confidence is None else outcome.confidence


def overview(results: Sequence[SplitResults], settings: Settings) -> list[Row]:
    """List the rate over all relations of each entry of comparisons.overview, on every split and in every kind."""
    rows: list[Row] = []
    for title, entry in settings.comparisons.overview.items():
        for one in results:
            arm = entry.static if one.kind is Kind.STATIC else entry.embodied
            rows += [
                _of_split(one, rate) | {"title": title, "control": settings.arms[rate.arm].control}
                for rate in one.rates
                if rate.arm == arm and rate.arm in settings.arms and rate.relation == ALL
            ]
    return rows


def split_significance(results: Sequence[SplitResults], settings: Settings) -> list[Row]:
    """Compare the pairs that are tested on every split, over all relations, by split, pair and seed."""
    pairs = [pair for pair in settings.comparisons.pairs.values() if pair.every_split]
    return [_of_split(one, row) for one in results for row in significance(one.outcomes, pairs, one.split) if row.relation == ALL]


def ranks(results: Sequence[SplitResults], settings: Settings) -> list[Row]:
    """Compute Kendall's tau-b between the rates of the systems on the pairs of splits of comparisons.ranks.

    systems: those of both splits, controls, ablations and oracles aside; a pair with fewer than three is left out. low, high: of
    resamples of the scenes of both splits, each with its own stream. None, like tau, where all systems of a split are equal.
    """
    by_split = {(one.split, one.kind): one for one in results}
    rows = []
    for (split, other), kind in product(settings.comparisons.ranks.items(), Kind):
        both = [by_split.get((name, kind)) for name in (split, other)]
        tables = [_draw_rates(one, settings) for one in both if one is not None]
        systems = [arm for arm in tables[0] if arm in tables[-1]] if len(tables) == len(both) else []
        if len(systems) >= 3:
            ours, theirs = (np.column_stack([table[arm] for arm in systems]) for table in tables)
            tau, *drawn = (kendalltau(a, b).statistic for a, b in zip(ours, theirs, strict=True))
            outside, told = (1.0 - settings.evaluation.confidence) / 2.0, [one for one in drawn if not math.isnan(one)]
            low, high = np.quantile(told, [outside, 1.0 - outside]) if told else (None, None)
            row = {"split": split, "other": other, "kind": kind, "systems": len(systems), "tau": tau, "low": low, "high": high}
            rows.append(row | {"confidence": settings.evaluation.confidence})
    return rows


def _draw_rates(results: SplitResults, settings: Settings) -> dict[str, np.ndarray]:
    """Return the rate of each system, then its rates in resamples of the scenes, float64 (1 + RESAMPLES,)."""
    scenes = sorted({one.scene for one in results.outcomes})
    weights = np.vstack([np.ones(len(scenes), np.int64), draw_resamples(len(scenes), results.split)])
    drawn = {}
    for name, outcomes in group_by(results.outcomes, "arm").items():
        arm = settings.arms.get(name)
        if arm is None or arm.control or arm.ablates is not None or Source.HANDED in (arm.grounding, arm.positions, arm.answer):
            continue
        sums, sizes = sum_by_scene([one.success for one in outcomes], [one.scene for one in outcomes])
        drawn[name] = (weights @ sums) / (weights @ sizes)
    return drawn


def _of_split(results: SplitResults, row: Rate | Comparison) -> Row:
    return {"split": results.split, "kind": results.kind, **asdict(row)}

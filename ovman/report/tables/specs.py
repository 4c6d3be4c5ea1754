"""Of which rows and by which function each table is made. `ovman.analysis.registry` lists the metrics themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import pandas as pd

from ovman.analysis.appearance import Appearance
from ovman.analysis.budget import Step
from ovman.analysis.controls import Controlled
from ovman.analysis.coverage import Coverage
from ovman.analysis.difficulty import Difficulty
from ovman.analysis.dualmap_objects import Objects
from ovman.analysis.fragments import Fragments
from ovman.analysis.language import LanguageRate
from ovman.analysis.localisation import Localised
from ovman.analysis.mover import MoverDistance
from ovman.analysis.navigation import Navigation
from ovman.analysis.overview import Overview
from ovman.analysis.own_task import OwnTask
from ovman.analysis.pairings import Pairing
from ovman.analysis.probes import GateRate, ReadAs
from ovman.analysis.rates import Rate
from ovman.analysis.readings import HandedOver
from ovman.analysis.rescued import Rescued
from ovman.analysis.scenes import SceneRate
from ovman.analysis.scores import Score
from ovman.analysis.sensitivity import Margin
from ovman.analysis.shortcuts import Shortcut
from ovman.analysis.significance import Comparison
from ovman.analysis.split_significance import SplitComparison
from ovman.analysis.spread import Pass
from ovman.analysis.taxonomy import TaxonomyCount
from ovman.report.tables.appearance import appearance_table
from ovman.report.tables.backprojection import backprojection_table
from ovman.report.tables.budget import budget_table
from ovman.report.tables.controls import controls_table
from ovman.report.tables.coverage import coverage_table
from ovman.report.tables.difficulty import difficulty_table
from ovman.report.tables.dualmap import dualmap_table
from ovman.report.tables.fragments import fragments_table
from ovman.report.tables.language import language_table
from ovman.report.tables.mover import mover_table
from ovman.report.tables.navigation import navigation_table
from ovman.report.tables.overview import overview_table
from ovman.report.tables.own_task import own_task_table
from ovman.report.tables.perception import perception_table
from ovman.report.tables.probes import gate_sweep_table, read_as_table
from ovman.report.tables.rates import embodied_table, static_table
from ovman.report.tables.readings import readings_table
from ovman.report.tables.rejections import RejectionCount, rejections_table
from ovman.report.tables.rescued import rescued_table
from ovman.report.tables.scenes import scenes_table
from ovman.report.tables.seeds import seeds_table
from ovman.report.tables.sensitivity import sensitivity_table
from ovman.report.tables.shortcuts import shortcuts_table
from ovman.report.tables.significance import pairings_table, significance_table
from ovman.report.tables.split_significance import split_significance_table
from ovman.report.tables.splits import split_embodied_table, split_rejections_table, split_table
from ovman.report.tables.table import Table
from ovman.report.tables.taxonomy import taxonomy_table
from ovman.settings import Kind, Settings


@dataclass(frozen=True, slots=True)
class TableSpec:
    """What a table is made of. rows: the dataclass of its rows of metrics; make: the table of such rows and the settings, with
    its columns and caption; kind: the kind of arms of which it has one row each, for notes on those that were not run."""

    rows: type
    make: Callable[[pd.DataFrame, Settings], Table]
    kind: Kind | None = None


SPECS: Mapping[str, TableSpec] = {
    "static_rates": TableSpec(Rate, static_table, Kind.STATIC),
    "embodied_rates": TableSpec(Rate, embodied_table, Kind.EMBODIED),
    "rejections": TableSpec(RejectionCount, rejections_table),
    "taxonomy": TableSpec(TaxonomyCount, taxonomy_table),
    "significance": TableSpec(Comparison, significance_table),
    "navigation": TableSpec(Navigation, navigation_table),
    "difficulty": TableSpec(Difficulty, difficulty_table),
    "budget": TableSpec(Step, budget_table),
    "readings": TableSpec(HandedOver, readings_table),
    "pairings": TableSpec(Pairing, pairings_table),
    "shortcuts": TableSpec(Shortcut, shortcuts_table),
    "rescued": TableSpec(Rescued, rescued_table),
    "own_task": TableSpec(OwnTask, own_task_table),
    "seeds": TableSpec(Pass, seeds_table),
    "scenes": TableSpec(SceneRate, scenes_table),
    "mover": TableSpec(MoverDistance, mover_table),
    "controls": TableSpec(Controlled, controls_table),
    "overview": TableSpec(Overview, overview_table),
    "split_significance": TableSpec(SplitComparison, split_significance_table),
    "coverage": TableSpec(Coverage, coverage_table),
    "language": TableSpec(LanguageRate, language_table),
    "perception": TableSpec(Score, perception_table),
    "backprojection": TableSpec(Localised, backprojection_table),
    "sensitivity": TableSpec(Margin, sensitivity_table),
    "gate_sweep": TableSpec(GateRate, gate_sweep_table),
    "read_as": TableSpec(ReadAs, read_as_table),
    "fragments": TableSpec(Fragments, fragments_table),
    "appearance": TableSpec(Appearance, appearance_table),
    "dualmap": TableSpec(Objects, dualmap_table),
}
"""By the name of the metrics that it shows."""


def spec_of(metric: str, splits: Iterable[str] = ()) -> TableSpec:
    """Of which rows and by which function the table of a file of metrics is made. splits: those beside the benchmark's own.

    Raises KeyError for metrics that no table shows.
    """
    of_splits = {
        name: spec
        for split in splits
        for name, spec in (
            (f"{split}_rates", TableSpec(Rate, partial(split_table, split), Kind.STATIC)),
            (f"{split}_embodied_rates", TableSpec(Rate, partial(split_embodied_table, split), Kind.EMBODIED)),
            (f"{split}_rejections", TableSpec(RejectionCount, partial(split_rejections_table, split))),
        )
    }
    return {**SPECS, **of_splits}[metric]

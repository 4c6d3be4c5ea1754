"""The list of metrics: what a split adds to it, and what tables, figures and the comparison take from it."""

from __future__ import annotations

import pytest

from ovman.analysis.registry import (
    METRICS,
    compared,
    drawn,
    in_all_tables,
    in_split_tables,
    in_static_tables,
    in_tables,
    of_split,
    table_of,
)
from ovman.settings import Need
from tests.arms import ARMS, CONFIG

OF_SPLIT = [
    ("far_outcomes", "split_metrics", None),
    ("far_rates", "split_metrics", "far"),
    ("far_embodied_outcomes", "split_metrics", None),
    ("far_embodied_rates", "split_metrics", "far_embodied"),
    ("far_rejections", "episodes", "far_rejections"),
]
FIGURES = {"static_rates", "difficulty", "budget", "controls", "coverage", "sensitivity", "gate_sweep"}
"""What the modules of ovman/report/figures read."""


@pytest.mark.parametrize("embodied", [True, False, None])
def test_a_split_has_outcomes_rates_and_rejections_and_those_of_runs_where_it_is_driven(embodied):
    found = of_split("far") if embodied is None else of_split("far", embodied)
    expected = [one for one in OF_SPLIT if embodied in (True, None) or "embodied" not in one[0]]
    assert [(metric.name, metric.stage, metric.table) for metric in found] == expected
    assert not any(metric.static or metric.compared or metric.drawn or metric.need for metric in found)


def test_the_table_of_a_metric_is_found_among_those_of_the_splits_too():
    shown = {name: table for name, _, table in OF_SPLIT if table is not None}
    assert {name: table_of(name, ["near", "far"]) for name in shown} == shown
    assert table_of("static_rates") == "static"
    for name, splits in (("far_rates", []), ("far_outcomes", ["far"])):
        with pytest.raises(ValueError, match=f"no table shows {name}; those that are shown are static_rates, "):
            table_of(name, splits)


def test_figures_and_static_tables_show_what_the_tables_show():
    assert set(drawn(ARMS)) == FIGURES
    static = in_static_tables()
    assert set(static) == {"static_rates", "taxonomy", "difficulty", "budget", "readings", "pairings", "shortcuts"}
    assert {*drawn(ARMS), *static, *compared(ARMS)} <= {*in_tables(ARMS), *in_all_tables(ARMS)}
    assert all(table_of(name) == name.removesuffix("_rates") for name in static)


def test_what_no_arm_needs_is_not_made():
    without = [arm for arm in ARMS if Need.DUALMAP not in arm.needs]
    assert len(without) < len(ARMS)
    for take in (in_tables, compared):
        assert set(take(ARMS)) - set(take(without)) == {"dualmap"}
    shown = {metric.name for metric in METRICS if metric.table is not None}
    assert {*in_tables([]), *in_all_tables([])} == shown - {"dualmap"}


@pytest.mark.parametrize("take", (in_tables, in_all_tables))
def test_the_tables_have_the_splits_that_are_asked_for(take):
    splits = [split for split in CONFIG.splits.values() if split.name != "main"]
    assert {*take(ARMS, splits)} - {*take(ARMS)} == {name for split in splits for name in in_split_tables(ARMS, split)}
    for split in splits:
        assert set(in_split_tables([], split)) == {f"{split.name}_rates", f"{split.name}_rejections"}

"""The table of readings: each arm beside the first one of its map."""

from __future__ import annotations

import pandas as pd
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.readings import OWN, POSITIONS, HandedOver, readings
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables.readings import readings_table
from ovman.settings import Reading
from ovman.settings.arms import other_readings
from tests.analysis.fabricated import static
from tests.arms import ARMS, CONFIG

MAPS = CONFIG.comparisons.readings
OURS = [name for name, title in MAPS.items() if title == next(iter(MAPS.values()))]


@settings(max_examples=20, derandomize=True, deadline=None)
@given(st.lists(st.tuples(*[st.booleans()] * len(OURS)), min_size=1, max_size=20))
def test_gains_and_losses_are_against_the_first_arm_of_the_map(hits):
    outcomes = [static(name, i, row[k]) for k, name in enumerate(OURS) for i, row in enumerate(hits)]
    rows = {(row.arm, row.relation): row for row in readings(outcomes, ARMS, MAPS, 0.95)}
    own = rows[OURS[0], "all"]
    assert (own.gained, own.lost, own.p, own.grounding) == (None, None, None, OWN)
    for name in OURS[1:]:
        row = rows[name, "all"]
        assert row.successes == own.successes + row.gained - row.lost and 0 < row.p <= 1
        parts = [rows[key] for key in rows if key[0] == name and key[1] != "all"]
        assert sum(part.successes for part in parts) == row.successes and sum(part.gained for part in parts) == row.gained
    assert [rows[name, "all"].grounding for name in OURS] == [OWN, *Reading]


def test_a_row_is_beside_the_first_arm_of_its_own_map():
    titles = list(dict.fromkeys(MAPS.values()))
    firsts = [next(name for name, title in MAPS.items() if title == one) for one in titles[:2]]
    second = next(name for name, title in MAPS.items() if title == titles[1] and name != firsts[1])
    hits = {firsts[0]: 0, firsts[1]: 2, second: 3}
    outcomes = [static(name, 6 * i, i < count) for name, count in hits.items() for i in range(4)]
    found = {(row.arm, row.relation): row for row in readings(outcomes, ARMS, MAPS, 0.5)}
    assert [row.gained for row in found.values()].count(None) == 4
    low, high = wilson_interval(3, 4, 0.5)
    grounding = found[second, "all"].grounding
    assert found[second, "all"] == HandedOver(titles[1], grounding, second, "all", 4, 3.0, 0.75, low, high, 1, 0, 1.0)


def test_a_map_whose_first_arm_has_two_runs_has_rates_and_no_test():
    outcomes = [static(OURS[0], i, i % 2, seed=seed) for i in range(6) for seed in (0, 1)]
    outcomes += [static(OURS[1], i, 1) for i in range(6)]
    whole = {row.arm: row for row in readings(outcomes, ARMS, MAPS, 0.95) if row.relation == "all"}
    assert (whole[OURS[1]].gained, whole[OURS[1]].lost, whole[OURS[1]].p) == (None, None, None)


def test_the_settings_have_every_reading_of_every_map_and_the_other_tables_have_one():
    said: dict[str, list[str]] = {}
    for arm in ARMS:
        if arm.name in MAPS and arm.grounding == "handed" and arm.positions == "own":
            said.setdefault(MAPS[arm.name], []).append(arm.reading)
    assert said and all(sorted(found) == sorted(Reading) for found in said.values())
    left = other_readings(ARMS)
    assert {arm.reading for arm in ARMS if arm.name in left} == {Reading.ANY, Reading.NEAREST}
    assert not left & {*CONFIG.comparisons.rungs}


def test_expectations_and_several_runs_have_rates_and_no_test():
    names = [name for name, title in MAPS.items() if title == list(MAPS.values())[-1] or MAPS[name] == MAPS[OURS[0]]]
    outcomes = [static(OURS[0], i, 1) for i in range(6)] + [static(OURS[1], i, i % 2, seed=s) for i in range(6) for s in (0, 1)]
    outcomes += [static(names[-1], i, 0.25, "expected") for i in range(6)]
    rows = readings(outcomes, ARMS, MAPS, 0.95)
    whole = {row.arm: row for row in rows if row.relation == "all"}
    assert whole[OURS[1]].rate == 0.5 and whole[OURS[1]].p is None
    assert whole[names[-1]].grounding == POSITIONS and whole[names[-1]].rate == 0.25
    table = readings_table(pd.DataFrame([{key: getattr(row, key) for key in HandedOver.__slots__} for row in rows]), CONFIG)
    assert [*table.rows["grounding"]] == [OWN, "majority", POSITIONS]

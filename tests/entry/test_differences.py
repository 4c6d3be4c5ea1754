"""Two runs beside each other: what must be equal, what may differ by rounding, and what `ovman verify` says of either."""

from __future__ import annotations

import pytest

from ovman.entry.verification import MISSING, TOLERANCES, compare_runs, flatten, unit_of
from ovman.records.run import Score

STOPPED = Score.from_json(
    {
        "schema": "ovman-run/1",
        "episode": "FloorPlan1/moved/0001",
        "arm": "mine",
        "seed": 0,
        "outcome": "stopped",
        "stop": {"x": -1.5, "z": 4.25, "yaw_deg": 359.98},
        "box_distance_m": 0.6717,
        "answer_distance_m": 1.1122,
        "navigable_distance_m": 0.559,
        "visible_px": {"0": 3446, "30": 3675, "60": 99},
        "path_length_m": 6.25,
        "actions": 4,
        "instances": {"Chair|-00.19|+00.01": {"box_distance_m": 0.2, "visible_px": {"0": 10}}},
        "path_at_m": {"2": 0.5},
        "trace": "LLFS",
        "success": True,
        "spl": 0.9,
    }
)
MEASURED = {
    "stop.x": TOLERANCES["metres"],
    "stop.z": TOLERANCES["metres"],
    "box_distance_m": TOLERANCES["metres"],
    "answer_distance_m": TOLERANCES["metres"],
    "navigable_distance_m": TOLERANCES["metres"],
    "visible_px.0": TOLERANCES["pixels"],
    "visible_px.60": TOLERANCES["pixels"],
    "path_length_m": TOLERANCES["metres"],
    "instances.Chair|-00.19|+00.01.box_distance_m": TOLERANCES["metres"],
    "instances.Chair|-00.19|+00.01.visible_px.0": TOLERANCES["pixels"],
    "path_at_m.2": TOLERANCES["metres"],
    "spl": TOLERANCES["SPL"],
}
DECIDED = {"outcome": "budget", "actions": 5, "trace": "LLFFS", "success": False, "own_success": True}


def changed(key, by):
    """The run with a number more or less."""
    value = STOPPED.to_json()
    *above, last = (
        ["instances", "Chair|-00.19|+00.01", *key.removeprefix("instances.Chair|-00.19|+00.01.").split(".")]
        if key.startswith("instances")
        else key.split(".")
    )
    here = value
    for name in above:
        here = here[name]
    here[last] += by
    return Score.from_json(value)


def test_every_number_of_a_run_is_decided_or_has_a_unit():
    keys = {key for key, value in flatten(STOPPED.to_json()) if isinstance(value, int | float) and not isinstance(value, bool)}
    assert {key for key in keys if unit_of(key) is None} == {"seed", "actions"}
    assert {key for key in keys if unit_of(key)} == {*MEASURED, "stop.yaw_deg", "visible_px.30"}


@pytest.mark.parametrize("key", MEASURED)
@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_measured_may_differ_by_its_tolerance_and_no_more(key, sign):
    differences, deviations = compare_runs(STOPPED, changed(key, sign * MEASURED[key]))
    assert differences == [] and [*deviations.values()] == [pytest.approx(MEASURED[key])]
    differences, deviations = compare_runs(STOPPED, changed(key, sign * (MEASURED[key] + (1 if "visible_px" in key else 0.0002))))
    assert [name for name, _, _ in differences] == [key] and not deviations


@pytest.mark.parametrize("key", DECIDED)
def test_what_is_decided_must_be_equal(key):
    other = STOPPED.model_copy(update={key: DECIDED[key]})
    for pair in ((STOPPED, other), (other, STOPPED)):
        assert [name for name, _, _ in compare_runs(*pair)[0]] == [key]


def test_yaw_goes_round():
    stop = STOPPED.stop.model_copy(update={"yaw_deg": 0.02})
    assert compare_runs(STOPPED, STOPPED.model_copy(update={"stop": stop})) == ([], {"degrees": pytest.approx(0.04)})


def test_nothing_is_no_number():
    gone = STOPPED.model_copy(update={"box_distance_m": None, "path_at_m": None})
    assert compare_runs(STOPPED, gone)[0] == [("box_distance_m", 0.6717, None), ("path_at_m.2", 0.5, MISSING)]

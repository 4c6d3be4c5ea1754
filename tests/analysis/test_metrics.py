from __future__ import annotations

import csv
import json
from dataclasses import dataclass, replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis import metrics
from ovman.analysis.frames import csv_text
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Interval, embodied_rates, poisson_binomial_range, static_rates
from ovman.analysis.registry import of_stage
from ovman.analysis.statistics import poisson_binomial_tail, wilson_interval
from ovman.task import Relation
from tests.arms import BY_NAME, CONFIG
from tests.episodes import episode_record
from tests.task.test_episode import MOVED, moving

CONSTANTS = SimpleNamespace(
    success=SimpleNamespace(radius_m=1.0),
    single_visit=SimpleNamespace(samples=2000),
    benchmark=SimpleNamespace(seed=0),
    candidates=SimpleNamespace(delta_min_m=1.5),
    evaluation=SimpleNamespace(confidence=0.95, near_miss_m=2.0),
    comparisons=CONFIG.comparisons,
)


def static(number: int, relation: Relation, success: float, outcome: str = "answered") -> StaticOutcome:
    return StaticOutcome(f"e{number}", "FloorPlan1", relation, "Chair", 2, 1, "arm", 0, outcome, None, None, success)


def embodied(number: int, seed: int, success: bool, spl: float) -> EmbodiedOutcome:
    return EmbodiedOutcome(
        f"e{number}", "FloorPlan1", Relation.MOVED, "Chair", 2, 1, "arm", seed, "stopped", success, spl, 1.0, 9
    )


@given(st.lists(st.tuples(st.sampled_from(Relation), st.booleans()), min_size=1, max_size=30))
def test_relations_add_up_to_all(results):
    rates = static_rates([static(i, relation, float(success)) for i, (relation, success) in enumerate(results)], 0.95)
    *parts, whole = rates
    assert whole.relation == "all" and whole.n == len(results) == sum(part.n for part in parts)
    assert whole.successes == sum(part.successes for part in parts)
    assert [part.relation for part in parts] == [r.value for r in Relation if any(r is relation for relation, _ in results)]
    assert all(0 <= rate.low <= rate.rate <= rate.high <= 1 and rate.interval is Interval.WILSON for rate in rates)
    assert (whole.low, whole.high) == wilson_interval(int(whole.successes), whole.trials, 0.95)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=25), st.sampled_from((0.5, 0.9, 0.95)))
def test_an_expectation_lies_in_the_range_of_what_is_realised(probabilities, confidence):
    low, high = poisson_binomial_range(probabilities, confidence)
    n = len(probabilities)
    k_low, k_high = round(low * n), round(high * n)
    assert 1 - poisson_binomial_tail(probabilities, k_low) <= (1 - confidence) / 2 + 1e-9
    assert poisson_binomial_tail(probabilities, k_high + 1) <= (1 - confidence) / 2
    assert low - 1 / n <= sum(probabilities) / n <= high + 1 / n
    # Neither end could be nearer.
    assert k_low == n or poisson_binomial_tail(probabilities, k_low + 1) < 1 - (1 - confidence) / 2
    assert k_high == 0 or poisson_binomial_tail(probabilities, k_high) > (1 - confidence) / 2


def test_a_certain_expectation_has_no_spread():
    assert poisson_binomial_range([1.0, 0.0, 1.0, 0.0], 0.95) == (0.5, 0.5)


def test_an_expectation_is_not_given_a_wilson_interval():
    rates = static_rates([static(i, Relation.FORMER, 0.25, "expected") for i in range(8)], 0.95)
    assert {rate.interval for rate in rates} == {Interval.POISSON_BINOMIAL}
    assert rates[-1].successes == 2.0 and rates[-1].rate == 0.25


def test_rates_over_seeds_are_means_and_their_interval_is_that_of_one_pass():
    outcomes = [embodied(0, 0, True, 0.8), embodied(1, 0, False, 0.0), embodied(0, 1, True, 0.6), embodied(1, 1, True, 1.0)]
    rate = embodied_rates(outcomes, 0.95)[-1]
    assert (rate.n, rate.seeds, rate.trials, rate.successes, rate.rate) == (2, 2, 4, 3.0, 0.75)
    assert rate.spl == pytest.approx(0.6)
    assert (rate.low, rate.high) == wilson_interval(1.5, 2, 0.95)
    again = [replace(outcome, seed=seed) for outcome in outcomes if outcome.seed == 0 for seed in range(9)]
    one, nine = (embodied_rates(some, 0.95)[-1] for some in (outcomes[:2], again))
    assert (one.low, one.high) == pytest.approx((nine.low, nine.high)) and nine.trials == 9 * one.trials


TERMS = ("stop", "box_distance_m", "answer_distance_m", "navigable_distance_m", "visible_px")
EVERY = [BY_NAME[name] for name in ("positions_single_visit", "positions_two_visits", "oracle_check")]
WORLD = [{"id": "a", "category": "Chair", "x": 1.0, "z": 0.0}, {"id": "b", "category": "Chair", "x": -4.0, "z": 0.0}]


def records(tmp_path, reverse=False):
    """Two episodes, two static arms, one embodied arm of two seeds, as files; ``EVERY`` is all arms that there are."""
    episodes = [episode_record(relation, world=WORLD) for relation in ("moved", "former")]

    def prediction(episode, arm, **form):
        return {"schema": "ovman-prediction/1", "episode": episode["id"], "arm": arm, "seed": 0, **form}

    def run(episode, seed, success):
        return {"schema": "ovman-run/1", "episode": episode["id"], "arm": "oracle_check", "seed": seed, "outcome": "stopped",
                "success": success, "spl": 0.5 * success, "path_length_m": 2.0, "actions": 7, **dict.fromkeys(TERMS)}  # fmt: skip

    box = {"x_min": -2.0, "z_min": -2.0, "x_max": 2.0, "z_max": 2.0}
    files = {
        "episodes": episodes,
        "positions_two_visits": [prediction(episodes[0], "positions_two_visits", x=1.5, z=0.0),
                                 prediction(episodes[1], "positions_two_visits", abstain="no_candidate")],
        "positions_single_visit": [prediction(episodes[0], "positions_single_visit",
                                              candidates=[{"x": 1.0, "z": 0.0}, {"x": 9.0, "z": 0.0}]),
                                   prediction(episodes[1], "positions_single_visit", box=box)],
        "seed0": [run(episode, 0, True) for episode in episodes],
        "seed1": [run(episode, 1, index == 0) for index, episode in enumerate(episodes)],
    }  # fmt: skip
    paths = {}
    for name, lines in files.items():
        paths[name] = tmp_path / f"{name}.jsonl"
        kept = list(reversed(lines)) if reverse and name != "episodes" else lines
        paths[name].write_text("".join(json.dumps(line) + "\n" for line in kept))
    predictions = [paths["positions_two_visits"], paths["positions_single_visit"]]
    runs = [paths["seed0"], paths["seed1"]]
    return paths["episodes"], (predictions[::-1] if reverse else predictions), (runs[::-1] if reverse else runs)


def test_the_stage_writes_rows_and_rates_that_do_not_hang_on_the_order_of_files(tmp_path):
    for name, reverse in (("one", False), ("other", True)):
        (tmp_path / name).mkdir()
        metrics.run(*records(tmp_path / name, reverse), CONSTANTS, tmp_path / name / "metrics", EVERY)
    names = sorted(path.name for path in (tmp_path / "one" / "metrics").iterdir())
    assert names == sorted(f"{name}.csv" for name in of_stage("metrics"))
    for name in names:
        one, other = ((tmp_path / where / "metrics" / name).read_bytes() for where in ("one", "other"))
        assert one == other and b"\r" not in one

    with (tmp_path / "one" / "metrics" / "static_rates.csv").open() as file:
        rates = list(csv.DictReader(file))
    whole = {rate["arm"]: rate for rate in rates if rate["relation"] == "all"}
    assert list(whole) == ["positions_single_visit", "positions_two_visits"]
    assert whole["positions_two_visits"]["rate"] == "0.500000" and whole["positions_two_visits"]["interval"] == "wilson"
    assert whole["positions_single_visit"]["interval"] == "poisson_binomial" and whole["positions_single_visit"]["spl"] == ""
    assert (tmp_path / "one" / "metrics" / metrics.EMBODIED_OUTCOMES).read_text().splitlines()[1:] == [
        "FloorPlan1/moved/0000,FloorPlan1,moved,Chair,2,1,oracle_check,0,stopped,1,0.500000,2.000000,7,",
        "FloorPlan1/former/0000,FloorPlan1,former,Chair,2,1,oracle_check,0,stopped,1,0.500000,2.000000,7,",
        "FloorPlan1/moved/0000,FloorPlan1,moved,Chair,2,1,oracle_check,1,stopped,1,0.500000,2.000000,7,",
        "FloorPlan1/former/0000,FloorPlan1,former,Chair,2,1,oracle_check,1,stopped,0,0.000000,2.000000,7,",
    ]


def test_an_arm_has_as_many_runs_as_its_entry_says(tmp_path):
    every = [arm.model_copy(update={"runs": 2}) if arm.name == "positions_two_visits" else arm for arm in EVERY]
    with pytest.raises(ValueError, match="positions_two_visits: predictions of 1 runs, but its entry in section arms says 2"):
        metrics.run(*records(tmp_path), CONSTANTS, tmp_path / "metrics", every)


@pytest.mark.parametrize(("answers", "arms"), [(True, ["positions_single_visit", "positions_two_visits"]),
                                               (False, ["positions_single_visit"])])  # fmt: skip
def test_an_arm_that_a_plug_in_makes_may_have_answered_nothing_and_is_read_where_it_has(tmp_path, answers, arms):
    every = [arm.model_copy(update={"made_by": "plugin"}) if arm.name == "positions_two_visits" else arm for arm in EVERY]
    episodes, predictions, runs = records(tmp_path)
    if not answers:
        predictions[0].write_text("")
    metrics.run(episodes, predictions, runs, CONSTANTS, tmp_path / "metrics", every)
    assert list(dict.fromkeys(row["arm"] for row in rows_of(tmp_path / "metrics", "static_rates"))) == arms


def test_the_arms_are_those_of_the_settings_and_the_directory_is_made_if_need_be(tmp_path):
    constants = SimpleNamespace(**vars(CONSTANTS), arms={arm.name: arm for arm in EVERY})
    inputs, deep = records(tmp_path), tmp_path / "results" / "main" / "metrics"
    # The second time the directory is there already.
    for _ in range(2):
        metrics.run(*inputs, constants, deep)
    metrics.run(*inputs, CONSTANTS, tmp_path / "given", EVERY)
    for path in deep.iterdir():
        assert path.read_bytes() == (tmp_path / "given" / path.name).read_bytes()
    # An arm of the settings that has no records is missed, unless other arms are given.
    constants.arms["two_visits"] = BY_NAME["two_visits"]
    with pytest.raises(ValueError, match="no records of the static arm 'two_visits'"):
        metrics.run(*inputs, constants, deep)
    metrics.run(*inputs, constants, deep, EVERY)


def test_thresholds_and_rungs_are_those_of_the_settings(tmp_path):
    """Four episodes whose answer is (2, 0), another chair at (-2, 0), and the three rungs of the error budget."""
    episodes = [MOVED | {"id": f"FloorPlan201/moved/{number:04d}"} for number in range(3)] + [moving()]
    ids = [episode["id"] for episode in episodes]
    # Off by 1.5 m and by 2.5 m, beside the other chair, and right.
    points = {"two_visits": [(3.5, 0.0), (4.5, 0.0), (-2.0, 0.5), (2.0, 0.0)]}
    points["grounding_two_visits"] = [(2.0, 0.9), *points["two_visits"][1:]]
    points["positions_two_visits"] = [(2.0, 0.0)] * 4
    # Only the first run ends beside the chair's box; the second is accepted for another reason.
    runs = [{"schema": "ovman-run/1", "episode": id_, "arm": "two_visits_embodied", "seed": 0, "outcome": "stopped",
             "success": success, "spl": 0.5 * success, "path_length_m": 2.0, "actions": 7, **dict.fromkeys(TERMS),
             "box_distance_m": box_m}
            for id_, success, box_m in zip(ids, (True, True, False, True), (0.9, 1.1, 0.2, 0.3), strict=True)]  # fmt: skip
    files = {"episodes": episodes, "runs": runs} | {
        arm: [{"schema": "ovman-prediction/1", "episode": id_, "arm": arm, "seed": 0, "x": x, "z": z}
              for id_, (x, z) in zip(ids, of_arm, strict=True)]
        for arm, of_arm in points.items()
    }  # fmt: skip
    paths = {name: tmp_path / f"{name}.jsonl" for name in files}
    for name, lines in files.items():
        paths[name].write_text("".join(json.dumps(line) + "\n" for line in lines))
    arms = [BY_NAME[name] for name in (*points, "two_visits_embodied")]
    out = tmp_path / "metrics"
    metrics.run(paths["episodes"], [paths[name] for name in points], [paths["runs"]], CONSTANTS, out, arms)

    counts = {row["verdict"]: int(row["episodes"]) for row in of_all(out, "taxonomy") if row["arm"] == "two_visits"}
    assert counts == {"success": 1, "abstain": 0, "near_miss": 1, "elsewhere": 1, "wrong_instance": 1, "lost_in_navigation": 0}

    (row,) = of_all(out, "rescued")
    assert (row["arm"], row["gained"], row["rescued"], row["nearest_m"]) == ("two_visits_embodied", "2", "1", "1.500000")

    steps = of_all(out, "budget")
    assert [step["rung"] for step in steps] == [*CONFIG.comparisons.rungs.values(), "answer given"]
    assert [float(step["rate"]) for step in steps] == [0.25, 0.5, 1.0, 1.0]
    assert [(step["gained"], step["lost"]) for step in steps] == [("", ""), ("1", "0"), ("2", "0"), ("0", "0")]

    between, *away = rows_of(out, "mover")
    assert {row["radius_m"] for row in (between, *away)} == {"1.000000"} and {row["moved"] for row in away} == {""}
    # It went 2 m, which is beyond R and enough to count as moved.
    assert (between["median_m"], between["within"], between["moved"]) == ("2.000000", "0.000000", "1")


def rows_of(directory, name):
    with (directory / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def of_all(directory, name):
    return [row for row in rows_of(directory, name) if row["relation"] == "all"]


def test_no_runs_leave_no_rows(tmp_path):
    episodes, predictions, _ = records(tmp_path)
    metrics.run(episodes, predictions, [], CONSTANTS, tmp_path / "metrics", EVERY)
    assert len((tmp_path / "metrics" / "embodied_rates.csv").read_text().splitlines()) == 1


def test_an_arm_that_answered_nothing_is_not_an_arm_that_does_not_exist(tmp_path):
    episodes, predictions, runs = records(tmp_path)
    predictions[0].write_text("")
    with pytest.raises(ValueError, match="no predictions for 2 episodes"):
        metrics.run(episodes, predictions, runs, CONSTANTS, tmp_path / "metrics", EVERY)


def test_an_arm_of_another_name_is_refused(tmp_path):
    episodes, predictions, runs = records(tmp_path)
    predictions[0].write_text(predictions[0].read_text().replace("positions_two_visits", "mine"))
    with pytest.raises(ValueError, match="'mine' is not an arm that is static"):
        metrics.run(episodes, predictions, runs, CONSTANTS, tmp_path / "metrics", EVERY)


def test_an_arm_without_records_does_not_leave_the_tables_silently(tmp_path):
    episodes, predictions, runs = records(tmp_path)
    with pytest.raises(ValueError, match="no records of the static arm 'positions_single_visit'"):
        metrics.run(episodes, predictions[:1], runs, CONSTANTS, tmp_path / "metrics", EVERY)


def test_small_p_values_are_written_with_their_digits_and_pairs_without_an_arm_are_named(tmp_path, capsys):
    metrics.run(*records(tmp_path), CONSTANTS, tmp_path / "metrics", EVERY)
    assert "not compared: two visits against one, embodied; there is no arm two_visits_embodied" in capsys.readouterr().out
    with (tmp_path / "metrics" / "significance.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["relation"], row["p_holm"] == "") for row in rows] == [("moved", False), ("former", False), ("all", True)]
    assert csv_text(Row, [Row(1.5e-23)]) == "p\n1.5e-23\n"


@dataclass
class Row:
    p: float


def test_an_id_that_is_there_twice_is_refused(tmp_path):
    episodes, predictions, runs = records(tmp_path)
    episodes.write_text(episodes.read_text() * 2)
    with pytest.raises(ValueError, match="FloorPlan1/moved/0000 is in the file already"):
        metrics.run(episodes, predictions, runs, CONSTANTS, tmp_path / "metrics", EVERY)

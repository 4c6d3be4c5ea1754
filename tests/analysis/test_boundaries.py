"""The statistics, the rates and the failure taxonomy on their thresholds, against values worked out by hand."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from ovman.analysis.budget import ANSWER_GIVEN, Step, budget
from ovman.analysis.difficulty import By, Difficulty, difficulty, natural
from ovman.analysis.instances import TrueScene
from ovman.analysis.localisation import localised
from ovman.analysis.navigation import Navigation, navigation
from ovman.analysis.outcomes import Case, static_outcomes
from ovman.analysis.rates import (
    Interval,
    by_arm,
    by_relation,
    by_seed,
    chances,
    embodied_rate,
    embodied_rates,
    expected_range,
    poisson_binomial_range,
    static_rate,
    static_rates,
)
from ovman.analysis.significance import Method, family, significance
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial, poisson_binomial_tail, wilson_interval
from ovman.analysis.taxonomy import LOST, TaxonomyCount, Verdict, taxonomy, verdict
from ovman.records.prediction import Answer, Prediction
from ovman.records.task import Relation
from ovman.settings import Kind, Pair
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import ROUND, embodied, static
from tests.analysis.recordings import write_scene, write_visit
from tests.arms import CONFIG

R, NEAR = 1.0, 2.0
NEXT = np.nextafter


# --- statistics -----------------------------------------------------------------------------------


def test_wilsons_interval_of_eight_in_ten():
    assert wilson_interval(8, 10) == pytest.approx((0.490162, 0.943318), abs=1e-6)
    assert wilson_interval(8, 10, 0.5) == pytest.approx((0.702491, 0.871401), abs=1e-6)
    assert wilson_interval(0, 1)[0] == 0.0 and wilson_interval(1, 1)[1] == 1.0
    assert 0.0 < wilson_interval(1, 1)[0] < wilson_interval(0, 1)[1] < 1.0


@pytest.mark.parametrize("successes, trials", [(0, 0), (0, -1), (-0.5, 10), (10.5, 10), (2, 1)])
def test_a_rate_has_a_trial_and_no_more_successes_than_trials(successes, trials):
    with pytest.raises(ValueError, match="are no rate"):
        wilson_interval(successes, trials)


@pytest.mark.parametrize("confidence", [0.0, 1.0, -0.1, 1.1])
def test_a_confidence_lies_between_zero_and_one(confidence):
    with pytest.raises(ValueError, match="between 0 and 1"):
        wilson_interval(1, 2, confidence)


def test_mcnemars_test_by_hand():
    """Twice the smaller tail of so many fair coins, at most 1."""
    assert mcnemar_exact(0, 0) == mcnemar_exact(1, 0) == mcnemar_exact(0, 1) == mcnemar_exact(3, 3) == 1.0
    assert mcnemar_exact(6, 0) == mcnemar_exact(0, 6) == pytest.approx(2 / 64)
    assert mcnemar_exact(7, 2) == pytest.approx(2 * (1 + 9 + 36) / 512)
    for wins, losses in ((-1, 0), (0, -1)):
        with pytest.raises(ValueError, match="a count is at least 0"):
            mcnemar_exact(wins, losses)


def test_the_poisson_binomial_by_hand():
    assert poisson_binomial([]).tolist() == [1.0]
    assert poisson_binomial([0.0, 1.0]).tolist() == [0.0, 1.0, 0.0]
    assert poisson_binomial([0.25, 0.5]).tolist() == [0.375, 0.5, 0.125]
    assert [poisson_binomial_tail([0.25, 0.5], k) for k in (-1, 0, 1, 2, 3)] == [1.0, 1.0, 0.625, 0.125, 0.0]
    for wrong in (NEXT(0.0, -1.0), NEXT(1.0, 2.0), math.nan):
        with pytest.raises(ValueError, match="is no probability"):
            poisson_binomial([0.5, float(wrong)])


def test_a_tail_is_a_probability_to_the_last_bit():
    """Where rounding makes the terms sum to less than 1, or to more."""
    assert math.fsum(poisson_binomial([0.61, 0.13])) < 1.0 == poisson_binomial_tail([0.61, 0.13], 0)
    assert math.fsum(poisson_binomial([1.0, 0.97, 0.22])[1:]) > 1.0 == poisson_binomial_tail([1.0, 0.97, 0.22], 1)


def test_holms_correction_by_hand():
    assert holm([]) == ()
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([1.0, 0.0, 0.6]) == (1.0, 0.0, 1.0)
    for wrong in (NEXT(0.0, -1.0), NEXT(1.0, 2.0)):
        with pytest.raises(ValueError, match="is no p-value"):
            holm([0.5, float(wrong)])


# --- rates ----------------------------------------------------------------------------------------


def central_range(probabilities: list[Fraction], confidence: Fraction) -> tuple[float, float]:
    """What the docstring says, in fractions: below low and above high lies at most (1 - confidence) / 2, and as much as may."""
    n = len(probabilities)
    exact = [Fraction(1)]
    for p in probabilities:
        exact = [a * (1 - p) + b * p for a, b in zip([*exact, 0], [0, *exact], strict=True)]
    outside = (1 - confidence) / 2
    low = max(k for k in range(n + 1) if sum(exact[:k]) <= outside)
    high = min(k for k in range(n + 1) if sum(exact[k + 1 :]) <= outside)
    return low / n, high / n


@pytest.mark.parametrize(
    "probabilities, confidence",
    [
        ([0.5, 0.5], 0.5),  # a quarter lies on each side: exactly what may
        ([0.5, 0.5], 0.25),
        ([0.5], 0.95),
        ([0.25, 0.5, 0.75], 0.75),
        ([0.5] * 4, 0.875),
        ([0.5] * 4, 0.375),
        ([0.5] * 4, 0.25),
        ([1.0, 1.0, 0.0], 0.5),
        ([0.0], 0.5),
        ([1.0], 0.5),
    ],
)
def test_the_central_range_leaves_at_most_half_of_the_rest_on_each_side(probabilities, confidence):
    expected = central_range([Fraction(p) for p in probabilities], Fraction(confidence))
    assert poisson_binomial_range(probabilities, confidence) == expected
    assert expected_range([probabilities, probabilities], confidence) == expected


def test_one_of_several_runs_is_drawn_at_random():
    """A run that always fails and one that always succeeds: half of the passes lie at either end."""
    assert expected_range([[0.0, 0.0], [1.0, 1.0]], 0.5) == (0.0, 1.0)
    assert expected_range([[0.0, 0.0]] * 3 + [[1.0, 1.0]], 0.25) == (0.0, 0.0)
    assert expected_range([[0.0, 0.0]] * 3 + [[1.0, 1.0]], 0.5) == (0.0, 0.0)
    assert expected_range([[0.0, 0.0]] * 3 + [[1.0, 1.0]], 0.75) == (0.0, 1.0)


def test_seeds_add_no_episodes():
    runs = [
        embodied("arm", k, success, seed, spl=0.5) for seed, hits in ((7, 3), (3, 1)) for k in range(4) for success in [k < hits]
    ]
    made = embodied_rate("arm", "all", runs, 0.9)
    assert (made.n, made.seeds, made.trials, made.successes, made.rate) == (4, 2, 8, 4.0, 0.5)
    assert (made.least, made.greatest, made.spl) == (0.25, 0.75, 0.25)
    assert (made.low, made.high) == wilson_interval(2, 4, 0.9)
    assert (made.interval, made.confidence) == (Interval.WILSON, 0.9)
    single = embodied_rate("arm", "all", runs[:4], 0.9)
    assert (single.seeds, single.least, single.greatest) == (1, None, None)
    assert list(by_seed(runs)) == [3, 7]


def test_the_rate_of_a_stochastic_pick_has_the_range_of_one_pass():
    picks = [static("pick", k, p, "expected") for k, p in enumerate((0.5, 0.5))]
    made = static_rate("pick", "all", picks, 0.5)
    assert (made.low, made.high, made.successes, made.rate) == (0.5, 0.5, 1.0, 0.5)
    assert (made.interval, made.spl, made.least) == (Interval.POISSON_BINOMIAL, None, None)
    several = [static("pick", k, p, "expected", seed=seed) for seed in (0, 1) for k, p in enumerate((seed, seed))]
    assert static_rate("pick", "all", several, 0.5).low == 0.0
    assert static_rate("pick", "all", several, 0.5).high == 1.0


def test_rates_come_by_arm_then_by_relation_of_the_task_then_all():
    numbers = [5, 2, 0, 6, 1]
    outcomes = [static(arm, k, k % 2) for arm in ("b", "a") for k in numbers]
    runs = [embodied(arm, k, k % 2 == 0) for arm in ("b", "a") for k in numbers]
    relations = [relation.value for k, relation in enumerate(ROUND) if k in (0, 1, 2, 5)] + ["all"]
    for rows in (static_rates(outcomes, 0.95), embodied_rates(runs, 0.95)):
        assert [(row.arm, row.relation) for row in rows] == [(arm, relation) for arm in "ba" for relation in relations]
        assert [row.n for row in rows[:5]] == [2, 1, 1, 1, 5]
        assert {row.confidence for row in rows} == {0.95}
    assert list(by_arm(outcomes)) == ["b", "a"] and [len(group) for _, group in by_relation(outcomes[:5])] == [2, 1, 1, 1, 5]


# --- taxonomy -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "distance_m, other_m, expected",
    [
        (1.5, R, Verdict.WRONG_INSTANCE),
        (1.5, NEXT(R, 2.0), Verdict.NEAR_MISS),
        (9.0, 0.0, Verdict.WRONG_INSTANCE),
        (NEAR, None, Verdict.NEAR_MISS),
        (NEXT(NEAR, 3.0), None, Verdict.ELSEWHERE),
        (NEAR, 5.0, Verdict.NEAR_MISS),
    ],
)
def test_the_distances_of_the_taxonomy_are_inclusive(distance_m, other_m, expected):
    assert verdict(static("arm", 0, 0, distance_m=float(distance_m), other_m=other_m), R, NEAR) is expected


def test_a_success_and_an_abstention_are_judged_first():
    assert verdict(static("arm", 0, 1, distance_m=0.5, other_m=0.1), R, NEAR) is Verdict.SUCCESS
    assert verdict(static("arm", 0, 0, "abstained", other_m=None), R, NEAR) is Verdict.ABSTAIN
    with pytest.raises(ValueError, match="a probability, no verdict"):
        verdict(static("arm", 0, 0.5, "expected"), R, NEAR)


def lost(executes: str, relation: str, count: int | None, seed: int) -> Navigation:
    return Navigation("driven", seed, relation, 3, 1, 1 / 3, 0.3, 0.9, executes, 2.0, count, 0, 1.0)


def test_what_navigation_lost_follows_the_verdicts_of_the_arm_that_was_executed():
    outcomes = [static("two_visits", k, k % 2, other_m=None) for k in (0, 1, 6)]
    outcomes += [static("pick", k, 0.5, "expected") for k in (0, 1, 6)]
    runs = [lost("two_visits", "all", 1, 17), lost("two_visits", "all", 0, 18), lost("other", "all", 1, 17)]
    rows = taxonomy(outcomes, [*runs, lost("two_visits", "moved", None, 17)], R, NEAR)
    first, second = ROUND[0].value, ROUND[1].value
    assert [(r.verdict, r.relation, r.episodes, r.n) for r in rows if r.verdict == "success"] == [
        ("success", first, 0, 2),
        ("success", second, 1, 1),
        ("success", "all", 1, 3),
    ]
    assert {(r.seed, r.embodied) for r in rows if r.verdict != LOST} == {(None, None)}
    assert [r for r in rows if r.verdict == LOST] == [
        TaxonomyCount("two_visits", LOST, "all", 1, 3, "driven", 17),
        TaxonomyCount("two_visits", LOST, "all", 0, 3, "driven", 18),
    ]
    assert [r.verdict for r in rows if r.relation == "all"] == [*(which.value for which in Verdict), LOST, LOST]


def test_an_arm_with_several_runs_is_counted_run_by_run():
    outcomes = [static("arm", 0, k == 2, seed=k, other_m=None) for k in (2, 1)]
    rows = [r for r in taxonomy(outcomes, [], R, NEAR) if r.relation == "all" and r.verdict == "success"]
    assert [(r.seed, r.episodes, r.n) for r in rows] == [(1, 0, 1), (2, 1, 1)]


def test_an_arm_behind_a_stochastic_pick_is_counted():
    outcomes = [static("pick", 0, 0.5, "expected"), static("arm", 0, 1), static("other", 0, 0, "abstained")]
    rows = [row for row in taxonomy(outcomes, [], R, NEAR) if row.episodes and row.relation == "all"]
    assert rows == [TaxonomyCount("arm", "success", "all", 1, 1), TaxonomyCount("other", "abstain", "all", 1, 1)]


# --- significance ---------------------------------------------------------------------------------

PAIR = Pair(name="ours against theirs", arm="ours", baseline="theirs")


def test_a_pair_is_compared_by_relation_and_over_all():
    """Seven episodes of one relation, one of another: six wins and a loss; a loss."""
    hits = {0: (1, 0), 6: (1, 0), 12: (1, 0), 18: (1, 0), 24: (1, 0), 30: (1, 0), 36: (0, 1), 1: (0, 1)}
    ours = [static("ours", k, a) for k, (a, _) in hits.items()]
    theirs = [static("theirs", k, b) for k, (_, b) in reversed(hits.items())]
    one, two, both = family(PAIR, 17, ours, theirs)
    assert (one.n, one.successes, one.baseline_successes, one.wins, one.losses) == (7, 6, 1.0, 6.0, 1.0)
    assert (two.n, two.successes, two.baseline_successes, two.wins, two.losses) == (1, 0, 1.0, 0.0, 1.0)
    assert (both.n, both.successes, both.wins, both.losses, both.seed) == (8, 6, 6.0, 2.0, 17)
    assert [row.p for row in (one, two, both)] == pytest.approx([2 * 8 / 128, 1.0, 2 * (1 + 8 + 28) / 256])
    assert (one.p_holm, two.p_holm, both.p_holm) == (pytest.approx(0.25), 1.0, None)
    assert {row.test for row in (one, two, both)} == {Method.MCNEMAR}
    assert (one.title, one.arm, one.baseline, one.relation) == (PAIR.name, "ours", "theirs", ROUND[0].value)


def test_an_arm_is_tested_against_what_a_stochastic_pick_would_reach():
    ours = [static("ours", k, 1) for k in (0, 6)]
    theirs = [static("theirs", k, p, "expected") for k, p in ((0, 0.25), (6, 0.5))]
    (row, whole) = family(PAIR, 0, ours, theirs)
    assert (row.test, row.p, row.wins, row.losses) == (Method.POISSON_BINOMIAL, 0.125, 1.25, 0.0)
    assert (whole.p, whole.baseline_successes) == (0.125, 0.75)
    with pytest.raises(ValueError, match="is a stochastic pick"):
        family(PAIR, 0, theirs, ours)
    with pytest.raises(ValueError, match="not over the same episodes"):
        family(PAIR, 0, ours, theirs[:1])


# --- what the answer adds, and groups -------------------------------------------------------------


def test_the_answer_given_reaches_every_episode_and_is_tested_against_the_rung_below():
    rungs = CONFIG.comparisons.rungs
    outcomes = [static(arm, 6 * k, k == 0) for arm in rungs for k in range(7)]
    compared, _ = significance(outcomes, [], tuple(CONFIG.comparisons.pairs.values()))
    last = budget(static_rates(outcomes, 0.95), compared, rungs)[-1]
    assert (last.n, last.successes, last.rate, last.gained, last.lost) == (7, 7, 1.0, 6, 0)
    assert (last.gain, last.p) == (pytest.approx(6 / 7), mcnemar_exact(6, 0))


def test_a_rung_has_the_rate_of_its_arm_and_the_test_against_the_rung_below():
    outcomes = [static("low", 6 * k, k < 1) for k in range(7)] + [static("high", 6 * k, k > 0) for k in range(7)]
    compared, _ = significance(outcomes, [], [Pair(name="a rung", arm="high", baseline="low")])
    steps = [step for step in budget(static_rates(outcomes, 0.5), compared, {"low": "L", "high": "H"}) if step.relation == "all"]
    low, high = wilson_interval(1, 7, 0.5), wilson_interval(6, 7, 0.5)
    assert steps == [
        Step("L", "low", "all", 7, 1, 1 / 7, *low),
        Step("H", "high", "all", 7, 6, 6 / 7, *high, 6 / 7 - 1 / 7, 6, 1, 2 * 8 / 128),
        Step(ANSWER_GIVEN, None, "all", 7, 7, 1.0, None, None, 1.0 - 6 / 7, 1, 0, 1.0),
    ]


def test_a_group_has_the_rate_of_its_arm_at_the_confidence_asked_for():
    outcomes = [static("arm", k, k < 3, scene="FloorPlan7") for k in range(4)]
    low, high = wilson_interval(3, 4, 0.5)
    assert difficulty(outcomes, 0.5) == [
        Difficulty(by, group, "arm", 4, 3.0, 0.75, low, high, Interval.WILSON, 0.5)
        for by, group in ((By.INSTANCES, "2"), (By.SCENE, "FloorPlan7"))
    ]


def test_chances_are_means_of_one_over_the_counts_of_an_episode():
    outcomes = [static("arm", k, 1, instances=n, alike=m) for k, n, m in ((0, 2, 1), (6, 4, 5), (1, 5, 4))]
    first, second = ROUND[0].value, ROUND[1].value
    found = chances({outcome.episode: outcome for outcome in outcomes})
    assert found.keys() == {first, second, "all"} and chances({}) == {}
    assert found[first] == pytest.approx((0.375, 0.6)) and found[second] == pytest.approx((0.2, 0.25))
    assert found["all"] == pytest.approx((0.95 / 3, 1.45 / 3))


def test_categories_with_many_instances_are_one_group():
    outcomes = [static("arm", k, 1, instances=count) for k, count in enumerate((2, 3, 4, 5))]
    rows = [row for row in difficulty(outcomes, 0.95) if row.by is By.INSTANCES]
    assert [(row.group, row.n) for row in rows] == [("2", 1), ("3", 1), ("4+", 2)]


def test_names_come_by_the_number_in_them_and_those_without_first():
    names = ["FloorPlan10", "FloorPlan9", "Hall", "FloorPlan1", "Attic"]
    assert sorted(names, key=natural) == ["Attic", "Hall", "FloorPlan1", "FloorPlan9", "FloorPlan10"]
    assert natural("Hall") < natural("Plan1")
    assert natural("Zoo") < natural("Attic1")


def test_a_true_mask_of_the_minimum_is_localised(tmp_path):
    scene, directory = TrueScene.load(write_scene(tmp_path)), write_visit(tmp_path / "untouched")
    sizes = {row.object: row.px for row in localised(scene, directory, 90.0, 1, None)}
    smallest = min(sizes, key=lambda name: sizes[name])
    for px, among in ((sizes[smallest], True), (sizes[smallest] + 1, False)):
        assert (smallest in {row.object for row in localised(scene, directory, 90.0, px, None)}) is among


def test_a_point_on_the_radius_succeeds():
    case = Case("FloorPlan1/moved/0000", "FloorPlan1", Relation.MOVED, "Chair", 2, (0.0, 0.0))
    for x, success in ((R, 1.0), (float(NEXT(R, 2.0)), 0.0)):
        predicted = Prediction.of(case.id, "two_visits", 0, Answer(x, 0.0))
        (row,) = static_outcomes([case], [predicted], radius_m=R, samples=10, seed=0)
        assert (row.success, row.distance_m) == (success, x)


def test_only_an_arm_that_is_executed_has_one_answer_an_episode():
    arms = [ArmJob(name="driven", kind=Kind.EMBODIED, agent="x:y", executes="answers")]
    runs = [embodied("driven", 0, True)]
    several = [static(arm, 0, 1, seed=seed) for arm, seeds in (("answers", (0,)), ("other", (0, 1))) for seed in seeds]
    assert [row.lost for row in navigation(several, runs, arms)] == [0, 0]
    with pytest.raises(ValueError, match="answers has answers under several seeds"):
        navigation([static("answers", 0, 1, seed=seed) for seed in (0, 1)], runs, arms)


def test_a_row_of_navigation_sets_the_runs_of_an_arm_beside_the_answers_that_it_executes():
    arms = [ArmJob(name="driven", kind=Kind.EMBODIED, agent="x:y", executes="answers")]
    answers = [static("answers", 6 * k, k < 5) for k in range(8)]
    runs = [embodied("driven", 6 * k, k >= 4, 17, spl=0.5) for k in range(8)]
    assert navigation(answers, runs, arms) == [
        Navigation("driven", 17, relation, 8, 4, 0.5, 0.25, 0.5, "answers", 5.0, 4, 3, 1.0)
        for relation in (ROUND[0].value, "all")
    ]
    (*_, whole) = navigation([static("answers", 6 * k, 1) for k in range(8)], runs, arms)
    assert (whole.lost, whole.gained, whole.p) == (4, 0, 2 / 16)


def test_pixels_are_objects_of_the_scene_or_none(tmp_path):
    scene = TrueScene.load(write_scene(tmp_path))
    ids = scene.ids(np.array([[0, 1, 2], [3, 2, 0]], np.uint16), ["wall|1", "Vase|1", "Sofa|1"])
    assert [one.id for one in scene.objects[:2]] == ["Sofa|1", "Vase|1"]
    assert ids.dtype == np.int32 and ids.tolist() == [[-1, -1, 1], [0, 1, -1]]

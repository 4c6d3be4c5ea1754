"""Verdicts and the release on their thresholds. Released trials are changed in one measurement at a time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.release import ShortSplitError, rejection, run
from ovman.generation.selection import Size, select_in_turn
from ovman.generation.verdict import reasons, verdict
from ovman.records.geometry import Position
from ovman.records.record import lines
from ovman.records.scene import Alteration, Roam
from ovman.records.task import Instance, Rejection, Relation, WorldState
from ovman.records.trial import Bound, Certification, Displaced, OracleRun, Trial
from ovman.records.visit import Sighting, VisitPair
from ovman.settings import MAIN, Settings
from tests.arms import CONFIG
from tests.episodes import DATA

SCENES = ("FloorPlan1", "FloorPlan201", "FloorPlan429")
ADMISSIBILITY, CANDIDATES, SUCCESS = CONFIG.admissibility, CONFIG.candidates, CONFIG.success
BELOW, ABOVE = 0.9999, 1.0001
TRIALS = {one.candidate.id: one for one in Trial.read(DATA / "trials" / "main.jsonl") if one.candidate.scene in SCENES}
RUNS = {one.id: one.runs for one in Certification.read(DATA / "certified" / "main.jsonl") if one.id in TRIALS}
RELATIONS = list(Relation)
SHORTCUTS = (Rejection.CROWDED, Rejection.ABOVE_CHANCE)
"""What a bystander that is pushed towards the answer brings about as well."""


def admitted(relation: Relation) -> Trial:
    """An admissible trial of a relation."""
    certified = (t for k, t in TRIALS.items() if k in RUNS and t.candidate.relation is relation)
    return next(t for t in certified if verdict(t, CONFIG).rejected is None)


def measured(trial: Trial, **fields: Any) -> Trial:
    """The trial with other measurements."""
    return trial.model_copy(update={"measured": trial.measured.model_copy(update=fields)})


def judged(trial: Trial, **fields: Any) -> list[Rejection]:
    return list(reasons(measured(trial, **fields), CONFIG))


# --- geometry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("relation", RELATIONS)
def test_each_threshold_of_a_measurement_is_inclusive(relation: Relation) -> None:
    trial, clearance_m, enough = admitted(relation), CANDIDATES.spawn_clearance_m, SUCCESS.visible_px
    radius_m, tolerance_m, beyond_m = ADMISSIBILITY.validity_radius_m, ADMISSIBILITY.drift_tolerance_m, CANDIDATES.spawn_beyond_m
    hidden = [Rejection.ANSWER_NOT_VISIBLE] if relation.current else []
    cases: list[tuple[str, Any, list[Rejection]]] = [
        ("spawn_clearance_m", {"before": clearance_m, "after": clearance_m}, []),
        ("spawn_clearance_m", {"before": BELOW * clearance_m, "after": 9.0}, [Rejection.SPAWN_TOO_CLOSE]),
        ("spawn_clearance_m", {"before": 9.0, "after": BELOW * clearance_m}, [Rejection.SPAWN_TOO_CLOSE]),
        ("spawn_clearance_m", None, []),
        ("spawn_free_moves", 0, [Rejection.SPAWN_IMMOBILE]),
        ("spawn_free_moves", 1, []),
        ("spawn_free_moves", None, []),
        ("spawn_to_box_m", beyond_m, [Rejection.SPAWN_AT_ANSWER]),
        ("spawn_to_box_m", ABOVE * beyond_m, []),
        ("spawn_to_box_m", None, []),
        ("answer_to_navigable_m", radius_m, []),
        ("answer_to_navigable_m", ABOVE * radius_m, [Rejection.ANSWER_UNREACHABLE]),
        ("visible_px", {0: 0, 30: enough, 60: 0}, []),
        ("visible_px", {0: enough - 1, 30: enough - 1, 60: 0}, hidden),
        ("visible_px", None, hidden),
        ("drift_m", {"a": tolerance_m, "b": 0.0}, []),
        ("drift_m", {"a": 0.0, "b": ABOVE * tolerance_m}, [Rejection.DRIFTED]),
        ("drift_m", None, []),
    ]
    if relation in (Relation.MOVED, Relation.FORMER, Relation.STABLE):
        (changed,), least_m = [a.instance for a in trial.candidate.second], CANDIDATES.delta_min_m
        cases.append(("displacement_m", {changed: least_m}, []))
        cases.append(("displacement_m", {changed: BELOW * least_m}, [Rejection.DISPLACEMENT_BELOW_MINIMUM]))
    assert tolerance_m != ADMISSIBILITY.tau_m
    for field, value, against in cases:
        assert judged(trial, **{field: value}) == against, (field, value)
    with pytest.raises(ValueError, match="run `trials` again"):
        judged(trial, answer_to_navigable_m=None)


# --- the anti-shortcut rule and the spawn ---------------------------------------------------------


@pytest.mark.parametrize("relation", RELATIONS)
def test_an_instance_at_the_crowding_distance_crowds_in_the_answers_visit_and_in_the_second(relation: Relation) -> None:
    trial, radius_m = admitted(relation), CANDIDATES.crowding_m
    answer, measurement = trial.measured.answer, trial.measured
    assert answer is not None and measurement.world_1 is not None and measurement.world_2 is not None
    for visit, counts in (("world_1", relation.past), ("world_2", True)):
        for metres, near in ((radius_m, True), (ABOVE * radius_m, False)):
            stranger = Instance("Stranger|1", trial.candidate.category, answer[0] + metres, answer[1])
            world = WorldState((*getattr(measurement, visit), stranger))
            against = list(reasons(measured(trial, **{visit: world}), CONFIG))
            assert (Rejection.CROWDED in against) is (near and counts), (visit, metres)


def allowing(above_chance: float) -> Settings:
    return CONFIG.model_copy(update={"admissibility": ADMISSIBILITY.model_copy(update={"above_chance": above_chance})})


@pytest.mark.parametrize("relation", RELATIONS)
def test_a_pick_among_fewer_recorded_instances_may_exceed_chance_by_the_limit(relation: Relation) -> None:
    """In the altered trial the tour recorded the target alone: a pick finds it for certain. The released one is at chance."""
    trial = admitted(relation)
    assert trial.measured.sightings is not None and list(reasons(trial, allowing(0.0))) == []
    visit = "first" if relation.past else "second"
    alone = tuple(s for s in trial.measured.sightings[visit] if s.instance == trial.candidate.target)
    lonely = measured(trial, sightings=trial.measured.sightings.model_copy(update={visit: alone}))
    assert Rejection.ABOVE_CHANCE in reasons(lonely, CONFIG) and Rejection.ABOVE_CHANCE not in reasons(lonely, allowing(1.0))


@pytest.mark.parametrize("relation", RELATIONS)
def test_no_spawn_is_where_a_stop_would_succeed(relation: Relation) -> None:
    trial, beyond_m = admitted(relation), CANDIDATES.spawn_beyond_m
    spawn = trial.candidate.spawn
    assert spawn is not None
    for name in ("answer", "nearest_navigable"):
        for metres, near in ((beyond_m - 1e-6, True), (ABOVE * beyond_m, False)):
            against = judged(trial, **{name: (spawn.x, spawn.z + metres)})
            assert (Rejection.SPAWN_AT_ANSWER in against) is near


# --- observation ----------------------------------------------------------------------------------


def seen(trial: Trial, visit: str, px: int) -> Trial:
    """The trial whose changed instances have masks of `px` pixels in a visit, in all views that saw them."""
    assert trial.measured.sightings is not None
    changed = {a.instance for a in trial.candidate.first + trial.candidate.second}
    altered = tuple(s.model_copy(update={"px": px}) if s.instance in changed else s for s in trial.measured.sightings[visit])
    return measured(trial, sightings=trial.measured.sightings.model_copy(update={visit: altered}))


@pytest.mark.parametrize("visit", ["first", "second"])
@pytest.mark.parametrize("relation", RELATIONS)
def test_the_changed_instance_is_recorded_in_the_tours_that_define_the_relation(relation: Relation, visit: str) -> None:
    trial, least = admitted(relation), ADMISSIBILITY.min_mask_px
    defining = {Relation.APPEARED: ["second"], Relation.MOVING: ["second"], Relation.REMOVED: ["first"]}
    assert list(reasons(seen(trial, visit, least), CONFIG)) == []
    against = list(reasons(seen(trial, visit, least - 1), CONFIG))
    assert (Rejection.CHANGED_INSTANCE_NOT_RECORDED in against) is (visit in defining.get(relation, ["first", "second"]))


def other(trial: Trial) -> Instance:
    """An instance of the category that no change moves and no query asks for."""
    world = trial.measured.world_1
    assert world is not None
    changed = {a.instance for a in trial.candidate.first + trial.candidate.second}
    return next(k for k in world if k.id not in changed | {trial.candidate.target})


def pushed(trial: Trial, metres: float) -> WorldState:
    """The true state of visit 2 with the other instance pushed along x from where it was in visit 1."""
    assert trial.measured.world_2 is not None
    bystander = other(trial)
    there = Instance(bystander.id, bystander.category, bystander.x + metres, bystander.z)
    return WorldState(tuple(there if k.id == bystander.id else k for k in trial.measured.world_2))


@pytest.mark.parametrize("relation", [relation for relation in RELATIONS if relation is not Relation.STABLE])
def test_the_true_states_are_judged_beside_the_recorded_ones(relation: Relation) -> None:
    """A bystander that is pushed while nobody looks has moved."""
    trial = admitted(relation)
    less, more = (measured(trial, world_2=pushed(trial, share * ADMISSIBILITY.tau_m)) for share in (0.9, 1.1))
    assert [r for r in reasons(less, CONFIG) if r not in SHORTCUTS] == []
    assert [r for r in reasons(more, CONFIG) if r not in SHORTCUTS] == [Rejection.BYSTANDER_MOVED]


@pytest.mark.parametrize("relation", [relation for relation in RELATIONS if relation is not Relation.STABLE])
def test_the_referent_is_the_scripted_target(relation: Relation) -> None:
    trial = admitted(relation)
    candidate = trial.candidate.model_copy(update={"target": other(trial).id})
    against = list(reasons(trial.model_copy(update={"candidate": candidate}), CONFIG))
    # The instance that was scripted stands at the answer, which crowds that of the other.
    assert Rejection.REFERENT_NOT_TARGET in against and set(against) <= {Rejection.REFERENT_NOT_TARGET, Rejection.CROWDED}


def beside(kind: str, first_px: int, second_px: int, at: float) -> Trial:
    """A trial beside whose removed instance, at the answer, another one changes and ends so many metres away."""
    trial, there = admitted(Relation.REMOVED), Position(x=0.0, y=0.0, z=0.0)
    also = Alteration(kind="disable", instance="other|1")
    if kind == "displace":
        also = Alteration(kind="displace", instance="other|1", placement=(at, 0.0), height_m=0.05)
    if kind == "motion":
        also = Alteration(kind="motion", instance="other|1", roam=Roam.over(9.0, 0.0, 0.25, [(0, 0)]))
    candidate, far = trial.candidate, there.model_copy(update={"x": 9.0})
    changes = {"first": (also,)} if kind == "enable" else {"second": (*candidate.second, also)}
    return measured(
        trial.model_copy(update={"candidate": candidate.model_copy(update=changes | {"others": {"other|1": "Other"}})}),
        answer=(0.0, 0.0),
        changed={
            candidate.target: Displaced(before=there, after=None),
            "other|1": Displaced(before=far, after=there.model_copy(update={"x": at})),
        },
        other_px={"other|1": VisitPair[int](first=first_px, second=second_px)},
    )


def of_others(trial: Trial) -> set[Rejection]:
    return {*reasons(trial, CONFIG)} & {Rejection.OTHER_CHANGE_NEAR, Rejection.OTHER_CHANGE_NOT_RECORDED}


@pytest.mark.parametrize(
    "kind, in_first, in_second",
    [("displace", True, True), ("disable", True, False), ("enable", False, True), ("motion", False, True)],
)
def test_a_mask_of_the_minimum_records_another_change_in_the_tours_that_define_it(
    kind: str, in_first: bool, in_second: bool
) -> None:
    enough, too_few = ADMISSIBILITY.min_mask_px, ADMISSIBILITY.min_mask_px - 1
    lacking = {Rejection.OTHER_CHANGE_NOT_RECORDED}
    assert of_others(beside(kind, enough, enough, 9.0)) == set()
    assert of_others(beside(kind, too_few, enough, 9.0)) == (lacking if in_first else set())
    assert of_others(beside(kind, enough, too_few, 9.0)) == (lacking if in_second else set())


def test_another_change_may_be_as_near_as_the_settings_say_and_no_nearer() -> None:
    px, apart_m = ADMISSIBILITY.min_mask_px, CANDIDATES.apart_m
    assert of_others(beside("displace", px, px, apart_m)) == set()
    assert of_others(beside("displace", px, px, float(np.nextafter(apart_m, 0.0)))) == {Rejection.OTHER_CHANGE_NEAR}


def two_movers(apart_m: float, px: int, movers: int = 2) -> Trial:
    """A trial whose mover the second tour records at two places so far apart; another instance moves beside it."""
    trial = admitted(Relation.MOVING)
    assert trial.measured.sightings is not None
    target, elsewhere = trial.candidate.target, Roam.over(9.0, 0.0, 0.25, [(0, 0)])
    also = Alteration(kind="motion", instance="other|1", roam=elsewhere)
    candidate = trial.candidate.model_copy(update={"second": (*trial.candidate.second, also)[:movers]})
    kept = [seen for seen in trial.measured.sightings.second if seen.instance != target]
    least = ADMISSIBILITY.min_mask_px
    seen = [
        Sighting(view=view, instance=target, px=size, x=x, z=0.0)
        for view, x, size in ((0, 0.0, least), (1, 0.5 * apart_m, least), (2, apart_m, px), (3, 0.0, least))
    ]
    return measured(
        trial.model_copy(update={"candidate": candidate}),
        sightings=trial.measured.sightings.model_copy(update={"second": (*kept, *seen)}),
    )


def test_one_of_several_movers_is_recorded_in_motion() -> None:
    """What the tour records of it spreads farther than the settings say; a mask that is too small records nothing."""
    least_m, px = ADMISSIBILITY.mover_spread_m, ADMISSIBILITY.min_mask_px
    more = float(np.nextafter(least_m, 1.0))
    assert Rejection.MOTION_NOT_RECORDED in reasons(two_movers(least_m, px), CONFIG)
    assert Rejection.MOTION_NOT_RECORDED not in reasons(two_movers(more, px), CONFIG)
    assert Rejection.MOTION_NOT_RECORDED in reasons(two_movers(more, px - 1), CONFIG)


# --- the verdict as a whole -----------------------------------------------------------------------


@pytest.mark.parametrize("ended", [Rejection.PLACEMENT_REFUSED, Rejection.NO_SPAWN, Rejection.SIMULATOR_ERROR])
def test_a_trial_that_was_refused_has_that_reason_alone(ended: Rejection) -> None:
    trial = measured(admitted(Relation.MOVED), ended=ended, spawn_free_moves=0, answer_to_navigable_m=None)
    assert verdict(trial, CONFIG).reasons == (ended,)


def test_a_trial_beyond_the_bounds_is_judged_as_far_as_it_was_measured() -> None:
    trial = admitted(Relation.MOVED)
    beyond = {"ended": Bound.BEYOND_MEASUREMENT, "sightings": None, "world_1": None, "world_2": None, "drift_m": None}
    assert judged(trial, **beyond, answer_to_navigable_m=9.0) == [Rejection.ANSWER_UNREACHABLE]
    assert judged(trial, **beyond) == []


def test_all_reasons_are_given_in_the_order_of_algorithm_1_and_the_first_counts() -> None:
    trial = admitted(Relation.MOVED)
    (changed,) = [a.instance for a in trial.candidate.second]
    wrong = measured(
        seen(trial, "first", 0),
        displacement_m={changed: 0.0},
        spawn_clearance_m={"before": 0.0},
        spawn_free_moves=0,
        answer_to_navigable_m=99.0,
        visible_px={0: 0},
        drift_m={changed: 9.0},
    )
    made = verdict(wrong, CONFIG)
    assert made.rejected is Rejection.DISPLACEMENT_BELOW_MINIMUM is made.reasons[0] and len(made.reasons) >= 7
    assert list(made.reasons) == sorted(made.reasons, key=list(Rejection).index)
    assert (made.id, made.relation) == (trial.candidate.id, Relation.MOVED)


# --- certification --------------------------------------------------------------------------------


def failing(runs: tuple[OracleRun, ...], *indices: int) -> list[OracleRun]:
    return [r.model_copy(update={"outcome": "budget"}) if i in indices else r for i, r in enumerate(runs)]


@pytest.mark.parametrize("relation", RELATIONS)
def test_every_run_has_to_succeed_and_the_first_is_the_feasibility(relation: Relation) -> None:
    trial = admitted(relation)
    runs, admissible = RUNS[trial.candidate.id], verdict(trial, CONFIG)
    assert rejection(admissible, runs, SUCCESS) is None
    assert rejection(admissible, failing(runs, 0), SUCCESS) is Rejection.FEASIBILITY_FAILED
    for k in range(1, len(runs)):
        assert rejection(admissible, failing(runs, k), SUCCESS) is Rejection.CERTIFICATION_FAILED
    assert rejection(admissible, failing(runs, *range(len(runs))), SUCCESS) is Rejection.FEASIBILITY_FAILED


# --- the split ------------------------------------------------------------------------------------

POOLS = st.dictionaries(st.sampled_from("ABCDE"), st.integers(0, 6), min_size=1).map(
    lambda sizes: {scene: [f"{scene}/{k}" for k in range(size)] for scene, size in sizes.items()}
)


def selected(pool, wanted, seed, *turns):
    """The ids that are selected: enough or all, none twice, and the order of scenes and ids is no matter."""
    chosen, again = (
        select_in_turn(given, wanted, np.random.default_rng(seed), *turns)
        for given in (pool, {scene: list(reversed(ids)) for scene, ids in reversed(pool.items())})
    )
    assert chosen == again and len({*chosen}) == len(chosen) == min(wanted, sum(map(len, pool.values())))
    return chosen


def instances_of(pool, number):
    """Which instance each id asks about, so many of each scene."""
    return {k: f"{scene}|{int(k.split('/')[1]) % number}" for scene, ids in pool.items() for k in ids}


@given(POOLS, st.integers(0, 25), st.integers(0, 99))
def test_the_split_takes_turns_among_the_scenes(pool, wanted, seed):
    """No scene gives two more than another with ids left."""
    count = Counter(k[0] for k in selected(pool, wanted, seed))
    assert all(max(count.values(), default=0) <= count[scene] + 1 for scene, ids in pool.items() if count[scene] < len(ids))


@given(POOLS, st.integers(0, 25), st.integers(0, 99), st.integers(1, 4))
def test_instances_take_turns(pool, wanted, seed, instances):
    """No instance is asked about twice before each is asked about once, and so on."""
    instance_of = instances_of(pool, instances)
    chosen = selected(pool, wanted, seed, instance_of)
    there, asked = Counter(instance_of.values()), Counter(instance_of[k] for k in chosen)
    assert all(max(asked.values(), default=0) <= asked[k] + 1 for k, number in there.items() if asked[k] < number)
    uses = [sum(instance_of[k] == instance_of[before] for before in chosen[:at]) for at, k in enumerate(chosen)]
    assert uses == sorted(uses)


@given(POOLS, st.integers(0, 99), st.integers(1, 4), st.randoms(use_true_random=False))
def test_sizes_take_turns(pool, seed, instances, random):
    """Instances take turns as ever. Of one use, the largest are within one of chance while there are both."""
    ids = [k for each in pool.values() for k in each]
    instance_of = instances_of(pool, instances)
    size_of = {k: Size(random.random() < 0.6, random.randint(2, 4)) for k in sorted(ids)}
    chosen, plain = (selected(pool, len(ids), seed, instance_of, *sizes) for sizes in ((size_of,), ()))
    uses = {k: sum(instance_of[k] == instance_of[before] for before in plain[:at]) for at, k in enumerate(plain)}
    assert [uses[k] for k in chosen] == [uses[k] for k in plain]
    for number in set(uses.values()):
        one = [k for k in chosen if uses[k] == number]
        before = [k for k in chosen if uses[k] < number]
        for at in range(1, len(one)):
            if len({size_of[k].largest for k in one[at - 1 :]}) == 2 and not before:
                excess = sum(size_of[k].largest - 1 / size_of[k].among for k in one[:at])
                assert abs(excess) <= 1
    same = dict.fromkeys(ids, Size(True, 1))
    assert selected(pool, len(ids), seed, instance_of, same) == plain


# --- the release -----------------------------------------------------------------------------------


def write_split(folder: Path, allow_short_split: bool = False, **wanted: int) -> int:
    """Release a split main of so many episodes of each relation, and of none where it is not named; return how many there are."""
    asked = CONFIG.splits[MAIN].episodes.model_copy(update={r.value: wanted.get(r.value, 0) for r in Relation})
    benchmark = CONFIG.benchmark.model_copy(update={"allow_short_split": allow_short_split})
    splits = {MAIN: CONFIG.splits[MAIN].model_copy(update={"episodes": asked})}
    of_split = [trial for trial in TRIALS.values() if trial.candidate.split == MAIN]
    trials, verdicts = folder / "trials.jsonl", folder / "verdicts.jsonl"
    trials.write_text(lines(of_split))
    verdicts.write_text(lines(verdict(trial, CONFIG) for trial in of_split))
    settings = CONFIG.model_copy(update={"benchmark": benchmark, "splits": splits})
    outputs = [folder / name for name in ("main.jsonl", "sightings.jsonl", "rejections.csv")]
    run(trials, verdicts, DATA / "certified" / "main.jsonl", settings, *outputs)
    return len(outputs[0].read_text().splitlines())


def test_a_split_takes_all_that_is_certified_and_an_error_names_each_relation_that_falls_short(tmp_path: Path) -> None:
    of_split = {k: t for k, t in TRIALS.items() if k in RUNS and t.candidate.split == MAIN}
    admitted = {k: t for k, t in of_split.items() if verdict(t, CONFIG).rejected is None}
    certified = {r: sum(t.candidate.relation is r for t in admitted.values()) for r in Relation}
    moved, stable = certified[Relation.MOVED], certified[Relation.STABLE]
    assert write_split(tmp_path, moved=moved, stable=stable) == moved + stable
    lack = rf"moved {moved} of {moved + 1}, stable {stable} of {stable + 9}"
    says = (
        rf"^splits\.main\.episodes asks for more .* \({lack}\); raise splits\.main\.draws, lower splits\.main\.episodes, or set"
    )
    with pytest.raises(ShortSplitError, match=says):
        write_split(tmp_path, moved=moved + 1, stable=stable + 9)
    assert write_split(tmp_path, allow_short_split=True, moved=moved + 1, stable=stable + 9) == moved + stable

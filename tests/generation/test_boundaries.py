"""Verdicts and the release on their thresholds. Released trials are changed in one measurement at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.crossed import limit
from ovman.generation.release import ShortSplitError, rejection, run
from ovman.generation.selection import select_crossed, select_in_turn
from ovman.generation.verdict import reasons, verdict
from ovman.records.geometry import Position
from ovman.records.record import lines
from ovman.records.scene import Alteration, Roam
from ovman.records.task import Instance, Query, Rejection, Relation, WorldState
from ovman.records.trial import Bound, Certification, Displaced, OracleRun, Trial
from ovman.records.visit import Sighting, VisitPair
from ovman.settings import MAIN
from tests.arms import CONFIG
from tests.episodes import DATA

SCENES = ("FloorPlan1", "FloorPlan201", "FloorPlan429")
ADMISSIBILITY, CANDIDATES, SUCCESS = CONFIG.admissibility, CONFIG.candidates, CONFIG.success
BELOW, ABOVE = 0.9999, 1.0001
TRIALS = {one.candidate.id: one for one in Trial.read(DATA / "trials" / "main.jsonl") if one.candidate.scene in SCENES}
RUNS = {one.id: one.runs for one in Certification.read(DATA / "certified" / "main.jsonl") if one.id in TRIALS}
RELATIONS = list(Relation)


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
    radius_m, tolerance_m = ADMISSIBILITY.validity_radius_m, ADMISSIBILITY.drift_tolerance_m
    hidden = [Rejection.ANSWER_NOT_VISIBLE] if relation.current else []
    cases: list[tuple[str, Any, list[Rejection]]] = [
        ("spawn_clearance_m", {"before": clearance_m, "after": clearance_m}, []),
        ("spawn_clearance_m", {"before": BELOW * clearance_m, "after": 9.0}, [Rejection.SPAWN_TOO_CLOSE]),
        ("spawn_clearance_m", {"before": 9.0, "after": BELOW * clearance_m}, [Rejection.SPAWN_TOO_CLOSE]),
        ("spawn_clearance_m", None, []),
        ("spawn_free_moves", 0, [Rejection.SPAWN_IMMOBILE]),
        ("spawn_free_moves", 1, []),
        ("spawn_free_moves", None, []),
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
    assert list(reasons(less, CONFIG)) == []
    assert list(reasons(more, CONFIG)) == [Rejection.BYSTANDER_MOVED]


@pytest.mark.parametrize("relation", [relation for relation in RELATIONS if relation is not Relation.STABLE])
def test_the_referent_is_the_scripted_target(relation: Relation) -> None:
    trial = admitted(relation)
    candidate = trial.candidate.model_copy(update={"target": other(trial).id})
    against = set(reasons(trial.model_copy(update={"candidate": candidate}), CONFIG))
    # The other instance stands still, so the tour records no motion of it.
    still = {Rejection.MOTION_NOT_RECORDED} if relation is Relation.MOVING else set()
    assert against == {Rejection.REFERENT_NOT_TARGET} | still


# --- world pairs ----------------------------------------------------------------------------------


def paired(relation: Relation) -> Trial:
    """An admissible trial of main as one of a world pair, with the answer and its cell at the origin and no rivals."""
    trial = admitted(relation)
    candidate = trial.candidate
    return measured(
        trial.model_copy(update={"candidate": candidate.model_copy(update={"pair": "a pair", "split": "everyday"})}),
        answer=(0.0, 0.0),
        nearest_navigable=(0.0, 0.0),
        world_1=WorldState(()),
        world_2=WorldState(()),
        changed={},
    )


def with_rival(trial: Trial, visit: str, at: float, same_category: bool) -> Trial:
    """The trial with a rival at (at, 0) in a visit: an instance of the category, or a change of another one."""
    if same_category:
        world = "world_1" if visit == "before" else "world_2"
        return measured(trial, **{world: WorldState((Instance("Stranger|1", trial.candidate.category, at, 0.0),))})
    places = {"before": None, "after": None} | {visit: Position(x=at, y=0.0, z=0.0)}
    return measured(trial, changed={"Stranger|1": Displaced(**places)})


@pytest.mark.parametrize("same_category", [True, False])
@pytest.mark.parametrize("visit", ["before", "after"])
@pytest.mark.parametrize("relation", RELATIONS)
def test_a_rival_may_be_as_near_as_the_settings_say_and_no_nearer(relation: Relation, visit: str, same_category: bool) -> None:
    terms = CONFIG.splits["everyday"].crossed
    assert terms is not None
    for at, near in ((terms.apart_m, False), (float(np.nextafter(terms.apart_m, 0.0)), True)):
        against = set(reasons(with_rival(paired(relation), visit, at, same_category), CONFIG))
        assert (Rejection.RIVAL_NEAR in against) is near


@pytest.mark.parametrize("name", ["answer", "nearest_navigable"])
def test_no_spawn_of_a_world_pair_is_where_a_stop_would_succeed(name: str) -> None:
    trial, radius_m = paired(Relation.REMOVED), SUCCESS.radius_m
    spawn = trial.candidate.spawn
    assert spawn is not None
    for metres, near in ((radius_m - 1e-6, True), (ABOVE * radius_m, False)):
        against = judged(
            measured(trial, answer=(99.0, 0.0), nearest_navigable=(99.0, 0.0)), **{name: (spawn.x, spawn.z + metres)}
        )
        assert (Rejection.SPAWN_AT_ANSWER in against) is near


def test_the_cell_of_an_answer_is_nearer_to_it_than_to_every_rival() -> None:
    """Exclusive success: a stop at that cell succeeds."""
    trial = measured(paired(Relation.REMOVED), nearest_navigable=(0.75, 0.0))
    for at, near in ((1.5, True), (float(np.nextafter(1.5, 2.0)), False)):
        against = set(reasons(with_rival(trial, "after", at, same_category=False), CONFIG))
        assert (Rejection.RIVAL_NEAR in against) is near


@pytest.mark.parametrize("relation", RELATIONS)
def test_the_visit_that_a_relation_reads_shows_two_instances_with_masks_of_the_minimum(relation: Relation) -> None:
    trial, enough = paired(relation), ADMISSIBILITY.min_mask_px
    read, other = ("first", "second") if relation.past else ("second", "first")

    def shown(*px: int) -> Trial:
        seen = tuple(Sighting(view=0, instance=f"Chair|{k}", px=size, x=0.0, z=float(k)) for k, size in enumerate(px))
        return measured(trial, sightings=VisitPair[tuple[Sighting, ...]](**{read: seen, other: ()}))

    assert Rejection.FEW_RECORDED not in reasons(shown(enough, enough), CONFIG)
    assert Rejection.FEW_RECORDED in reasons(shown(enough, enough - 1), CONFIG)
    alone = shown(enough).candidate.model_copy(update={"pair": None})
    assert Rejection.FEW_RECORDED not in reasons(shown(enough).model_copy(update={"candidate": alone}), CONFIG)


# --- movers ---------------------------------------------------------------------------------------


def with_mover(apart_m: float, px: int, movers: int) -> Trial:
    """Return a trial whose target is recorded at places up to `apart_m` apart; a second mover is another instance."""
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


@pytest.mark.parametrize("movers", [1, 2])
def test_a_mover_is_recorded_in_motion(movers: int) -> None:
    """What the tour records of it spreads farther than the settings say; a mask that is too small records nothing."""
    least_m, px = ADMISSIBILITY.mover_spread_m, ADMISSIBILITY.min_mask_px
    more = float(np.nextafter(least_m, 1.0))
    assert Rejection.MOTION_NOT_RECORDED in reasons(with_mover(least_m, px, movers), CONFIG)
    assert Rejection.MOTION_NOT_RECORDED not in reasons(with_mover(more, px, movers), CONFIG)
    assert Rejection.MOTION_NOT_RECORDED in reasons(with_mover(more, px - 1, movers), CONFIG)


@pytest.mark.parametrize("relation", [relation for relation in RELATIONS if relation is not Relation.MOVING])
def test_only_queries_about_a_mover_need_its_motion(relation: Relation) -> None:
    trial = admitted(relation)
    also = tuple(Alteration(kind="motion", instance=k, roam=Roam.over(9.0, 0.0, 0.25, [(0, 0)])) for k in ("other|1", "other|2"))
    candidate = trial.candidate.model_copy(
        update={"second": (*trial.candidate.second, *also), "others": dict.fromkeys(("other|1", "other|2"), "Other")}
    )
    assert list(reasons(trial.model_copy(update={"candidate": candidate}), CONFIG)) == []


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


@given(POOLS, st.integers(0, 25), st.integers(0, 99))
def test_the_split_takes_turns_among_the_scenes(pool, wanted, seed):
    """Enough or all, none twice; no scene gives two more than another with ids left; the order of scenes and ids is no matter."""
    chosen, again = (
        select_in_turn(given, wanted, np.random.default_rng(seed))
        for given in (pool, {scene: list(reversed(ids)) for scene, ids in reversed(pool.items())})
    )
    assert chosen == again and len({*chosen}) == len(chosen) == min(wanted, sum(map(len, pool.values())))
    count = Counter(k[0] for k in chosen)
    assert all(max(count.values(), default=0) <= count[scene] + 1 for scene, ids in pool.items() if count[scene] < len(ids))


GRID = [Query(noun, relation) for noun in ("Chair", "Stool") for relation in (Relation.MOVED, Relation.FORMER, Relation.REMOVED)]
"""Six queries: each relation of two nouns, each noun under three relations."""


def name_of(pair: str, query: Query) -> str:
    return f"{pair}/{query.category}/{query.relation}"


def certified(pair: str, queries: Iterable[Query]) -> list[Trial]:
    """Trials of a world pair with these queries."""
    trial = admitted(Relation.REMOVED)
    return [
        trial.model_copy(
            update={
                "candidate": trial.candidate.model_copy(
                    update={"id": name_of(pair, query), "pair": pair, "category": query.category, "relation": query.relation}
                )
            }
        )
        for query in queries
    ]


def test_a_pair_needs_the_fewest_queries_and_each_query_needs_others() -> None:
    whole, lacking = certified("a", GRID), certified("b", GRID[1:])
    assert select_crossed(whole + lacking, 6, 8) == [name_of("a", query) for query in GRID]
    assert select_crossed(whole, 7, 8) == []
    left = [name_of("b", query) for query in GRID if query.relation is not GRID[0].relation]
    assert select_crossed(lacking, 4, 8) == left and len(left) == 4
    assert select_crossed(lacking, 5, 8) == []


@given(st.permutations(GRID), st.permutations(GRID), st.integers(4, 6))
def test_pairs_are_limited_apart_and_in_any_order(queries, others, most):
    mixed = [trial for two in zip(certified("a", queries), certified("b", others), strict=True) for trial in two]
    assert set(select_crossed(mixed, 4, most)) == {name_of(pair, query) for pair in "ab" for query in limit(GRID, most)}


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

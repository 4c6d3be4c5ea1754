import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.settings.benchmark import FLOOR_PLANS
from training.floorplans import floor_plans, home_names, load_place


@given(st.sets(st.sampled_from(FLOOR_PLANS), max_size=100))
def test_no_floor_plan_of_the_benchmark_is_learned_from_or_looked_at(benchmark):
    plans = floor_plans(benchmark)
    assert not benchmark & {*plans.taught, *plans.held_out}
    assert not {*plans.taught} & {*plans.held_out}
    assert len(plans.taught) + len(plans.held_out) + len(benchmark) == len(FLOOR_PLANS)


def test_every_kind_of_room_is_held_out_and_a_benchmark_of_all_leaves_none():
    kinds = {name.removeprefix("FloorPlan")[:-2] or "0" for name in floor_plans([]).held_out}
    assert kinds >= {"2", "3", "4"} and any(len(name) <= len("FloorPlan30") for name in floor_plans([]).held_out)
    with pytest.raises(ValueError, match="leaves none for training"):
        floor_plans(FLOOR_PLANS)


def test_homes_are_named_by_their_assets_and_their_seed():
    assert home_names("val", 2) == ("home-val-0", "home-val-1") and load_place("FloorPlan6") == "FloorPlan6"
    house = load_place("home-train-1")
    assert len(house["rooms"]) == 2 and house == load_place("home-train-1")

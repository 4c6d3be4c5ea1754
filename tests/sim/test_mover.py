"""The mover stays on its lane, never enters the agent, and its path is its seed's."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.models.change import Lane
from ovman.models.settings.benchmark import Mover as MoverParams
from ovman.sim.mover import Mover

PARAMS = MoverParams(step_m=0.1, lane_min_m=2.0, pause_probability=0.1, turn_probability=0.04)
coordinate = st.floats(-5, 5)
lanes = st.builds(Lane, x_0=coordinate, z_0=coordinate, x_1=coordinate, z_1=coordinate).filter(lambda lane: lane.length_m > 0.5)
FAR = (100.0, 100.0)


def walk(lane: Lane, seed: int, steps: int, agent: tuple[float, float] = FAR, params: MoverParams = PARAMS) -> list[Mover]:
    rng, mover = np.random.default_rng(seed), Mover(lane)
    movers = [mover]
    for _ in range(steps):
        mover = mover.advance(params, rng, agent, 0.5)
        movers.append(mover)
    return movers


@settings(derandomize=True, max_examples=50, deadline=None)
@given(lanes, st.integers(0, 1000))
def test_a_mover_stays_on_its_lane_and_takes_steps_of_one_length(lane, seed):
    movers = walk(lane, seed, 60)
    assert all(0.0 <= m.along_m <= lane.length_m for m in movers)
    steps = np.hypot(*np.diff([m.position for m in movers], axis=0).T)
    assert steps.max() <= PARAMS.step_m + 1e-9
    assert (steps > 0.5 * PARAMS.step_m).sum() > 20


@settings(derandomize=True, max_examples=50, deadline=None)
@given(lanes, st.integers(0, 1000), st.floats(0, 1))
def test_a_mover_never_comes_closer_to_an_agent_that_is_in_its_way(lane, seed, share):
    agent = lane.at(share * lane.length_m)
    gaps = [np.hypot(m.position[0] - agent[0], m.position[1] - agent[1]) for m in walk(lane, seed, 60, agent)]
    assert min(gaps) >= min(0.5, gaps[0]) - 1e-9


def test_the_same_seed_gives_the_same_path_and_another_seed_another():
    lane = Lane(x_0=0.0, z_0=0.0, x_1=3.0, z_1=0.0)
    assert walk(lane, 1, 40) == walk(lane, 1, 40)
    assert walk(lane, 1, 40) != walk(lane, 2, 40)


def test_without_chance_it_goes_to_the_end_and_comes_back():
    steady = MoverParams(step_m=0.1, lane_min_m=2.0, pause_probability=0.0, turn_probability=0.0)
    path = [m.along_m for m in walk(Lane(x_0=0.0, z_0=0.0, x_1=1.0, z_1=0.0), 0, 20, params=steady)]
    assert np.allclose(path, [*np.arange(11) / 10, *np.arange(9, -1, -1) / 10], atol=1e-9)


@settings(derandomize=True, max_examples=50, deadline=None)
@given(lanes, st.floats(0, 1))
def test_along_is_the_inverse_of_at(lane, share):
    assert abs(lane.along(*lane.at(share * lane.length_m)) - share * lane.length_m) < 1e-6

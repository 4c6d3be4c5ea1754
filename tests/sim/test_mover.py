"""The mover walks on free floor alone, one step an action, never into the agent, and its walk is its seed's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.navigation.grid import Grid
from ovman.records.scene import MoverStart, Roam
from ovman.settings.benchmark import Mover as MoverParams
from ovman.sim.world import WAYS, Mover, walk

PARAMS = MoverParams(step_m=0.1, pause_probability=0.1, turn_probability=0.1)


def connected(found: set[tuple[int, int]]) -> frozenset[tuple[int, int]]:
    """Return the cells of a set that (0, 0) is connected to."""
    return Grid(0.1, (0.0, 0.0), frozenset(found | {(0, 0)})).component((0, 0))


cells = st.sets(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), max_size=60).map(connected)
roams = st.builds(lambda x, z, found: Roam.over(x, z, 0.1, found), st.floats(-5, 5), st.floats(-5, 5), cells)
seeds = st.integers(0, 1000)


def walked(roam: Roam, seed: int, steps: int, params: MoverParams = PARAMS) -> list[Mover]:
    rng = np.random.default_rng(seed)
    begun = Mover.setting_off(roam, rng)
    return [begun, *walk(begun, params, rng, steps)]


@given(roams, seeds)
def test_a_mover_begins_where_it_stands_never_leaves_its_floor_and_takes_one_step_an_action(roam, seed):
    movers = walked(roam, seed, 60)
    assert movers[0].position == (round(roam.x, 4), round(roam.z, 4))
    assert {mover.cell for mover in movers} <= roam.cells
    for before, after in zip(movers, movers[1:], strict=False):
        step = after.cell[0] - before.cell[0], after.cell[1] - before.cell[1]
        assert step == (0, 0) or step == WAYS[after.heading_deg]
        assert math.dist(before.position, after.position) <= roam.step_m + 2e-4
    assert len(roam.cells) == 1 or len({mover.cell for mover in movers}) > 1


@given(roams, seeds, st.integers(0, 40))
def test_a_walk_goes_on_from_its_recorded_state_as_if_it_had_not_been_interrupted(roam, seed, pause_at):
    """The state is all that the walk depends on, beside what is drawn; records round it and lose nothing."""
    whole = walked(roam, seed, 60)
    rng = np.random.default_rng(seed)
    begun = Mover.setting_off(roam, rng)
    *_, left = [begun, *walk(begun, PARAMS, rng, pause_at)]
    start = MoverStart(instance="a", position=left.position, heading_deg=left.heading_deg)
    start = MoverStart.from_json(start.to_json())
    again = Mover(Roam.from_json(roam.to_json())).resumed(start)
    positions = [mover.position for mover in walk(again, PARAMS, rng, 60 - pause_at)]
    assert np.allclose(positions, [mover.position for mover in whole[pause_at + 1 :]], atol=1.1e-4) or pause_at == 60


@given(roams, seeds, st.data())
def test_a_mover_never_comes_closer_to_an_agent_that_is_in_its_way(roam, seed, data):
    agent = roam.at(data.draw(st.sampled_from(sorted(roam.cells))))
    rng = np.random.default_rng(seed)
    mover = Mover.setting_off(roam, rng)
    gaps = [math.dist(mover.position, agent)]
    for _ in range(60):
        mover = mover.advance(PARAMS, rng, agent, 0.25)
        gaps.append(math.dist(mover.position, agent))
        assert gaps[-1] >= min(0.25, gaps[-2]) - 1e-9


def test_how_often_it_pauses_and_turns_is_what_the_settings_say():
    wide = Roam.over(0.0, 0.0, 0.1, [(column, row) for column in range(-300, 301) for row in range(-300, 301)])
    params = MoverParams(step_m=0.1, pause_probability=0.2, turn_probability=0.3)
    movers = walked(wide, 0, 3000, params)
    stood = [after.cell == before.cell for before, after in zip(movers, movers[1:], strict=False)]
    turned = [after.heading_deg != before.heading_deg for before, after in zip(movers, movers[1:], strict=False)]
    assert np.mean(stood) == pytest.approx(0.2, abs=0.03)
    assert np.mean(turned) == pytest.approx(0.8 * 0.3, abs=0.03)


def test_a_floor_without_where_the_instance_stands_and_a_state_off_the_floor_are_refused():
    with pytest.raises(ValueError, match=r"no \(0, 0\)"):
        Roam(x=0.0, z=0.0, step_m=0.1, rows=((1, 0, 3),))
    with pytest.raises(ValueError, match="off the floor"):
        Mover(Roam.over(0.0, 0.0, 0.1, [(0, 0)])).resumed(MoverStart(instance="a", position=(0.3, 0.0), heading_deg=0))

"""Dense walks through the real Controller and engine: the recorded visit again, with what lies between its views."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.placement import FreeFloor
from ovman.generation.roaming import roam
from ovman.navigation.grid import Grid, farthest_points
from ovman.records.scene import Alteration
from ovman.records.tour import Tour
from ovman.records.visit import Visit
from ovman.settings.benchmark import Mover
from ovman.sim import visit, walk
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import World
from tests.arms import CONFIG
from tests.episodes import scene_record
from tests.tour_zips import picture

SCENE = "FloorPlan7"
PARAMS = Mover(step_m=0.1, pause_probability=0.2, turn_probability=0.2)
SIDE_PX, TURN_DEG, STEP_M, LENS_DEG = 96, 30.0, 0.25, 90.0
HEADINGS = 4


def apart_deg(a: float, b: float) -> float:
    return abs((a - b + 180.0) % 360.0 - 180.0)


cells = st.sets(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=2, max_size=49)


@given(cells, st.data())
def test_a_way_leads_over_neighbouring_cells_and_looks_where_it_goes(found, data):
    grid = Grid(STEP_M, (0.1, -0.05), frozenset(found))
    start, goal = (data.draw(st.sampled_from(sorted(found))) for _ in range(2))
    here, there = AgentPose(*grid.centre(start), 90.0), AgentPose(*grid.centre(goal), 0.0)
    poses = walk.way(grid, here, there)
    if goal not in grid.component(start):
        assert poses == []
        return
    at = [start, *(grid.cell_at(pose.x, pose.z) for pose in poses), goal]
    assert set(at) <= found
    if start != goal:
        assert all(abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1 for a, b in zip(at, at[1:], strict=False))
    for before, pose in zip([here, *poses], poses, strict=False):
        assert apart_deg(pose.yaw_deg, math.degrees(math.atan2(pose.x - before.x, pose.z - before.z))) < 0.1


@given(st.floats(0, 359), st.floats(0, 359), st.sampled_from([10.0, 30.0, 45.0, 77.0]))
def test_a_spin_goes_right_by_equal_turns_and_leaves_out_both_ends(here_deg, there_deg, turn_deg):
    poses = walk.spin(AgentPose(1.0, 2.0, here_deg), there_deg, turn_deg)
    yaws = [here_deg, *(pose.yaw_deg for pose in poses), there_deg]
    gone = [(b - a) % 360.0 for a, b in zip(yaws, yaws[1:], strict=False)]
    assert gone[:-1] == pytest.approx([turn_deg] * (len(gone) - 1))
    last = gone[-1] or 360.0
    assert last <= turn_deg + 2 * walk.SAME_DEG or not poses and last > 360 - 2 * walk.SAME_DEG
    assert {(pose.x, pose.z) for pose in poses} <= {(1.0, 2.0)}


@pytest.fixture(scope="module")
def session():
    with Session(SCENE, CONFIG, replace(Embodiment.of(CONFIG), width_px=SIDE_PX, height_px=SIDE_PX)) as session:
        yield session


@pytest.fixture(scope="module")
def ground(session):
    session.reset()
    grid = Grid.from_positions(session.reachable(), STEP_M)
    return grid, grid.nearest(session.pose.x, session.pose.z)


@pytest.fixture(scope="module")
def views(ground):
    grid, start = ground
    waypoints = [grid.centre(cell) for cell in farthest_points(grid, grid.component(start), 2, start)]
    return visit.views(Tour(waypoints=tuple((round(x, 4), round(z, 4)) for x, z in waypoints), headings=HEADINGS))


@pytest.fixture(scope="module")
def moving(views):
    """The first instance that can move from where it stands, over its free floor."""
    scene = scene_record(SCENE).model_copy(update={"waypoints": tuple({(pose.x, pose.z): None for pose in views})})
    for item in scene.objects:
        found = roam(scene, item, FreeFloor.of(scene, item, STEP_M, scene.waypoints), PARAMS.step_m) if item.moveable else None
        if found is not None:
            return [Alteration(kind="motion", instance=item.id, roam=found)]
    raise AssertionError("nothing in the scene can move")


def world(session, alterations) -> World:
    return World(session, alterations, PARAMS, np.random.default_rng(3))


@pytest.fixture(scope="module")
def recorded(session, views, moving, tmp_path_factory):
    directory = tmp_path_factory.mktemp("visits") / "moving"
    visit.record(session, world(session, moving), "moving", moving, views, 50, directory, "key")
    return directory


@pytest.fixture(scope="module")
def walked(session, views, moving, recorded):
    """The frames of the walk, and where the mover was and how often it had stepped at each of them."""
    there = world(session, moving)
    frames, clock = [], []
    for frame in walk.frames(session, there, views, TURN_DEG, STEP_M, LENS_DEG):
        frames.append(frame)
        ((name, path),) = there.paths.items()
        clock.append((len(path), there.movers[name]))
    walk.check(session, there, Visit.load(recorded))
    return frames, clock


def test_a_walk_passes_the_views_of_the_tour_in_order_and_shows_what_the_visit_recorded(walked, views, recorded):
    frames, _ = walked
    passed = [frame for frame in frames if frame.view is not None]
    assert [frame.view for frame in passed] == list(range(len(views)))
    assert [frame.pose for frame in passed] == views
    cameras = [view.camera for view in Visit.load(recorded).views]
    for frame, camera in zip(passed, cameras, strict=True):
        rgb, depth = picture(recorded, f"{frame.view:02d}_rgb.png")[..., ::-1], picture(recorded, f"{frame.view:02d}_depth.png")
        assert np.array_equal(frame.rgb, rgb)
        assert np.array_equal(np.round(frame.depth * visit.MILLIMETRES), depth)
        assert frame.camera.position == pytest.approx((camera.x, camera.y, camera.z), abs=1e-4)


def test_world_time_passes_at_the_views_of_the_tour_alone(walked):
    frames, clock = walked
    steps, mover = 1, clock[0][1]
    assert len({where for _, where in clock}) > 3
    for frame, (path, now) in zip(frames, clock, strict=True):
        steps += frame.view is not None
        assert path == steps
        assert frame.view is not None or now == mover
        mover = now


def test_a_walk_turns_around_at_its_waypoints_and_steps_over_cells_between(walked, views, ground):
    (frames, _), (grid, _) = walked, ground
    at = {(view.x, view.z) for view in views}
    for x, z in at:
        yaws = {round(frame.pose.yaw_deg, 2) % 360 for frame in frames if (frame.pose.x, frame.pose.z) == (x, z)}
        assert {30.0 * k for k in range(12)} <= yaws
    for before, after in zip(frames, frames[1:], strict=False):
        step = math.hypot(after.pose.x - before.pose.x, after.pose.z - before.pose.z)
        turn = apart_deg(after.pose.yaw_deg, before.pose.yaw_deg)
        assert (step == 0 and 0 < turn <= TURN_DEG + 1e-6) or step == pytest.approx(STEP_M, abs=1e-3)
    for frame in frames:
        cell = grid.cell_at(frame.pose.x, frame.pose.z)
        assert cell is not None and grid.centre(cell) == pytest.approx((frame.pose.x, frame.pose.z), abs=1e-3)
    assert any((frame.pose.x, frame.pose.z) not in at for frame in frames)


def test_a_walk_that_ends_otherwise_than_its_visit_is_refused(session, views, moving, recorded, walked):
    there = world(session, moving)
    list(walk.frames(session, there, views[:2], TURN_DEG, STEP_M, LENS_DEG))
    with pytest.raises(walk.WalkError, match="moving left the mover .* at .* record the visits again"):
        walk.check(session, there, Visit.load(recorded))
    unmoved = Visit.load(recorded).model_copy(update={"movers": ()})
    with pytest.raises(walk.WalkError, match=f"{re.escape(next(iter(there.movers)))}.* record the visits again"):
        walk.check(session, there, unmoved)

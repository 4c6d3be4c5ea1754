"""Tours off the grid: rounding restores no pose, the views are free in the simulator, and the paper's tours are as they were."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.generation.drawing import Drawing, places_of_agent, tours
from ovman.generation.off_grid import TURN_DEG
from ovman.records.record import RecordError
from ovman.records.tour import Sensors, Tour
from ovman.settings.benchmark import Errors
from ovman.sim.sensing import Sensing
from ovman.sim.session import Session
from ovman.sim.visit import views
from tests.arms import CONFIG
from tests.episodes import scene_record

SCENES = ("FloorPlan227", "FloorPlan10", "FloorPlan429")
OFF = CONFIG.splits["everyday"]
ON = OFF.model_copy(update={"off_grid": False})
GOOD = CONFIG.sensors.good


def both(scene: str, split=OFF) -> tuple[Tour, Tour]:
    found = Drawing.of(split, scene_record(scene), CONFIG).tours
    return found.first, found.second


def restored(tour: Tour, errors: Errors) -> float:
    """The share of the poses that rounding to the grid and to quarters of a turn (from the first yaw) brings back exactly."""
    sensing, found = Sensing(Sensors(errors=errors, seed=1)), []
    base = tour.first_yaw_deg % 90.0
    for pose in views(tour):
        seen = sensing.pose(pose)
        x, z = (round(value / 0.25) * 0.25 for value in (seen.x, seen.z))
        yaw = (round((seen.yaw_deg - base) / 90.0) * 90.0 + base) % 360.0
        found.append(abs(x - pose.x) < 1e-3 and abs(z - pose.z) < 1e-3 and abs((yaw - pose.yaw_deg + 180) % 360 - 180) < 0.05)
    return float(np.mean(found))


@pytest.mark.parametrize("scene", SCENES)
def test_rounding_undoes_the_errors_of_poses_on_the_grid_alone(scene):
    assert all(restored(tour, GOOD) > 0.9 for tour in both(scene, ON))
    assert all(restored(tour, GOOD) < 0.05 for tour in both(scene))


@pytest.mark.parametrize("scene", SCENES)
def test_every_view_is_free_in_the_simulator(scene):
    with Session(scene, CONFIG) as session:
        session.reset()
        for tour in both(scene):
            for pose in views(tour):
                assert session.teleport(pose, allowed=True).metadata["lastActionSuccess"], pose
                assert (session.pose.x, session.pose.z) == pytest.approx((pose.x, pose.z), abs=1e-4)
                assert session.pose.yaw_deg == pytest.approx(pose.yaw_deg, abs=1e-2)


@pytest.mark.parametrize("scene", SCENES)
def test_waypoints_stay_in_their_cells_and_views_near_their_spacing(scene):
    record = scene_record(scene)
    plain = tours(record, CONFIG.tour.headings, OFF.second_tour)
    for on, off in zip((plain.first, plain.second), both(scene), strict=True):
        gaps = np.abs(np.array(on.waypoints) - np.array(off.waypoints))
        assert gaps.max() <= 0.1251 and (gaps.max(axis=1) >= 0.0249).all()
        assert len(off.poses) == len(on.poses) and max(map(abs, off.turned_deg)) <= TURN_DEG
    assert set(both(scene)[1].waypoints) < set(places_of_agent(record, Drawing.of(OFF, record, CONFIG).tours))


def test_tours_follow_from_seed_split_and_scene():
    again, other = both(SCENES[0]), both(SCENES[0], OFF.model_copy(update={"name": "another"}))
    assert again == both(SCENES[0]) and again != other and again[0].waypoints != again[1].waypoints


def test_the_tours_of_the_paper_are_as_they_were():
    tour = tours(scene_record(SCENES[0]), 4, None).first
    assert "turned_deg" not in tour.to_json() and [pose.yaw_deg for pose in tour.poses[:4]] == [0.0, 90.0, 180.0, 270.0]
    with pytest.raises(RecordError, match="turned_deg has 1 angles; the tour has 24 views"):
        Tour.from_json(tour.to_json() | {"turned_deg": [1.0]})

"""Sensors that err as section `sensors` says, and light: what of a tour and a run they reach."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.interface import Action
from ovman.evaluation.recorded_tours import load_visit
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.records.tour import Light, Sensors
from ovman.settings.benchmark import Errors
from ovman.sim import visit
from ovman.sim.sensing import Sensing, placed
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import World
from tests.arms import CONFIG
from tests.episodes import of_scene
from tests.runs import run_agent
from tests.tour_zips import contents, picture

GOOD = CONFIG.sensors.good
EXACT = GOOD.model_copy(update={name: 0.0 for name in Errors.model_fields if name != "depth_nearest_m"})
SCENE = "FloorPlan16"
DIM = Light(brightness=0.6, hue=0.1, saturation=0.3)
CONDITIONS = {
    "exact": {},
    "errs": {"sensors": Sensors(errors=GOOD, seed=11)},
    "dim": {"light": DIM},
    "other materials": {"light": DIM.model_copy(update={"materials": 7})},
    "exact again": {},
}
poses = st.builds(
    AgentPose,
    st.floats(-5, 5).map(lambda v: round(v, 3)),
    st.floats(-5, 5).map(lambda v: round(v, 3)),
    st.integers(0, 359).map(float),
    st.sampled_from([0.0, 30.0]),
)


@given(st.lists(poses, min_size=1, max_size=8), st.integers(0, 2**31 - 1))
def test_sensors_without_errors_change_nothing(walked, seed):
    sensing = Sensing(Sensors(errors=EXACT, seed=seed))
    for pose in walked:
        assert close(sensing.pose(pose), pose, 1e-3)
    depth = np.linspace(0, 8, 12, dtype=np.float32).reshape(3, 4)
    assert np.allclose(sensing.depth(depth), depth, atol=1e-6)


def close(a: AgentPose, b: AgentPose, metres: float) -> bool:
    turned = (a.yaw_deg - b.yaw_deg + 180.0) % 360.0 - 180.0
    return math.hypot(a.x - b.x, a.z - b.z) <= metres and abs(turned) <= 0.02 and a.horizon_deg == b.horizon_deg


@given(st.lists(poses, min_size=1, max_size=8), st.integers(0, 2**31 - 1))
def test_the_same_seed_errs_alike_and_who_stands_still_errs_no_further(walked, seed):
    one, other = (Sensing(Sensors(errors=GOOD, seed=seed)) for _ in range(2))
    for pose in walked:
        sensed = one.pose(pose)
        one.depth(np.ones((2, 2), np.float32))  # what is looked at does not move the agent
        assert other.pose(pose) == sensed == one.pose(pose)
        assert 0 <= sensed.yaw_deg < 360


def test_poses_err_as_much_as_is_said():
    begun, ended = [], []
    for seed in range(600):
        sensing = Sensing(Sensors(errors=GOOD, seed=seed))
        first = sensing.pose(AgentPose(0.0, 0.0, 0.0))
        begun.append((first.x, first.z, (first.yaw_deg + 180.0) % 360.0 - 180.0))
        last = sensing.pose(AgentPose(0.0, 4.0, 0.0))
        ended.append((last.z - first.z - 4.0, (last.yaw_deg - first.yaw_deg + 180.0) % 360.0 - 180.0))
    spread = np.std(begun, axis=0)
    assert spread == pytest.approx([GOOD.pose_m, GOOD.pose_m, GOOD.pose_deg], rel=0.12)
    assert np.std(ended, axis=0) == pytest.approx([2 * GOOD.drift_m, 2 * GOOD.drift_deg], rel=0.15)


def test_what_is_turned_wrongly_bends_the_way_gone_after_it():
    sensing = Sensing(Sensors(errors=EXACT.model_copy(update={"pose_deg": 5.0}), seed=3))
    turned = math.radians(sensing.pose(AgentPose(0.0, 0.0, 0.0)).yaw_deg)
    sensed = sensing.pose(AgentPose(0.0, 2.0, 0.0))
    assert (sensed.x, sensed.z) == pytest.approx((2 * math.sin(turned), 2 * math.cos(turned)), abs=1e-3)


@pytest.mark.parametrize("metres", [0.4, 2.0, 6.0])
def test_depth_errs_with_the_square_of_the_distance(metres):
    true = np.full((300, 300), metres, np.float32)
    true[:10] = 0.0
    sensed = Sensing(Sensors(errors=GOOD, seed=5)).depth(true)
    assert sensed.dtype == np.float32 and (sensed[:10] == 0).all()
    errs = sensed[10:] - metres
    assert errs.std() == pytest.approx(0.0012 + 0.0019 * (metres - 0.4) ** 2, rel=0.03)
    assert abs(errs.mean()) < 0.05 * errs.std()


@given(poses, poses)
def test_a_camera_is_carried_where_the_agent_takes_itself_to_be(true, sensed):
    x, y, z = placed((true.x + 0.3, 1.6, true.z), true, sensed)
    assert y == 1.6 and math.hypot(x - sensed.x, z - sensed.z) == pytest.approx(0.3, abs=1e-3)


@pytest.fixture(scope="module")
def episode() -> Episode:
    return next(one for one in of_scene(SCENE) if one.relation is not Relation.MOVING)


@pytest.fixture(scope="module")
def session(episode):
    with Session(SCENE, episode.settings) as session:
        session.reset()
        yield session


@pytest.fixture(scope="module")
def tours(session, episode, tmp_path_factory) -> dict[str, Path]:
    """Tours of the second visit under other conditions, at the spawn."""
    directory, spawn, made = tmp_path_factory.mktemp("tours"), episode.spawn, {}
    views = [AgentPose(spawn.x, spawn.z, spawn.yaw_deg + turn) for turn in (0.0, 90.0)]
    alterations = episode.alterations("second")
    for name, conditions in CONDITIONS.items():
        world = World(session, alterations, episode.protocol.mover, np.random.default_rng(0))
        visit.record(session, world, "second", alterations, views, 50, directory / name, "", **conditions)
        made[name] = directory / name
    return made


def read(directory: Path, kind: str) -> list[np.ndarray]:
    return [picture(directory, name) for name in sorted(contents(directory)) if name.endswith(f"_{kind}.png")]


def test_truth_is_true_and_what_an_agent_is_given_is_sensed(tours):
    exact, errs = (visit.Visit.load(tours[name]) for name in ("exact", "errs"))
    for kind in ("ids", "rgb"):
        assert all(map(np.array_equal, read(tours["exact"], kind), read(tours["errs"], kind)))
    assert all((a != b).any() for a, b in zip(read(tours["exact"], "depth"), read(tours["errs"], "depth"), strict=True))
    assert [view.pose for view in exact.views] == [view.pose for view in errs.views]
    assert exact.positions == errs.positions
    given = load_visit(tours["errs"], 90.0, np.empty((0, 2))).observations
    for view, seen in zip(errs.views, given, strict=True):
        assert view.sensed is not None
        assert (seen.pose.x, seen.pose.z, seen.pose.yaw_deg) == (
            view.sensed.camera.x,
            view.sensed.camera.z,
            view.sensed.pose.yaw_deg,
        )
        assert (seen.pose.x, seen.pose.z) != (view.camera.x, view.camera.z)
    assert all(view.sensed is None for view in exact.views)


def test_another_light_changes_colours_and_neither_depth_nor_masks_and_is_gone_with_its_visit(tours):
    for kind in ("ids", "depth"):
        assert all(map(np.array_equal, read(tours["exact"], kind), read(tours["dim"], kind)))
    dim, usual = (np.mean(read(tours[name], "rgb")) for name in ("dim", "exact"))
    assert dim < 0.85 * usual
    pictures = {name: read(tours[name], "rgb")[0].tobytes() for name in CONDITIONS}
    assert pictures["exact"] == pictures["exact again"] and len({*pictures.values()}) == 3


class Onlooker:
    """Turns twice and stops; keeps what it saw."""

    def familiarise(self, visit):
        self.seen = []

    revisit = familiarise

    def ask(self, query):
        pass

    def act(self, observation):
        self.seen.append(observation)
        return Action.ROTATE_RIGHT if len(self.seen) < 3 else Action.STOP


def test_a_run_is_sensed_and_lit_as_its_tour_and_measured_truly(session, episode, tours):
    seen, measured = {}, []
    for name, conditions in CONDITIONS.items():
        agent = Onlooker()
        measured.append(run_agent(session, episode, agent, **conditions))
        seen[name] = agent.seen
        assert np.array_equal(agent.seen[0].rgb, read(tours[name], "rgb")[0][..., ::-1]), name
    assert all(one == measured[0] for one in measured)
    for exact, errs, dim in zip(seen["exact"], seen["errs"], seen["dim"], strict=True):
        assert exact.pose != errs.pose and (exact.depth != errs.depth).any() and (exact.rgb == errs.rgb).all()
        assert exact.pose == dim.pose and (exact.depth == dim.depth).all() and (exact.rgb != dim.rgb).any()

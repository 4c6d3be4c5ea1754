"""Visits recorded through the real Controller and engine: what the files say is what was there, and it is said again the same."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ovman.records.scene import Alteration, Roam
from ovman.records.tour import Tour
from ovman.records.visit import Visit
from ovman.settings.benchmark import Mover
from ovman.sim import visit
from ovman.sim.session import AgentPose, Session, SimulatorError
from ovman.sim.world import World, position
from tests.arms import CONFIG
from tests.tour_zips import contents, picture

SCENE = "FloorPlan16"
PARAMS = Mover(step_m=0.1, pause_probability=0.0, turn_probability=0.0)


@pytest.fixture(scope="module")
def session():
    with Session(SCENE, CONFIG) as session:
        session.reset()
        yield session


@pytest.fixture(scope="module")
def views(session):
    session.reset()
    start = session.pose
    return visit.views(Tour(waypoints=((start.x, start.z),), headings=4))


def world(session, *alterations, seed=0):
    return World(session, alterations, PARAMS, np.random.default_rng(seed))


def displaced(instance, x, z) -> Alteration:
    return Alteration(kind="displace", instance=instance, placement=(x, z), height_m=0.1)


def disabled(instance) -> Alteration:
    return Alteration(kind="disable", instance=instance)


def in_motion(instance, roam) -> Alteration:
    return Alteration(kind="motion", instance=instance, roam=roam)


def chair(session) -> str:
    return next(k for k, o in sorted(session.objects.items()) if o["objectType"] == "Chair")


def free_place(session) -> tuple[float, float]:
    """A cell whose neighbours are free, away from the agent."""
    cells = {(round(x / 0.25), round(z / 0.25)) for x, z in session.reachable()}
    here = session.pose
    for i, j in sorted(cells):
        around = {(i + a, j + b) for a in range(-2, 5) for b in range(-2, 3)}
        if around <= cells and np.hypot(i * 0.25 - here.x, j * 0.25 - here.z) > 1.2:
            return i * 0.25, j * 0.25
    raise AssertionError("no free place in the scene")


def around(session, instance) -> Roam:
    """Half a metre to every side of where an instance stands; nothing stops a mover there but its floor."""
    at = position(session.objects[instance])
    return Roam.over(at.x, at.z, PARAMS.step_m, [(column, row) for column in range(-5, 6) for row in range(-5, 6)])


def test_the_files_say_what_the_frames_showed_and_twice_the_same(session, views, tmp_path):
    first = visit.record(session, world(session), "untouched", [], views, 50, tmp_path / "a", "key")
    again = visit.record(session, world(session), "untouched", [], views, 50, tmp_path / "b", "key")
    assert first == again == Visit.load(tmp_path / "a")
    assert len(contents(tmp_path / "a")) == 2 + 3 * len(views)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    session.reset()
    for i, pose in enumerate(views):
        event = session.teleport(pose, image=True)
        ids, depth = picture(tmp_path / "a", f"{i:02d}_ids.png"), picture(tmp_path / "a", f"{i:02d}_depth.png")
        rgb = picture(tmp_path / "a", f"{i:02d}_rgb.png")[..., ::-1]
        view = first.views[i]
        for k, name in enumerate(view.instances, start=1):
            assert np.array_equal(ids == k, event.instance_masks[name])
            assert view.seen.get(name, 0) == (n if (n := int((ids == k).sum())) >= 50 else 0)
        assert np.abs(depth / 1000.0 - event.depth_frame).max() <= 5.01e-4
        assert np.array_equal(rgb, event.frame)


def test_a_displaced_instance_is_where_it_was_put_and_the_others_stay(session, views, tmp_path):
    session.reset()
    item = chair(session)
    untouched = {k: position(o) for k, o in session.objects.items()}
    place = free_place(session)
    moved = displaced(item, *place)
    recorded = visit.record(session, world(session, moved), "moved", [moved], views, 50, tmp_path / "v", "key")
    assert visit.drift_m(recorded, item, place) < 0.05
    for k, here in recorded.positions[-1].items():
        if k != item:
            assert here == untouched[k], k


def test_a_mover_takes_its_step_before_every_view_and_its_path_is_its_seeds(session, views, tmp_path):
    session.reset()
    item = chair(session)
    stands = position(session.objects[item])
    motion = in_motion(item, around(session, item))
    visits = [
        visit.record(session, world(session, motion, seed=seed), "moving", [motion], views, 50, tmp_path / str(k), "key")
        for k, seed in enumerate((3, 3))
    ]
    assert visits[0] == visits[1]
    path = visits[0].movers[0].path
    assert len(path) == 1 + len(views) and path[0] == (stands.x, stands.z)
    assert (visits[0].movers[0].start.position, visits[0].placed) == (path[-1], {})
    for point, here in zip(path[1:], visits[0].positions, strict=True):
        # The engine takes the rotation that it reports, which is rounded.
        assert np.hypot(point[0] - here[item].x, point[1] - here[item].z) < 1e-3
    steps = np.hypot(*np.diff(path, axis=0).T)
    assert np.allclose(steps, PARAMS.step_m, atol=2e-4)


def test_an_instance_that_does_not_stand_where_its_walk_begins_is_not_set_off(session):
    session.reset()
    item = chair(session)
    elsewhere = around(session, item).model_copy(update={"x": 0.0, "z": 0.0})
    with pytest.raises(SimulatorError, match="not at .*, where its walk begins"):
        world(session, in_motion(item, elsewhere))


def test_equal_world_states_share_a_name_and_others_do_not():
    roam = Roam.over(0.0, 0.0, 0.1, [(0, 0), (1, 0)])
    states = [
        ([], None),
        ([disabled("Vase|1")], None),
        ([disabled("Vase|2")], None),
        ([displaced("Vase|1", 1.0, 2.0)], None),
        ([displaced("Vase|1", 1.0, 2.5)], None),
        ([in_motion("Vase|1", roam)], 1),
        ([in_motion("Vase|1", roam)], 2),
    ]
    usual = Tour(waypoints=((0.0, 0.0), (1.0, 0.0)), headings=8)
    own = usual.model_copy(update={"first_yaw_deg": 22.5})
    names = [visit.visit_name(*state, tour, usual.waypoints) for tour in (usual, own) for state in states]
    assert len(set(names)) == len(names)
    again = [Alteration.from_json(json.loads(json.dumps(a.to_json()))) for a in states[5][0]]
    assert visit.visit_name(again, 1, usual, usual.waypoints) == names[5]


def test_a_view_that_is_not_free_is_an_error_and_leaves_no_visit(session, tmp_path):
    session.reset()
    inside = session.objects[chair(session)]["axisAlignedBoundingBox"]["center"]
    blocked = [AgentPose(inside["x"], inside["z"], 0.0)]
    with pytest.raises(SimulatorError, match=SCENE):
        visit.record(session, world(session), "blocked", [], blocked, 50, tmp_path / "v", "key")
    assert not (tmp_path / "v").exists()

"""Objects at rest stay until they are touched or hit, and rest again afterwards; none is lost. Physics itself: test_physics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman_engine.bodies.body import Body
from ovman_engine.plan import floorplan
from ovman_engine.world.errors import Refused
from ovman_engine.world.world import World

SAMPLE = [
    "FloorPlan2",
    "FloorPlan13",
    "FloorPlan203",
    "FloorPlan219",
    "FloorPlan304",
    "FloorPlan328",
    "FloorPlan402",
    "FloorPlan420",
]
POSE_KEYS = ("position", "rotation", "axisAlignedBoundingBox", "objectOrientedBoundingBox")
LOST_M = 0.75
"""An object farther than this outside the bounds of a scene counts as lost."""


def settle(world: World, seconds: float = 20.0) -> None:
    waited = 0.0
    while not world.at_rest and waited < seconds:
        world.advance(0.1)
        waited += 0.1
    assert world.at_rest


def movable(world: World) -> list[Body]:
    return [b for b in world.bodies.values() if b.dynamic and b.present]


def named(world: World, kind: str) -> Body:
    return next(b for b in world.bodies.values() if b.obj.type == kind)


def away(body: Body, point: Iterable[float]) -> float:
    """Distance on the floor plane between the middle of a body and a point."""
    return float(np.linalg.norm((body.box.centre - np.array(point))[[0, 2]]))


@pytest.mark.parametrize(
    "scene", [pytest.param(name, marks=[] if name in SAMPLE[2:6] else [pytest.mark.soak]) for name in floorplan.names()]
)
def test_nothing_moves_by_itself(engine: Callable[..., Any], scene: str) -> None:
    thor = engine(scene, fastActionEmit=False)
    before = {o["objectId"]: {key: o[key] for key in POSE_KEYS} for o in thor.agent["objects"]}
    for _ in range(20):
        after = thor.do("Pass")
        assert after["isSceneAtRest"] and not any(o["isMoving"] for o in after["objects"])
    assert {o["objectId"]: {key: o[key] for key in POSE_KEYS} for o in after["objects"]} == before


@pytest.mark.parametrize("scene", ["FloorPlan13", "FloorPlan219"])
def test_what_is_touched_in_its_place_stays_there_and_so_does_all_else(scene: str) -> None:
    plan = floorplan.load(scene)
    went = []
    for obj in [o for o in plan.objects if o.dynamic][::2]:
        world = World(plan)
        before = {name: b.pose for name, b in world.bodies.items()}
        world.teleport(obj.object_id, obj.position, force=True)
        awake = set(world._dynamics.awake)
        settle(world)
        went.append(np.linalg.norm(world.box(obj.object_id).centre - obj.box.centre))
        if not awake - {obj.object_id} and went[-1] < 0.01:
            bystanders = [n for n, b in world.bodies.items() if n != obj.object_id and b.carrier != obj.object_id]
            assert all(world.bodies[n].pose is before[n] for n in bystanders), obj.object_id
    assert np.mean(np.array(went) < 0.05) > 0.9


def test_what_is_put_on_a_table_stays_and_past_its_edge_falls() -> None:
    plan = floorplan.load("FloorPlan203")
    for over, falls in ((-0.12, False), (0.12, True)):
        world = World(plan)
        table, box = named(world, "DiningTable"), named(world, "Box")
        for other in [b for b in movable(world) if b is not table and b is not box]:
            world.remove(other.object_id)
        low, high = table.box.bounds()
        half = box.box.bounds()[1] - box.box.centre
        spot = np.array([high[0] + over, high[1] + half[1] + 0.02, (low[2] + high[2]) / 2])
        world.teleport(box.object_id, spot + box.pose.position - box.box.centre, force=True)
        settle(world)
        assert (box.box.centre[1] < high[1]) == falls, over


def bowled(world: World, speed: float) -> tuple[Body, Body]:
    """A bottle or vase on a cleared table, and a statue sent against it at `speed` m/s."""
    target = next(b for b in movable(world) if b.obj.type in ("Vase", "Statue") and b.box.half[1] > 0.08)
    table = max((b for b in movable(world) if b.obj.type in ("DiningTable", "CoffeeTable")), key=lambda b: np.prod(b.box.half))
    stone = next(b for b in movable(world) if b.obj.type in ("Statue", "Bowl", "Vase", "Box") and b is not target)
    for other in [b for b in movable(world) if b not in (target, stone, table)]:
        world.remove(other.object_id)
    top = table.box.bounds()[1][1]
    spot = np.array([table.box.centre[0], top + 0.05, table.box.centre[2]])
    world.place(target.object_id, spot + (target.pose.position - target.box.centre) * [1, 0, 1])
    settle(world)
    half = stone.box.bounds()[1] - stone.box.centre
    gap = half[2] + (target.box.bounds()[1] - target.box.centre)[2] + 0.03
    start = np.array([target.box.centre[0], top + half[1] + 0.01, target.box.centre[2] - gap])
    world.teleport(stone.object_id, start + stone.pose.position - stone.box.centre, force=True)
    stone.velocity = np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])
    return target, table


@pytest.mark.parametrize(("speed", "moves"), [(2.0, True), (0.0, False)])
def test_a_bystander_that_is_hit_moves_and_the_table_does_not(engine: Callable[..., Any], speed: float, moves: bool) -> None:
    thor = engine("FloorPlan203", fastActionEmit=False)
    world = thor.engine.session.world
    target, table = bowled(world, speed)
    stood, table_pose = target.box.centre.copy(), table.pose
    reported = thor.do("Pass", renderImage=False)
    before = thor.object(target.object_id)["axisAlignedBoundingBox"]["center"]
    while not reported["isSceneAtRest"]:
        reported = thor.do("Pass", renderImage=False)
    assert (away(target, stood) > 0.005) == moves
    assert table.pose is table_pose
    now = thor.object(target.object_id)["axisAlignedBoundingBox"]["center"]
    assert np.allclose([now[a] for a in "xyz"], np.mean(target.box.bounds(), axis=0), atol=1e-6)
    assert (before != now) == moves


def test_energy_never_grows() -> None:
    world = World(floorplan.load("FloorPlan304"))
    cells = np.array(world.reachable())
    heap = movable(world)[:10]
    for k, body in enumerate(heap):
        at = cells[len(cells) // 2] + [0.05 * k, 0.3 + 0.1 * k, 0.0]
        world.teleport(body.object_id, at + body.pose.position - body.box.centre, force=True)

    def energy() -> float:
        """A lower bound of the energy: rotation is left out."""
        return sum(b.obj.mass * (9.81 * b.box.centre[1] + 0.5 * float(b.velocity[:3] @ b.velocity[:3])) for b in heap)

    start = energy()
    for _ in range(150):
        world.advance(0.02)
        assert energy() < start + 0.01
    assert energy() < start - 10.0


ACTIONS = st.tuples(
    st.sampled_from(["place", "teleport", "force", "kinematic", "disable", "enable", "remove", "poses", "loose", "pass"]),
    st.integers(0, 10_000),
    st.tuples(*[st.floats(-0.2, 1.2) for _ in range(3)]),
    st.floats(0.0, 360.0),
)


@settings(max_examples=8)
@given(st.sampled_from(SAMPLE), st.lists(ACTIONS, min_size=1, max_size=8))
def test_no_sequence_of_changes_loses_an_object(scene: str, story: list[tuple[str, int, tuple[float, ...], float]]) -> None:
    world = World(floorplan.load(scene))
    low, high = world.bounds()
    agent, gone, flung = world.agent.position.copy(), set(), set()
    for what, index, where, yaw in story:
        bodies = [b for b in world.bodies.values() if b.dynamic and not b.removed]
        if not bodies:
            break
        body = bodies[index % len(bodies)]
        point = low + np.array(where) * (high - low)
        turn = floorplan.rotation_matrix(np.array([0.0, yaw, 0.0]))
        try:
            if what == "place":
                world.place(body.object_id, point, turn)
            elif what in ("teleport", "force", "kinematic"):
                world.teleport(body.object_id, point, turn, force=what != "teleport", kinematic=what == "kinematic")
                flung.add(body.name)
            elif what in ("disable", "enable"):
                world.set_active(body.object_id, what == "enable")
            elif what == "remove":
                gone |= {b.name for b in bodies if not b.active} | {body.name}
                world.remove(body.object_id)
            elif what in ("poses", "loose"):
                listed = [b for b in bodies if b.active][index % 3 :]
                gone |= {b.name for b in bodies} - {b.name for b in listed}
                poses = [{"objectName": b.name, "position": b.pose.position, "rotation": b.pose.rotation} for b in listed]
                world.set_poses(poses, stationary=what == "poses")
            else:
                world.advance(0.5)
        except Refused as refused:
            assert str(refused) or what in ("disable", "enable")
        world.advance(0.1)
    world.advance(3.0)
    assert np.array_equal(world.agent.position, agent)
    left = {b.name: b for b in world.bodies.values() if not b.removed}
    assert left.keys() | gone >= {o.name for o in world.plan.objects if o.dynamic}
    assert not left.keys() & gone
    for body in left.values():
        assert np.isfinite(body.pose.position).all() and np.isfinite(body.velocity).all()
        assert np.allclose(body.pose.rotation @ body.pose.rotation.T, np.eye(3), atol=1e-6)
        if body.name not in flung:
            centre = body.box.centre
            assert (centre > low - LOST_M).all() and (centre < high + LOST_M).all(), body.object_id
        assert world.bodies[body.object_id] is body

"""Touched objects fall, settle, roll and stay in the room; all others stay where they are."""

from __future__ import annotations

import numpy as np
import pytest

from ovman_engine.physics.layout import Layout, Solid
from ovman_engine.physics.physics import TICK_S, Model
from ovman_engine.plan import floorplan
from ovman_engine.plan.floorplan import Box, rotation_matrix
from ovman_engine.world.errors import Refused
from ovman_engine.world.world import World

SCENES = ["FloorPlan1", "FloorPlan201", "FloorPlan301"]
PLANS = {name: floorplan.load(name) for name in SCENES}
FLOOR_Y = 0.3


def alone(piece: tuple, box: Box, others: dict[str, Box] | None = None, mass: float = 0.5, strangers: tuple = ()) -> Model:
    """One free body made of `piece`, and fixed boxes."""
    others = others or {}
    solids = [Solid("body", (piece,), mass, True)]
    solids += [Solid(name, (("box", np.zeros(3), b.half, np.eye(3)),), 1.0, False) for name, b in others.items()]
    return Model(Layout(solids, {"body": box, **others}, frozenset(["body"]), {}, FLOOR_Y, (0.2, 1.8), frozenset(strangers)))


def cube(half: float) -> tuple:
    return ("box", np.zeros(3), np.full(3, half), np.eye(3))


def run(model: Model, seconds: float) -> None:
    for _ in range(round(seconds / TICK_S)):
        model.tick()
        model.watch()


def settle(world: World, seconds: float = 8.0) -> None:
    waited = 0.0
    while not world.at_rest and waited < seconds:
        world.advance(0.1)
        waited += 0.1


def remote_on_sofa(height: float) -> tuple[World, np.ndarray, np.ndarray]:
    """Put the remote control at a height above the floor on a sofa; returns its position before and after a second."""
    world = World(PLANS["FloorPlan201"])
    bodies = world.bodies.values()
    remote = next(b for b in bodies if b.obj.type == "RemoteControl")
    sofa = next(b for b in bodies if b.obj.type == "Sofa")
    there = np.array([sofa.box.centre[0], world.plan.floor_y + height, sofa.box.centre[2]])
    pose = {"objectName": remote.name, "position": there, "rotation": np.eye(3)}
    world.set_poses([pose], stationary=False, skip_moveable=True)
    world.advance(1.0)
    return world, there, next(b for b in world.bodies.values() if b.name == remote.name).pose.position


def test_a_body_that_is_sunk_in_its_support_stays_and_does_not_fall_through() -> None:
    _, there, now = remote_on_sofa(0.3)
    assert np.array_equal(now, there)


def test_a_body_above_its_support_falls_on_it() -> None:
    world, there, now = remote_on_sofa(1.2)
    assert there[1] - 1.0 < now[1] < there[1] - 0.2 and now[1] > world.plan.floor_y + 0.3


def test_a_body_falls_as_bodies_fall() -> None:
    half = np.full(3, 0.1)
    model = alone(cube(0.1), Box(np.array([1.0, FLOOR_Y + 5.0, 2.0]), half, np.eye(3)))
    run(model, 0.3)
    box, velocity = model.box("body", half)
    assert np.allclose(box.centre[[0, 2]], [1.0, 2.0], atol=1e-9)
    assert abs(FLOOR_Y + 5.0 - box.centre[1] - 0.5 * 9.81 * 0.3**2) < 0.02
    assert abs(velocity[1] + 9.81 * 0.3) < 0.05
    run(model, 3.0)
    assert model.asleep and abs(model.box("body", half)[0].centre[1] - FLOOR_Y - 0.1) < 1e-3


def test_a_ball_rolls_off_a_slope_and_a_box_does_not() -> None:
    slope = Box(np.array([0.0, FLOOR_Y + 0.5, 0.0]), np.array([0.5, 0.02, 0.5]), rotation_matrix(np.array([8.0, 0.0, 0.0])))
    at = slope.centre + slope.rotation @ np.array([0.0, 0.02 + 0.055, 0.0])
    ball = alone(("sphere", np.zeros(3), 0.05), Box(at, np.full(3, 0.05), np.eye(3)), {"slope": slope})
    box = alone(cube(0.05), Box(at, np.full(3, 0.05), slope.rotation), {"slope": slope})
    run(ball, 3.0)
    run(box, 3.0)
    rolled, still = ball.box("body", np.full(3, 0.05))[0], box.box("body", np.full(3, 0.05))[0]
    assert rolled.centre[2] - at[2] > 0.4 and rolled.centre[1] < FLOOR_Y + 0.1
    assert np.linalg.norm(still.centre - at) < 0.02 and box.asleep


@pytest.mark.parametrize("name", SCENES)
def test_what_is_placed_stays_near_where_it_was_placed(name: str) -> None:
    world = World(PLANS[name])
    rng = np.random.default_rng(4)
    cells = np.array(world.reachable())
    placed = 0
    for body in [b for b in world.bodies.values() if b.obj.moveable][:6]:
        before = {n: b.pose.position.copy() for n, b in world.bodies.items() if not b.dynamic}
        cell = cells[rng.integers(len(cells))]
        try:
            answer = world.place(body.object_id, cell + [0.0, 0.5, 0.0])
        except Refused:
            continue
        settle(world)
        placed += 1
        assert world.at_rest
        assert np.linalg.norm(body.pose.position - answer) < 0.05
        assert abs(body.pose.position[0] - cell[0]) < 0.25 and abs(body.pose.position[2] - cell[2]) < 0.25
        own = {p.object_id for p in world.bodies.values() if p.carrier == body.object_id}
        assert all(np.array_equal(world.bodies[n].pose.position, p) for n, p in before.items() if n not in own)
    assert placed >= 1


@pytest.mark.parametrize("name", SCENES)
def test_nothing_leaves_the_room(name: str) -> None:
    plan = PLANS[name]
    world = World(plan)
    for body in [b for b in world.bodies.values() if b.obj.moveable]:
        world.set_active(body.object_id, False)
    for body in [b for b in world.bodies.values() if b.present and b.dynamic]:
        world.teleport(body.object_id, body.pose.position, force=True)
    settle(world, 4.0)
    low, high = world.bounds()
    for body in (b for b in world.bodies.values() if b.present and b.dynamic):
        centre = world.box(body.object_id).centre
        assert centre[1] > plan.floor_y - 0.2, body.object_id
        assert (centre > low - 0.5).all() and (centre < high + 0.5).all(), body.object_id


def test_two_worlds_with_the_same_calls_are_the_same_world() -> None:
    def story() -> list[np.ndarray]:
        world = World(PLANS["FloorPlan201"])
        out = []
        for body in [b for b in world.bodies.values() if b.dynamic][:12]:
            try:
                world.place(body.object_id, world.agent.position + [0.3 * len(out) / 12, 0.6, 1.0])
            except Refused as refused:
                out.append(np.array([len(str(refused))]))
            world.advance(0.1)
            out.append(
                np.concatenate([np.r_[b.pose.position, b.pose.rotation.ravel(), b.velocity] for b in world.bodies.values()])
            )
        return out

    for first, second in zip(story(), story(), strict=True):
        assert np.array_equal(first, second)

"""Touched objects fall, settle, roll and stay in the room; all others stay where they are."""

from __future__ import annotations

import numpy as np
import pytest

from ovman_engine.physics import layout
from ovman_engine.physics.layout import Layout, Solid
from ovman_engine.physics.physics import SLEEP_S, TICK_S, Model
from ovman_engine.plan import floorplan
from ovman_engine.plan.floorplan import Box, rotation_matrix
from ovman_engine.world.errors import Refused
from ovman_engine.world.world import World

SCENES = ["FloorPlan1", "FloorPlan201", "FloorPlan215", "FloorPlan301", "FloorPlan406"]
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


def bottom(world: World, name: str) -> float:
    return float(world.box(name).bounds()[0][1])


def top(world: World, name: str) -> float:
    return float(world.box(name).bounds()[1][1])


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


def test_poses_and_spins_survive_the_change_of_hands() -> None:
    half = np.array([0.1, 0.2, 0.3])
    rotation = rotation_matrix(np.array([20.0, 130.0, -35.0]))
    model = alone(("box", np.zeros(3), half, np.eye(3)), Box(np.array([0.5, 9.0, -1.0]), half, rotation))
    assert np.allclose(model.box("body", half)[0].rotation, rotation)
    spin = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    model.set_box("body", Box(np.array([0.5, 9.0, -1.0]), half, np.eye(3)), spin)
    model.forward()
    run(model, 0.1)
    turned = model.box("body", half)[0].rotation
    assert np.allclose(turned, rotation_matrix(np.array([0.0, np.degrees(0.1), 0.0])), atol=5e-3)


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


def test_what_stands_over_the_edge_falls_off() -> None:
    table = Box(np.array([0.0, FLOOR_Y + 0.35, 0.0]), np.array([0.5, 0.35, 0.5]), np.eye(3))
    for over, falls in ((-0.03, False), (0.03, True)):
        at = np.array([0.5 + over, FLOOR_Y + 0.7 + 0.105, 0.0])
        model = alone(cube(0.1), Box(at, np.full(3, 0.1), np.eye(3)), {"table": table})
        run(model, 3.0)
        assert (model.box("body", np.full(3, 0.1))[0].centre[1] < FLOOR_Y + 0.3) == falls


def test_strangers_do_not_touch() -> None:
    wall = Box(np.array([0.0, FLOOR_Y + 0.5, 0.0]), np.array([0.1, 0.5, 1.0]), np.eye(3))
    inside = Box(np.array([0.12, FLOOR_Y + 0.1, 0.0]), np.full(3, 0.1), np.eye(3))
    overlap = alone(cube(0.1), inside, {"wall": wall}).overlaps("body")[0]
    assert overlap.other == "wall" and overlap.depth == pytest.approx(0.08) and abs(overlap.up) < 1e-6
    model = alone(cube(0.1), inside, {"wall": wall}, strangers=(("body", "wall"),))
    assert "wall" not in [o.other for o in model.overlaps("body")]
    run(model, 1.0)
    assert model.asleep and np.linalg.norm(model.box("body", np.full(3, 0.1))[0].centre - inside.centre) < 2e-3


def test_an_absent_body_is_neither_touched_nor_seen() -> None:
    shelf = Box(np.array([0.0, FLOOR_Y + 0.5, 0.0]), np.array([0.5, 0.02, 0.5]), np.eye(3))
    model = alone(cube(0.1), Box(np.array([0.0, FLOOR_Y + 1.0, 0.0]), np.full(3, 0.1), np.eye(3)), {"shelf": shelf})
    above = np.array([0.2, 2.0, 0.0])
    assert model.below(above, 10.0, but="body") == (pytest.approx(FLOOR_Y + 0.52), "shelf")
    model.set_present("shelf", False)
    model.forward()
    assert model.below(above, 10.0, but="body") == (pytest.approx(FLOOR_Y), "Floor")
    assert model.below(above, 1.0, but="body") is None
    run(model, 2.0)
    assert model.box("body", np.full(3, 0.1))[0].centre[1] < FLOOR_Y + 0.11


def test_sleep_takes_as_long_as_it_says() -> None:
    model = alone(cube(0.1), Box(np.array([0.0, FLOOR_Y + 0.1, 0.0]), np.full(3, 0.1), np.eye(3)))
    run(model, SLEEP_S - TICK_S)
    assert not model.asleep
    run(model, 2 * TICK_S)
    assert model.asleep


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


def test_a_vase_on_a_table_stays_on_it_and_falls_when_the_table_goes() -> None:
    world = World(PLANS["FloorPlan215"])
    vase = next(n for n in world.bodies if n.startswith("Vase|"))
    table = "SideTable|-00.59|+00.01|+02.00"
    for other in [n for n, b in world.bodies.items() if table in b.obj.parents]:
        world.remove(other)
    spot = world.box(table).centre + [0.0, 1.0, 0.0]
    answer = world.place(vase, spot + (world.bodies[vase].pose.position - world.box(vase).centre) * [1, 0, 1])
    settle(world)
    assert np.linalg.norm(world.bodies[vase].pose.position - answer) < 0.05
    assert abs(bottom(world, vase) - top(world, table)) < 0.05
    world.set_active(table, False)
    assert not world.at_rest
    settle(world)
    assert world.at_rest and bottom(world, vase) < world.plan.floor_y + 0.1


def test_kinematic_bodies_hang_where_they_are_put() -> None:
    world = World(PLANS["FloorPlan201"])
    chair = next(n for n in world.bodies if n.startswith("Chair|"))
    answer = world.place(chair, world.agent.position + [0.0, 0.5, 1.5], kinematic=True)
    assert world.at_rest
    assert abs(bottom(world, chair) - world.plan.floor_y - 0.005) < 2e-3
    world.teleport(chair, answer + [0.0, 1.0, 0.0], force=True, kinematic=True)
    world.advance(1.0)
    assert np.allclose(world.bodies[chair].pose.position, answer + [0.0, 1.0, 0.0])
    world.teleport(chair, answer + [0.0, 1.0, 0.0], force=True)
    assert not world.at_rest
    settle(world)
    assert bottom(world, chair) < world.plan.floor_y + 0.1


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


def test_time_is_paid_for_in_ticks_whatever_the_slices() -> None:
    def fallen(slices: list[float]) -> np.ndarray:
        world = World(PLANS["FloorPlan301"])
        pillow = next(n for n, b in world.bodies.items() if b.obj.pickupable)
        world.teleport(pillow, world.agent.position + [0.0, 1.0, 0.5], force=True)
        for seconds in slices:
            world.advance(seconds)
        return world.bodies[pillow].pose.position

    assert np.allclose(fallen([0.1]), fallen([0.01] * 10), atol=1e-12)
    assert np.allclose(fallen([0.1]), fallen([0.05, 0.05]), atol=1e-12)


def fall(world: World, name: str, at: np.ndarray) -> list[bytes]:
    """Every pose of a falling object, to the bit."""
    world.teleport(name, at, kinematic=False)
    poses = []
    for _ in range(12):
        world.advance(0.05)
        poses += [world.bodies[name].pose.position.tobytes(), world.bodies[name].pose.rotation.tobytes()]
    return poses


def test_a_kept_scene_moves_like_a_freshly_compiled_one(monkeypatch):
    """Objects that fall in turns in two worlds of one plan do not influence each other."""
    plan = PLANS["FloorPlan201"]
    things = [o.object_id for o in plan.objects if o.record["pickupable"]][:2]
    at = {name: np.array(World(plan).box(name).centre) + [0.02, 0.4, 0.0] for name in things}
    compiled = []
    original = Layout._compiled
    monkeypatch.setattr(Layout, "_compiled", lambda self: compiled.append(1) or original(self))
    monkeypatch.setattr(layout, "_kept", type(layout._kept)())
    kept = [fall(World(plan), name, at[name]) for name in things * 2]
    once = len(compiled)
    monkeypatch.setattr(layout, "KEPT", 0)
    monkeypatch.setattr(layout, "_kept", type(layout._kept)())
    fresh = [fall(World(plan), name, at[name]) for name in things * 2]
    assert kept == fresh and kept[0] == kept[2] != kept[1]
    assert len(set(kept[0])) > 4
    assert 2 * once == len(compiled) - once


def test_layouts_are_told_apart_by_every_part_and_pieces_are_digested_once(monkeypatch):
    piece = ("box", np.zeros(3), np.full(3, 0.1), np.eye(3))
    wider = ("box", np.zeros(3), np.array([0.1, 0.1, 0.2]), np.eye(3))
    box = Box(np.zeros(3), np.full(3, 0.1), np.eye(3))

    def layout_of(pieces=(piece,), name="body", mass=1.0, moving=True, at=box, free=frozenset()):
        return Layout([Solid(name, pieces, mass, moving)], {name: at}, free, {}, 0.0, (0.2, 1.8))

    raised = Box(np.array([0.0, 0.3, 0.0]), box.half, box.rotation)
    different = [{}, {"pieces": (wider,)}, {"pieces": (piece, piece)}, {"name": "other"}, {"mass": 2.0}, {"moving": False}]
    different += [{"at": raised}, {"free": frozenset({"body"})}]
    assert len({layout_of(**one)._digest() for one in different}) == len(different)
    equal = ("box", np.zeros(3), np.full(3, 0.1), np.eye(3))
    assert layout_of((equal,))._digest() == layout_of()._digest()
    monkeypatch.setattr(layout, "KEPT_PIECES", 2)
    shared, looked_at = (piece,), []
    original = layout._content
    monkeypatch.setattr(layout, "_content", lambda value: looked_at.append(value) or original(value))
    before = layout_of(shared)._digest()
    first = sum(value is shared for value in looked_at)
    assert [layout_of(shared)._digest() for _ in range(3)] == [before] * 3
    assert first == sum(value is shared for value in looked_at) == 1
    for _ in range(4):
        layout_of((("box", np.ones(3), np.ones(3), np.eye(3)),))._digest()
    assert len(layout._digests) == 2 and layout_of(shared)._digest() == before


def test_worlds_of_a_plan_share_pieces_and_a_part_that_is_gone_takes_its_own_along():
    plan = PLANS["FloorPlan201"]
    world, other = World(plan), World(plan)
    pieces = world._dynamics._pieces
    assert len(pieces) > 20 and all(other._dynamics._pieces[name] is own for name, own in pieces.items())
    static = world._dynamics._static
    carrier, part = next((b.carrier, b.object_id) for b in world.bodies.values() if b.carrier is not None)
    parts = [b.obj for b in world.bodies.values() if b.carrier == carrier]
    assert static.pieces_with(world.bodies[carrier].obj, parts) is pieces[carrier]
    before = len(pieces[carrier])
    world.set_active(part, False)
    assert len(world._dynamics._pieces[carrier]) < before == len(other._dynamics._pieces[carrier])
    world.set_active(part, True)
    assert world._dynamics._pieces[carrier] is pieces[carrier]

"""Images against geometry: depth and ids are exact, and a frame is a function of the world and the view."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman_engine import kernels
from ovman_engine.paint import materials, textures
from ovman_engine.picture import camera, painter, scene_mesh, triangle_mesh
from ovman_engine.picture.camera import Renderer, View
from ovman_engine.plan import floorplan
from ovman_engine.shapes import Part
from ovman_engine.world.world import World

FEW = settings(max_examples=20, deadline=None, derandomize=True)
SCENES = ("FloorPlan201", "FloorPlan7", "FloorPlan311", "FloorPlan410")
LOW, HIGH = np.array([-2.0, 0.0, -3.0]), np.array([4.0, 2.5, 5.0])


class Stage:
    """A world without objects: structures alone, in world coordinates."""

    def __init__(self, *boxes: tuple[str, np.ndarray, np.ndarray]) -> None:
        paint = {"main": materials.Material(np.array([0.5, 0.4, 0.3]))}
        self.plan = floorplan.FloorPlan("Stage", "none", (), np.zeros(3), 0.0)
        self.room, self.bodies, self.version = self, {}, 0
        self._parts = tuple((name, (Part("box", (low + high) / 2, high - low),), paint) for name, low, high in boxes)

    def parts(self):
        return self._parts

    def lamps(self):
        return (np.array([0.0, 2.0, 0.0]),)


def hall() -> Stage:
    """The inside of one box."""
    return Stage(("hall", LOW, HIGH))


def rays_of(view: View) -> np.ndarray:
    """(H, W, 3) directions through pixel centres, of length 1 along the view direction, by the camera model's definition."""
    a, p = np.radians(view.yaw_deg), np.radians(view.horizon_deg)
    forward = np.array([np.sin(a) * np.cos(p), -np.sin(p), np.cos(a) * np.cos(p)])
    right = np.array([np.cos(a), 0, -np.sin(a)])
    up = np.cross(forward, right)
    tall = np.tan(np.radians(view.fov_deg) / 2)
    y = (1 - 2 * (np.arange(view.height) + 0.5) / view.height) * tall
    x = (2 * (np.arange(view.width) + 0.5) / view.width - 1) * tall * view.width / view.height
    return forward + x[None, :, None] * right + y[:, None, None] * up


def view_of(world: World, number: int, **fields) -> View:
    """A view of a world: a reachable cell, a heading and a pitch that are functions of the number."""
    cells = world.reachable()
    cell = np.array(cells[number * 37 % len(cells)])
    return View(cell + [0, 0.675, 0], float(number * 70 % 360), float([0, 30, 0, 60][number % 4]), **fields)


def angles(low: float, high: float) -> st.SearchStrategy[float]:
    """Angles to a thousandth of a degree: with a pitch of 1e-38 degrees, directions leave the range of the renderer's floats."""
    return st.floats(low, high).map(lambda degrees: round(degrees, 3))


@FEW
@given(
    angles(0, 360), angles(-30, 60), st.floats(30, 110), st.integers(8, 40), st.integers(8, 40),
    st.floats(0.1, 0.9), st.floats(0.2, 0.9), st.floats(0.1, 0.9),
)  # fmt: skip
def test_depth_inside_a_box_is_the_distance_to_its_walls(yaw, horizon, fov, width, height, x, y, z):
    view = View(LOW + np.array([x, y, z]) * (HIGH - LOW), yaw, horizon, fov, width, height)
    ways = rays_of(view)
    with np.errstate(divide="ignore"):
        expected = np.where(ways > 0, (HIGH - view.position) / ways, (LOW - view.position) / ways).min(axis=2)
    depth = Renderer(hall()).frame(view, rgb=False, depth=True).depth
    seen = (expected > view.near_m + 1e-3) & (expected < view.far_m - 1e-3)
    assert depth.dtype == np.float32
    np.testing.assert_allclose(depth[seen], expected[seen], rtol=3e-5)


def test_near_and_far_bound_what_is_seen():
    stage = Stage(
        ("near", np.array([-1.0, -1, 1]), np.array([1.0, 1, 1.2])), ("far", np.array([-9.0, -9, 30]), np.array([9.0, 9, 31]))
    )
    renderer = Renderer(stage)
    frame = renderer.frame(View(np.zeros(3), 0, width=9, height=9, near_m=0.5), rgb=False, depth=True, ids=True)
    assert frame.ids[4, 4] == 0 and frame.depth[4, 4] == pytest.approx(1.0, abs=1e-6)
    beyond = renderer.frame(View(np.array([0, 0, 2.0]), 0, width=9, height=9), rgb=False, depth=True, ids=True)
    assert (beyond.ids == -1).all() and (beyond.depth == 20).all()
    inside = renderer.frame(View(np.array([0, 0, 0.9]), 0, width=9, height=9, near_m=0.15), rgb=False, depth=True, ids=True)
    assert inside.depth[4, 4] == pytest.approx(0.3, abs=1e-6), "what is nearer than the near plane is not drawn"


def test_an_orthographic_view_from_above_measures_heights_and_lengths():
    stage = Stage(
        ("floor", np.array([-2.0, -0.1, -2]), np.array([2.0, 0, 2])), ("box", np.array([0.0, 0, 0]), np.array([1.0, 0.5, 1]))
    )
    view = View(np.array([0.0, 3, 0]), 0, 90, width=80, height=80, orthographic_size=2.0)
    frame = Renderer(stage).frame(view, depth=True, ids=True)
    np.testing.assert_allclose(frame.depth, np.where(frame.ids == 1, 2.5, 3.0), atol=1e-5)
    assert (frame.ids == 1).sum() == 20 * 20 and (frame.ids[20:40, 40:60] == 1).all()


@pytest.mark.parametrize("scene", SCENES)
def test_what_is_seen_of_an_object_lies_in_its_box(scene):
    world = World(floorplan.load(scene))
    renderer = Renderer(world)
    inside = total = 0
    for number in range(4):
        view = view_of(world, number, width=120, height=120)
        frame = renderer.frame(view, rgb=False, depth=True, ids=True)
        assert set(np.unique(frame.ids)) <= set(range(-1, len(renderer.names)))
        assert ((frame.depth < view.far_m) == (frame.ids >= 0)).all()
        points = view.position + rays_of(view) * frame.depth[..., None]
        for i in np.unique(frame.ids[frame.ids >= 0]):
            if renderer.names[i] in world.bodies:
                box = world.box(renderer.names[i])
                local = np.abs((points[frame.ids == i] - box.centre) @ box.rotation)
                if renderer.names[i].startswith("CounterTop"):
                    local[:, 1] = 0  # the recorded box is that of the slab; its body is drawn too
                inside += (local <= box.half + 0.02).all(axis=1).sum()
                total += len(local)
    assert total > 5000
    assert inside / total >= 0.99


def test_a_closed_room_has_no_holes():
    for scene in SCENES:
        world = World(floorplan.load(scene))
        ids = Renderer(world).frame(view_of(world, 4, width=150, height=150), rgb=False, ids=True).ids
        assert (ids >= 0).mean() > 0.999


def test_frames_are_the_same_to_the_byte_from_renderer_to_renderer():
    world = World(floorplan.load("FloorPlan201"))
    view = view_of(world, 2, width=150, height=130)
    first = Renderer(world).frame(view, depth=True, ids=True, normals=True)
    camera._plans.clear()
    scene_mesh._plans.clear()
    second = Renderer(World(floorplan.load("FloorPlan201"))).frame(view, depth=True, ids=True, normals=True)
    for name in ("rgb", "depth", "ids", "normals"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()
    assert first.rgb.shape == (130, 150, 3) and first.rgb.dtype == np.uint8
    assert len(np.unique(first.rgb.reshape(-1, 3), axis=0)) > 200


def seen_objects(renderer: Renderer, view: View) -> list[str]:
    ids = renderer.frame(view, rgb=False, ids=True).ids
    return [renderer.names[i] for i in np.unique(ids[ids >= 0]) if (ids == i).sum() > 40]


def test_moving_an_object_and_back_restores_the_frame():
    world = World(floorplan.load("FloorPlan201"))
    renderer = Renderer(world)
    view = view_of(world, 1, width=150, height=150)
    name = next(n for n in seen_objects(renderer, view) if n in world.bodies and world.bodies[n].dynamic)
    before = renderer.frame(view, depth=True, ids=True)
    home = world.bodies[name].pose
    turned = floorplan.rotation_matrix(np.array([0.0, 33.0, 0.0])) @ home.rotation
    world.teleport(name, home.position + [0.3, 0.2, -0.4], turned, force=True, kinematic=True)
    away = renderer.frame(view, depth=True, ids=True)
    assert (away.ids != before.ids).sum() > 40
    again = floorplan.rotation_matrix(floorplan.euler_degrees(home.rotation))
    world.teleport(name, home.position.copy(), again, force=True, kinematic=True)
    back = renderer.frame(view, depth=True, ids=True)
    for image in ("rgb", "depth", "ids"):
        assert getattr(back, image).tobytes() == getattr(before, image).tobytes()


def test_normals_are_unit_and_face_the_viewer():
    world = World(floorplan.load("FloorPlan311"))
    view = view_of(world, 3, width=90, height=90)
    frame = Renderer(world).frame(view, rgb=False, ids=True, normals=True)
    normals, seen = frame.normals, frame.ids >= 0
    np.testing.assert_allclose(np.linalg.norm(normals[seen], axis=1), 1, atol=1e-4)
    assert (np.einsum("ijk,ijk->ij", normals, rays_of(view))[seen] <= 1e-4).all()


@pytest.mark.parametrize("bad", [{"fov_deg": 0.0}, {"fov_deg": 180.0}, {"width": 0}])
def test_impossible_views_are_refused(bad):
    with pytest.raises(ValueError):
        View(np.zeros(3), 0, **bad)


def soup(rng: np.random.Generator, count: int) -> triangle_mesh.TriangleMesh:
    """Random triangles, each an instance."""
    numbers = np.arange(count, dtype=np.int32)
    vertices = rng.uniform(-1, 1, (3 * count, 3)).astype(np.float32)
    corners = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    flat = np.zeros((count, 3), np.float32)
    names = tuple(map(str, numbers))
    return triangle_mesh.TriangleMesh(
        vertices, corners, np.zeros((count, 3, 3), np.float32), numbers, numbers, numbers, numbers,
        np.zeros((count, 3, 4), np.float32), flat, names, (),
    )  # fmt: skip


def met(mesh: triangle_mesh.TriangleMesh, origins: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """(N, T) distances at which rays meet triangles, infinite where they miss, by solving for each pair."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]].astype(float) for k in range(3))
    matrix = np.stack(np.broadcast_arrays(-ways[:, None].astype(float), (b - a)[None], (c - a)[None]), axis=-1)
    found = np.linalg.solve(matrix, (origins[:, None] - a)[..., None])[..., 0]
    distance, u, v = np.moveaxis(found, -1, 0)
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0), distance, np.inf)


@FEW
@given(st.integers(0, 2**32 - 1), st.integers(0, 40), st.integers(0, 4), st.integers(0, 40))
def test_rays_meet_the_nearest_triangle_of_several_meshes(seed, fixed, displaced, count):
    rng = np.random.default_rng(seed)
    stays, moved = soup(rng, fixed), soup(rng, displaced)
    origins = rng.uniform(-2, 2, (count, 3)).astype(np.float32)
    ways = rng.normal(size=(count, 3)).astype(np.float32)
    expected = np.concatenate([met(stays, origins, ways), met(moved, origins, ways), np.full((count, 1), np.inf)], axis=1)
    nearest = expected.min(axis=1)
    triangle, distance, _, _ = kernels.closest([painter.solid(stays), painter.solid(moved)], origins, ways)
    assert triangle.dtype == np.int32
    assert (triangle == np.where(np.isfinite(nearest), expected.argmin(axis=1), -1)).all()
    np.testing.assert_allclose(distance[triangle >= 0], nearest[triangle >= 0], rtol=1e-6)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("size", [None, 2.5])
def test_pixels_show_what_rays_through_their_centres_meet(scene, size):
    world = World(floorplan.load(scene))
    renderer = Renderer(world)
    solid, mesh = scene_mesh.solid(scene_mesh.of_plan(world.plan, world.room)), scene_mesh.build(world)
    for number in range(3):
        view = view_of(world, number, width=120, height=90, orthographic_size=size)
        frame = renderer.frame(view, rgb=False, depth=True, ids=True)
        if size is None:
            ways = rays_of(view).reshape(-1, 3)
            origins = np.broadcast_to(view.position, ways.shape)
        else:
            y, x = (1 - 2 * (np.arange(90) + 0.5) / 90) * size, (2 * (np.arange(120) + 0.5) / 120 - 1) * size * 120 / 90
            right, up, forward = view.axes()
            origins = (view.position + x[None, :, None] * right + y[:, None, None] * up).reshape(-1, 3)
            ways = np.broadcast_to(forward, origins.shape)
        near = origins + view.near_m * ways
        triangle, distance, _, _ = kernels.closest([solid], near, ways)
        hit = (triangle >= 0) & (distance + view.near_m <= view.far_m)
        ids = np.where(hit, mesh.instance[triangle], -1)
        depth = np.where(hit, distance + view.near_m, view.far_m)
        # a vertex is placed to 1/4096 of a pixel, so rays along an edge may meet either side of it
        assert (frame.ids.ravel() == ids).mean() > 0.998
        assert (np.abs(frame.depth.ravel() - depth) < 1e-4 * depth).mean() > 0.995


def test_light_after_a_change_is_that_of_a_scene_made_so():
    """What a change cannot reach keeps its light; all else is computed again: together the light of the changed scene."""
    world = World(floorplan.load("FloorPlan212"))
    renderer = Renderer(world)
    views = [view_of(world, n, width=100, height=100) for n in range(3)]
    for view in views:
        renderer.frame(view)
    names = [n for view in views for n in seen_objects(renderer, view) if n in world.bodies and world.bodies[n].dynamic]
    for name in dict.fromkeys(names[:3]):
        pose = world.bodies[name].pose
        world.teleport(name, pose.position + [0.2, 0.3, 0.1], pose.rotation, force=True, kinematic=True)
    kept = [renderer.frame(view).rgb for view in views]
    meshes, now = scene_mesh.of_plan(world.plan, world.room), scene_mesh.changes(world)
    solids = scene_mesh.solid(meshes), painter.solid(meshes.posed(now.placements))
    low, high = (f(meshes.untouched.vertices, axis=0).astype(float) for f in (np.min, np.max))
    lit = camera.lights_of(world, low, high)
    fresh = kernels.Field(solids[0], meshes.hidden(now.displaced), solids[1], painter.rig(lit), None, np.zeros((0, 4)))
    for view, picture in zip(views, kept, strict=True):
        drawn = kernels.draw(
            fresh, meshes.hidden(now.displaced), painter.solid(meshes.posed(())),
            painter.Appearance.of(meshes.materials).packed(), textures.noise(), painter.curve(), painter.camera(view),
            None, True, False,
        )  # fmt: skip
        assert drawn["rgb"].tobytes() == picture.tobytes()

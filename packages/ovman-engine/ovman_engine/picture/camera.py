"""The camera: RGB, planar depth, instance ids and normals of a world.

Source of the camera model: AI2-THOR 5.0.0 (contract, section 2). World frame: Unity's, left-handed, y up; yaw 0 is along +z and
90 along +x; a positive horizon looks down. Images have row 0 at the top, and pixel centres at +0.5.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ovman_engine.paint.decor import Decor
from ovman_engine.picture import heap, lights, optics, rays, repaint, scene_mesh, sunshine, triangle_mesh
from ovman_engine.picture.painter import Appearance, Painter
from ovman_engine.picture.stage import Stage
from ovman_engine.plan.floorplan import rotation_matrix

FIXED_KEPT = 4
"""Embree scenes cached for each floor plan: one for each of the last sets of displaced objects."""


@dataclass(frozen=True)
class Onlooker:
    """What a camera other than the agent's own shows besides the scene. It looks through walls and ceiling from behind."""

    agent: bool = True
    """Whether the agent's body is visible"""
    ceiling: bool = True
    """Whether the ceiling is visible, from below"""


@dataclass(frozen=True)
class View:
    """A view of a camera. `orthographic_size` is half the height of the image in metres; None for a perspective view.

    Raises ValueError for a field of view outside (0, 180) degrees, and for an image without pixels.
    """

    position: np.ndarray
    yaw_deg: float
    horizon_deg: float = 0.0
    fov_deg: float = 90.0
    """Vertical"""
    width: int = 300
    height: int = 300
    near_m: float = 0.1
    far_m: float = 20.0
    orthographic_size: float | None = None
    roll_deg: float = 0.0
    """About the view direction, applied before the other two; a positive roll tilts the right of the image upwards"""
    sky: tuple[int, int, int] | None = None
    """sRGB, 0 to 255, of pixels without a hit; None for the default sky"""
    onlooker: Onlooker | None = None
    """None for the agent's own eye"""

    def __post_init__(self) -> None:
        """Check field of view and size."""
        if not 0 < self.fov_deg < 180:
            raise ValueError(f"a field of view lies in (0, 180) degrees, not {self.fov_deg}")
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a picture of {self.width} x {self.height} pixels cannot be drawn")

    def axes(self) -> np.ndarray:
        """Return unit vectors (3, 3) in the world frame, in rows: right, up, forward."""
        return rotation_matrix(np.array([self.horizon_deg, self.yaw_deg, self.roll_deg])).T


@dataclass(frozen=True)
class Frame:
    """The requested images of one view, H x W pixels; the others are None."""

    rgb: np.ndarray | None = None
    """(H, W, 3) uint8, sRGB"""
    depth: np.ndarray | None = None
    """(H, W) float32 metres along the view direction; far_m without a hit"""
    ids: np.ndarray | None = None
    """(H, W) int32 into `Renderer.names`; -1 without a hit"""
    normals: np.ndarray | None = None
    """(H, W, 3) float32 unit normals in the world frame, towards the viewer; 0 without a hit"""


class _Plan:
    """Shared by all renderers of one floor plan: meshes, materials, and the Embree scenes of undisplaced objects."""

    def __init__(self, world) -> None:
        self.meshes = scene_mesh.of_plan(world.plan, world.room)
        self.room = world.room
        self.looks = Appearance.of(self.meshes.materials)
        self._painted: tuple[tuple[str, str], Appearance] | None = None
        self._scenes: OrderedDict[frozenset[str], object] = OrderedDict()
        vertices = self.meshes.untouched.vertices
        self.low, self.high = vertices.min(axis=0).astype(float), vertices.max(axis=0).astype(float)

    @cached_property
    def stage(self) -> Stage:
        return Stage(self.meshes, self.room)

    def painted(self, decor: Decor) -> Appearance:
        """Materials under `decor`; the last one is cached."""
        key = (decor.finishes, decor.colours)
        if not any(key):
            return self.looks
        if self._painted is None or self._painted[0] != key:
            self._painted = key, repaint.looks(self.meshes, self.room, decor)
        return self._painted[1]

    def fixed(self, displaced: frozenset[str]):
        """Embree scene of the whole plan without the objects `displaced`."""
        if displaced not in self._scenes:
            without = [self.meshes.index(o) for o in displaced]
            changed = triangle_mesh.without(self.meshes.untouched, without) if without else None
            self._scenes[displaced] = rays.untouched(self.meshes) if changed is None else rays.committed(changed)
            while len(self._scenes) > FIXED_KEPT:
                self._scenes.popitem(last=False)
        self._scenes.move_to_end(displaced)
        return self._scenes[displaced]


_plans: OrderedDict[int, _Plan] = OrderedDict()


def _plan(world) -> _Plan:
    found = _plans.get(id(world.plan))
    if found is None or found.meshes.plan is not world.plan:
        found = _plans[id(world.plan)] = _Plan(world)
        while len(_plans) > scene_mesh.PLANS_KEPT:
            _plans.popitem(last=False)
    _plans.move_to_end(id(world.plan))
    return found


@lru_cache(maxsize=8)
def _centres(width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows (H W,) float32 of all pixel centres."""
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32) + np.float32(0.5)
    return columns.ravel(), rows.ravel()


class Renderer:
    """Draws a world and follows its changes by `world.version`. Builds nothing before the first frame."""

    def __init__(self, world) -> None:
        """Draws `world`, a world.World, in its own materials until `decor` is set."""
        self.world = world
        self.decor = Decor()
        self._drawn: int | None = None
        self._fresh = True
        self._lit: tuple[int, Decor] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in `Frame.ids`: objectIds, then structures."""
        self._follow()
        return self._mesh.names

    def _follow(self) -> None:
        if self._drawn == self.world.version:
            return
        self._shared = _plan(self.world)
        now = scene_mesh.changes(self.world)
        moved = self._shared.meshes.posed(now.placements)
        untouched = self._shared.meshes.untouched
        self._displaced, self._moved = now.displaced, moved
        self._mesh = triangle_mesh.joined(untouched, moved) if len(moved.triangles) else untouched
        self._caster = rays.Caster(self._shared.fixed(now.displaced), len(untouched.triangles), moved)
        self._drawn = self.world.version

    def _light(self) -> lights.Rig:
        if self._lit != (self.world.version, self.decor):
            low, high = self._shared.low, self._shared.high
            boxes = {o: body.box for o, body in self.world.bodies.items() if body.present and o in self.world.plan}
            rig = lights.rig(lights.of_plan(self.world.plan, low, high, boxes), low, high)
            self._rig = replace(rig, sun=sunshine.of_plan(self.world.plan, low, high, boxes, rig.exposure))
            if self.decor.lighting is not None:
                self._rig = repaint.relit(self._rig, self.decor.lighting)
            self._lit = self.world.version, self.decor
        return self._rig

    def _staged(self, view: View, looks: Appearance) -> tuple[triangle_mesh.TriangleMesh, Appearance, rays.Caster]:
        """Mesh, materials and caster for a camera other than the agent's.

        The visible part of the shell depends on the view, so the shell is a displaced object.
        """
        stage, untouched = self._shared.stage, self._shared.meshes.untouched
        extra = triangle_mesh.joined(stage.set_for(view, self.world.agent), self._moved)
        caster = rays.Caster(self._shared.fixed(self._displaced | stage.names), len(untouched.triangles), extra)
        return triangle_mesh.joined(untouched, extra), stage.looks(looks), caster

    def frame(self, view: View, rgb: bool = True, depth: bool = False, ids: bool = False, normals: bool = False) -> Frame:
        """Return the requested images of the world as it is now."""
        if not (rgb or depth or ids or normals):
            return Frame()
        self._follow()
        shape = (view.height, view.width)
        mesh, looks, caster = self._mesh, self._shared.painted(self.decor), self._caster
        if view.onlooker is not None:
            mesh, looks, caster = self._staged(view, looks)
        painter = Painter(view, mesh, looks, caster)
        hits = painter.see(*_centres(view.width, view.height))
        number, planar = np.empty(len(hits.prim), np.int32), np.empty(len(hits.prim), np.float32)
        optics.identify(hits.prim, hits.distance, mesh.instance, np.float32(view.near_m), np.float32(view.far_m), number, planar)
        picture = facing = None
        if rgb or normals:
            surface = painter.surface(hits)
            facing = surface.normals.reshape(*shape, 3) if normals else None
            if rgb:
                picture = painter.picture(hits, surface, self._light(), number, planar).reshape(*shape, 3)
                if view.sky is not None:
                    picture[(hits.prim < 0).reshape(shape)] = view.sky
        if self._fresh:  # building a new scene takes far more memory than drawing it
            heap.trim()
            self._fresh = False
        return Frame(picture, planar.reshape(shape) if depth else None, number.reshape(shape) if ids else None, facing)

"""What the robot sees of a world: RGB, planar depth, instance ids and normals.

Source of the camera model: AI2-THOR 5.0.0 (contract, section 2). World frame: Unity's, left-handed, y up; yaw 0 looks along +z
and 90 along +x; horizon is positive downwards. Images have row 0 at the top, pixel centres at +0.5.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ovman_engine.paint.decor import Decor
from ovman_engine.picture import heap, lights, optics, rays, repaint, scene_mesh, sunshine
from ovman_engine.picture.painter import Appearance, Painter
from ovman_engine.picture.stage import Stage
from ovman_engine.plan.floorplan import rotation_matrix

FIXED_KEPT = 4
"""Embree scenes kept per floor plan: one for each set of displaced objects seen lately."""


@dataclass(frozen=True)
class Onlooker:
    """What an eye that is not the agent's own sees besides the scene. It looks through the room's shell from behind."""

    agent: bool = True
    """The agent's body"""
    ceiling: bool = True
    """From below, that is"""


@dataclass(frozen=True)
class View:
    """A camera. `orthographic_size`: half the height of the picture in metres; None for a perspective view. ValueError for a
    field of view outside (0, 180) degrees or a picture without pixels."""

    position: np.ndarray
    yaw_deg: float
    horizon_deg: float = 0.0
    fov_deg: float = 90.0
    """vertical"""
    width: int = 300
    height: int = 300
    near_m: float = 0.1
    far_m: float = 20.0
    orthographic_size: float | None = None
    roll_deg: float = 0.0
    """about the view direction, applied before the other two; positive tilts the picture's right upwards"""
    sky: tuple[int, int, int] | None = None
    """sRGB, 0 to 255, where nothing is; None for the sky of all scenes"""
    onlooker: Onlooker | None = None
    """None for the agent's own eye"""

    def __post_init__(self) -> None:
        if not 0 < self.fov_deg < 180:
            raise ValueError(f"a field of view lies in (0, 180) degrees, not {self.fov_deg}")
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a picture of {self.width} x {self.height} pixels cannot be drawn")

    def axes(self) -> np.ndarray:
        """Rows right, up, forward: unit vectors (3, 3) in the world frame."""
        return rotation_matrix(np.array([self.horizon_deg, self.yaw_deg, self.roll_deg])).T


@dataclass(frozen=True)
class Frame:
    """What was asked for of one view; the rest is None. H x W pixels."""

    rgb: np.ndarray | None = None
    """(H, W, 3) uint8, sRGB"""
    depth: np.ndarray | None = None
    """(H, W) float32 metres along the view direction; far_m where nothing is"""
    ids: np.ndarray | None = None
    """(H, W) int32 into `Renderer.names`; -1 where nothing is"""
    normals: np.ndarray | None = None
    """(H, W, 3) float32 unit normals in the world frame, towards the viewer; 0 where nothing is"""


class _Plan:
    """What renderers of one floor plan share: meshes, materials, and the Embree scenes of what stays where it was."""

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
        """Materials under `decor`; the last one asked for is kept."""
        key = (decor.finishes, decor.colours)
        if not any(key):
            return self.looks
        if self._painted is None or self._painted[0] != key:
            self._painted = key, repaint.looks(self.meshes, self.room, decor)
        return self._painted[1]

    def fixed(self, displaced: frozenset[str]):
        """Embree scene of all that the plan has, without `displaced`."""
        if displaced not in self._scenes:
            without = [self.meshes.index(o) for o in displaced]
            changed = scene_mesh.without(self.meshes.untouched, without) if without else None
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
    """Draws a world. Follows its changes by `world.version`; draws nothing until a frame is asked for."""

    def __init__(self, world) -> None:
        self.world = world
        self.decor = Decor()
        self._drawn: int | None = None
        self._fresh = True
        self._lit: tuple[int, Decor] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What the numbers of `Frame.ids` stand for: objectIds, then structures."""
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
        self._mesh = scene_mesh.joined(untouched, moved) if len(moved.triangles) else untouched
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

    def _staged(self, view: View, looks: Appearance) -> tuple[scene_mesh.SceneMesh, Appearance, rays.Caster]:
        """Mesh, looks and caster for the eye of an onlooker. What the shell shows depends on the view, so it is displaced."""
        stage, untouched = self._shared.stage, self._shared.meshes.untouched
        extra = scene_mesh.joined(stage.set_for(view, self.world.agent), self._moved)
        caster = rays.Caster(self._shared.fixed(self._displaced | stage.names), len(untouched.triangles), extra)
        return scene_mesh.joined(untouched, extra), stage.looks(looks), caster

    def frame(self, view: View, rgb: bool = True, depth: bool = False, ids: bool = False, normals: bool = False) -> Frame:
        """One picture of the world as it is now, with what is asked for."""
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
        if self._fresh:  # what was made of a new scene took far more memory than its pictures will
            heap.trim()
            self._fresh = False
        return Frame(picture, planar.reshape(shape) if depth else None, number.reshape(shape) if ids else None, facing)

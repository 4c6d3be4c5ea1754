"""The camera: RGB, planar depth, instance ids and normals of a world.

Source of the camera model: AI2-THOR 5.0.0 (contract, section 2). World frame: Unity's, left-handed, y up; yaw 0 is along +z and
90 along +x; a positive horizon looks down. Images have row 0 at the top, and pixel centres at +0.5.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ovman_engine import kernels
from ovman_engine.paint import textures
from ovman_engine.paint.decor import Decor
from ovman_engine.picture import heap, lights, painter, repaint, scene_mesh, sunshine
from ovman_engine.picture.painter import Appearance
from ovman_engine.picture.stage import Stage
from ovman_engine.plan.floorplan import rotation_matrix

FIELDS_KEPT = 2
"""Rigs whose light is cached for each floor plan."""


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
    """Shared by all renderers of one floor plan: meshes, materials, and the light of the untouched scene."""

    def __init__(self, world) -> None:
        self.meshes = scene_mesh.of_plan(world.plan, world.room)
        self.solid = scene_mesh.solid(self.meshes)
        self.nothing = painter.solid(self.meshes.posed(()))
        self.room = world.room
        self.looks = Appearance.of(self.meshes.materials)
        self._painted: tuple[tuple[str, str], Appearance] | None = None
        self._fields: OrderedDict[bytes, kernels.Field] = OrderedDict()
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

    def field(self, rig: lights.Rig) -> kernels.Field:
        """Light of the untouched scene."""
        key = rig.key()
        if key not in self._fields:
            none = np.zeros((0, 4), np.float32)
            self._fields[key] = kernels.Field(self.solid, np.zeros(0, bool), self.nothing, painter.rig(rig), None, none)
            while len(self._fields) > FIELDS_KEPT:
                self._fields.popitem(last=False)
        self._fields.move_to_end(key)
        return self._fields[key]


_plans: OrderedDict[int, _Plan] = OrderedDict()


def _plan(world) -> _Plan:
    found = _plans.get(id(world.plan))
    if found is None or found.meshes.plan is not world.plan:
        found = _plans[id(world.plan)] = _Plan(world)
        while len(_plans) > scene_mesh.PLANS_KEPT:
            _plans.popitem(last=False)
    _plans.move_to_end(id(world.plan))
    return found


def lights_of(world, low: np.ndarray, high: np.ndarray) -> lights.Rig:
    """Return the lights of a world whose room spans low..high (3,) metres, in their own colours."""
    boxes = {o: body.box for o, body in world.bodies.items() if body.present and o in world.plan}
    rig = lights.rig(lights.of_plan(world.room, low, high, boxes), low, high)
    return replace(rig, sun=sunshine.of_plan(world.plan, low, high, boxes, rig.exposure))


class Renderer:
    """Draws a world and follows its changes by `world.version`. Builds nothing before the first frame."""

    def __init__(self, world) -> None:
        """Draws `world`, a world.World, in its own materials until `decor` is set."""
        self.world = world
        self.decor = Decor()
        self._drawn: int | None = None
        self._fresh = True
        self._lit: tuple[int, Decor] | None = None
        self._last_looks: tuple[Appearance, kernels.Materials] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in `Frame.ids`: objectIds, then structures."""
        self._follow()
        return self._names

    def _follow(self) -> None:
        if self._drawn == self.world.version:
            return
        self._shared = _plan(self.world)
        meshes = self._shared.meshes
        now = scene_mesh.changes(self.world)
        self._moved = meshes.posed(now.placements)
        self._names = self._moved.names
        self._hidden = meshes.hidden(now.displaced)
        self._solid = painter.solid(self._moved) if len(self._moved.triangles) else self._shared.nothing
        self._changes = scene_mesh.balls(meshes, now)
        self._field = None
        self._drawn = self.world.version

    def _light(self) -> kernels.Field:
        """Light on all surfaces as they are now."""
        if self._lit != (self.world.version, self.decor):
            low, high = self._shared.low, self._shared.high
            rig = lights_of(self.world, low, high)
            if self.decor.lighting is not None:
                rig = repaint.relit(rig, self.decor.lighting)
            field = self._shared.field(rig)
            if len(self._changes):
                field = kernels.Field(self._shared.solid, self._hidden, self._solid, painter.rig(rig), field, self._changes)
            self._field = field
            self._lit = self.world.version, self.decor
        return self._field

    def frame(self, view: View, rgb: bool = True, depth: bool = False, ids: bool = False, normals: bool = False) -> Frame:
        """Return the requested images of the world as it is now."""
        if not (rgb or depth or ids or normals):
            return Frame()
        self._follow()
        looks, hidden, extra = self._shared.painted(self.decor), self._hidden, self._shared.nothing
        if view.onlooker is not None:
            stage = self._shared.stage
            hidden = stage.hidden(view) | (hidden if len(hidden) else False)
            looks, extra = stage.looks(looks), stage.body(view, self.world.agent)
        drawn = kernels.draw(
            self._light(), hidden, extra, self._packed(looks), textures.noise(), painter.curve(), painter.camera(view), view.sky,
            rgb, normals,
        )  # fmt: skip
        if self._fresh:  # building a new scene takes far more memory than drawing it
            heap.trim()
            self._fresh = False
        return Frame(drawn["rgb"], drawn["depth"] if depth else None, drawn["ids"] if ids else None, drawn["normals"])

    def _packed(self, looks: Appearance) -> kernels.Materials:
        if self._last_looks is None or self._last_looks[0] is not looks:
            self._last_looks = looks, looks.packed()
        return self._last_looks[1]

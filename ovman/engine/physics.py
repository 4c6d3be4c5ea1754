"""Rigid bodies under gravity: MuJoCo steps what was touched, against everything else fixed.

Floor plans come with bodies that overlap (chairs in desks, things in drawers): let loose, half of them would jump apart. So a
body is fixed until something wakes it, and what it overlaps in that moment (other than the floor) does not touch it until it
sleeps again. MuJoCo's frame is right-handed with z up: its (x, y, z) are Unity's (x, z, y).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from ovman.engine.floorplan import Box

Piece = tuple
"""One convex piece of a body in the frame of its oriented box; see `shapes.collision`."""

STEP_S = 0.005
TICK_STEPS = 4
TICK_S = STEP_S * TICK_STEPS
"""AI2-THOR's fixed time step: speeds are looked at, and capped, once a tick."""
STILL_M, STILL_RAD, SLEEP_S = 0.002, 0.02, 0.2
"""A body that stays within both of one pose for this long sleeps. Speeds would not do: light things tremble where they lie."""
CAP_M_S, CAP_RAD_S = 4.0, 20.0
OVERLAP_M = 0.005
"""Deeper overlaps of a waking body with what is fixed are not contacts."""
FRICTION = (0.7, 0.005, 0.001)
"""Sliding, torsional and rolling."""
DRAG_1_S = 0.05
"""Share of its speed that a body loses to the air in a second."""
LEAST_M = 0.0005
"""Least half extent of a piece: thinner ones fall through what they lie on."""
LEAST_KG = 0.01
CHANNELS = 30
"""Collision bits that tell waking bodies apart; more bodies than this share them."""

_SWAP = np.array([0, 2, 1])
_SWAP_ROWS = _SWAP[:, None]
_ABSENT_GROUP, _AGENT_GROUP = 4, 3


@dataclass(frozen=True)
class Solid:
    """What MuJoCo has to know of one body."""

    name: str
    pieces: tuple[Piece, ...]
    mass: float
    moving: bool
    """Whether its pose can change; bodies that cannot move are part of the scene."""


def _matrix(rotation: np.ndarray) -> np.ndarray:
    return rotation[_SWAP_ROWS, _SWAP]


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    out = np.empty(4)
    mujoco.mju_mat2Quat(out, np.ascontiguousarray(_matrix(rotation)).ravel())
    return out


class Model:
    """A compiled scene in which some bodies are free."""

    def __init__(
        self,
        solids: Sequence[Solid],
        boxes: Mapping[str, Box],
        free: Collection[str],
        walls: Mapping[str, Box],
        floor_y: float,
        capsule: tuple[float, float],
    ) -> None:
        """`boxes` are the poses of all `solids`, `walls` fixed boxes, `capsule` the agent's radius and height, all in metres."""
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP_S
        spec.option.gravity = [0.0, 0.0, -9.81]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.iterations = 50
        self.free = tuple(sorted(free))
        channel = {name: 1 << (1 + k % CHANNELS) for k, name in enumerate(self.free)}
        everything = sum(1 << (1 + k) for k in range(CHANNELS))
        spec.worldbody.add_geom(
            name="Floor",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0, 0, 1],
            pos=[0, 0, floor_y],
            contype=everything,
            conaffinity=0,
            friction=FRICTION,
            condim=6,
        )
        bodies = []
        for solid in solids:
            box = boxes[solid.name]
            body = spec.worldbody.add_body(name=solid.name, pos=box.centre[_SWAP], quat=_quaternion(box.rotation))
            if solid.name in channel:
                body.add_freejoint()
                bits = (1, 1 | channel[solid.name])
            else:
                body.mocap = solid.moving
                bits = (everything, 0)
            for k, piece in enumerate(solid.pieces):
                _add(spec, body, f"{solid.name}#{k}", piece, bits)
            bodies.append(body)
        for name, box in walls.items():
            body = spec.worldbody.add_body(name=name, pos=box.centre[_SWAP], quat=_quaternion(box.rotation))
            _add(spec, body, f"{name}#", ("box", np.zeros(3), box.half, np.eye(3)), (everything, 0))
        radius, height = capsule
        agent = spec.worldbody.add_body(name="Agent", mocap=True, pos=[0, 0, -100])
        agent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[radius, height / 2 - radius, 0],
            contype=everything,
            conaffinity=0,
            group=_AGENT_GROUP,
            condim=3,
        )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._ids = {s.name: self.model.body(s.name).id for s in solids}
        self._name = [self.model.body(i).name for i in range(self.model.nbody)]
        self._name[0] = "Floor"
        self._agent = self.model.body("Agent").mocapid[0]
        self._everything = everything
        self._channel = channel
        self._bits = (self.model.geom_contype.copy(), self.model.geom_conaffinity.copy(), self.model.geom_group.copy())
        self._present = dict.fromkeys(self._ids, True)
        self._there = np.ones(self.model.ngeom, dtype=bool)
        self._fixed = self.model.geom_conaffinity == 0
        self._weigh(solids)
        self.still_s = dict.fromkeys(self.free, 0.0)
        self._rested = {name: boxes[name] for name in self.free}
        self.forward()

    def _weigh(self, solids: Sequence[Solid]) -> None:
        """Give free bodies their recorded masses; how they are spread follows the pieces."""
        model = self.model
        for solid in solids:
            if solid.name not in self._channel:
                continue
            i = self._ids[solid.name]
            scale = max(solid.mass, LEAST_KG) / model.body_mass[i]
            model.body_mass[i] *= scale
            # A needle's inertia about its own axis is too small for the time step.
            inertia = model.body_inertia[i] * scale
            model.body_inertia[i] = np.maximum(inertia, max(0.05 * inertia.max(), 1e-6))
            first = model.body_dofadr[i]
            model.dof_damping[first : first + 3] = DRAG_1_S * model.body_mass[i]
            model.dof_damping[first + 3 : first + 6] = DRAG_1_S * model.body_inertia[i].min()
        mujoco.mj_setConst(model, self.data)

    # State

    def set_box(self, name: str, box: Box, velocity: np.ndarray | None = None) -> None:
        """Put a moving body somewhere; `velocity` (6,) linear, angular, m/s and rad/s. Follow with `forward`."""
        i = self._ids[name]
        if name in self._channel:
            q, v = self.model.jnt_qposadr[self.model.body_jntadr[i]], self.model.body_dofadr[i]
            self.data.qpos[q : q + 3], self.data.qpos[q + 3 : q + 7] = box.centre[_SWAP], _quaternion(box.rotation)
            self.data.qvel[v : v + 6] = 0.0 if velocity is None else self._into_body(velocity, box.rotation)
            self.still_s[name], self._rested[name] = 0.0, box
        elif (slot := self.model.body_mocapid[i]) >= 0:
            self.data.mocap_pos[slot], self.data.mocap_quat[slot] = box.centre[_SWAP], _quaternion(box.rotation)
        else:
            self.model.body_pos[i], self.model.body_quat[i] = box.centre[_SWAP], _quaternion(box.rotation)

    def box(self, name: str, half: np.ndarray) -> tuple[Box, np.ndarray]:
        """Oriented box of a free body with half extents `half`, and its velocity (6,)."""
        i = self._ids[name]
        q, v = self.model.jnt_qposadr[self.model.body_jntadr[i]], self.model.body_dofadr[i]
        frame = np.empty(9)
        mujoco.mju_quat2Mat(frame, self.data.qpos[q + 3 : q + 7])
        frame = frame.reshape(3, 3)
        linear, spin = self.data.qvel[v : v + 3], frame @ self.data.qvel[v + 3 : v + 6]
        # Unity is left-handed: what turns one way there turns the other way here.
        velocity = np.concatenate([linear[_SWAP], -spin[_SWAP]])
        return Box(self.data.qpos[q : q + 3][_SWAP], half, _matrix(frame)), velocity

    @staticmethod
    def _into_body(velocity: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        return np.concatenate([velocity[:3][_SWAP], _matrix(rotation).T @ -velocity[3:][_SWAP]])

    def set_present(self, name: str, present: bool) -> None:
        """Whether a body is there at all."""
        if self._present[name] == present:
            return
        self._present[name] = present
        geoms = self.model.geom_bodyid == self._ids[name]
        contype, affinity, group = self._bits
        self._there[geoms] = present
        self.model.geom_contype[geoms] = contype[geoms] if present else 0
        self.model.geom_conaffinity[geoms] = affinity[geoms] if present else 0
        self.model.geom_group[geoms] = group[geoms] if present else _ABSENT_GROUP

    def set_agent(self, position: np.ndarray) -> None:
        """Put the agent's capsule with its middle at `position` (3,) metres."""
        self.data.mocap_pos[self._agent] = position[_SWAP]

    def forward(self) -> None:
        """Bring everything that follows from the state up to date."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)

    # Questions

    def below(self, point: np.ndarray, length_m: float, but: str) -> tuple[float, str] | None:
        """Height and name of the first surface within `length_m` below `point`, through the agent and the body `but`."""
        groups = np.ones(6, dtype=np.uint8)
        groups[[_ABSENT_GROUP, _AGENT_GROUP]] = 0
        geom = np.full(1, -1, dtype=np.int32)
        down = np.array([0.0, 0.0, -1.0])
        distance = mujoco.mj_ray(self.model, self.data, point[_SWAP], down, groups, 1, self._ids.get(but, -1), geom, None)
        if geom[0] < 0 or distance > length_m:
            return None
        return float(point[1] - distance), self._name[self.model.geom_bodyid[geom[0]]]

    def touching(self, name: str) -> list[tuple[str, float]]:
        """(name, depth in metres) of what a free body overlaps, deepest first."""
        i, deepest = self._ids[name], {}
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            bodies = self.model.geom_bodyid[contact.geom]
            if i in bodies:
                other = self._name[bodies[0] if bodies[1] == i else bodies[1]]
                deepest[other] = max(deepest.get(other, 0.0), -float(contact.dist))
        return sorted(deepest.items(), key=lambda item: (-item[1], item[0]))

    def overlapped(self, name: str) -> set[str]:
        """Names of the fixed bodies, floor apart, that a free body overlaps too deep for a contact."""
        found = self.touching(name)
        return {other for other, depth in found if depth > OVERLAP_M and other != "Floor" and other not in self._channel}

    def pardon(self, pairs: Mapping[str, Collection[str]]) -> None:
        """The free body on the left does not touch the fixed bodies on the right; all other pairs do touch."""
        fixed = self._fixed & self._there
        self.model.geom_contype[fixed] = self._everything
        for name, others in pairs.items():
            for other in others:
                i = self.model.body(other).id
                self.model.geom_contype[self.model.geom_bodyid == i] &= ~self._channel[name]

    # Motion

    def tick(self) -> None:
        """One tick of simulated time."""
        mujoco.mj_step(self.model, self.data, TICK_STEPS)
        for name in self.free:
            v = self.model.body_dofadr[self._ids[name]]
            for part, cap in ((slice(v, v + 3), CAP_M_S), (slice(v + 3, v + 6), CAP_RAD_S)):
                speed = float(np.linalg.norm(self.data.qvel[part]))
                if speed > cap:
                    self.data.qvel[part] *= cap / speed
            box, _ = self.box(name, np.zeros(3))
            since, turned = self._rested[name], np.trace(self._rested[name].rotation.T @ box.rotation)
            if np.linalg.norm(box.centre - since.centre) < STILL_M and turned > 1 + 2 * np.cos(STILL_RAD):
                self.still_s[name] += TICK_S
            else:
                self.still_s[name], self._rested[name] = 0.0, box

    def rouse(self, name: str) -> None:
        """A free body has to be still anew before it sleeps."""
        self.still_s[name], self._rested[name] = 0.0, self.box(name, np.zeros(3))[0]

    def sleeps(self, name: str) -> bool:
        """Whether a free body has been still for long enough."""
        return self.still_s[name] >= SLEEP_S - 1e-9

    @property
    def asleep(self) -> bool:
        """Whether every free body has been still for long enough."""
        return all(self.sleeps(name) for name in self.free)


def _add(spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, piece: Piece, bits: tuple[int, int]) -> None:
    """One piece as a geom."""
    kinds = mujoco.mjtGeom
    common = {"contype": bits[0], "conaffinity": bits[1], "friction": FRICTION, "condim": 6, "density": 500.0, "name": name}
    kind, rest = piece[0], piece[1:]
    if kind == "hull":
        vertices = rest[0][:, _SWAP]
        spread = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False)
        if spread[-1] < LEAST_M * np.sqrt(len(vertices)):
            low, high = vertices.min(axis=0), vertices.max(axis=0)
            half = np.maximum((high - low) / 2, LEAST_M)
            body.add_geom(type=kinds.mjGEOM_BOX, pos=(low + high) / 2, size=half, **common)
            return
        spec.add_mesh(
            name=name, uservert=np.ascontiguousarray(vertices).ravel(), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        )
        body.add_geom(type=kinds.mjGEOM_MESH, meshname=name, **common)
        return
    centre = np.asarray(rest[0])[_SWAP]
    if kind == "sphere":
        body.add_geom(type=kinds.mjGEOM_SPHERE, pos=centre, size=[max(rest[1], LEAST_M), 0, 0], **common)
    elif kind in ("cylinder", "capsule"):
        shape = kinds.mjGEOM_CYLINDER if kind == "cylinder" else kinds.mjGEOM_CAPSULE
        size = [max(rest[1], LEAST_M), max(rest[2], LEAST_M), 0]
        body.add_geom(type=shape, pos=centre, size=size, quat=_quaternion(rest[3]), **common)
    elif kind in ("box", "ellipsoid"):
        shape = kinds.mjGEOM_BOX if kind == "box" else kinds.mjGEOM_ELLIPSOID
        size = np.maximum(np.asarray(rest[1])[_SWAP], LEAST_M)
        body.add_geom(type=shape, pos=centre, size=size, quat=_quaternion(rest[2]), **common)
    else:
        raise ValueError(f"unknown kind of piece {kind!r}")

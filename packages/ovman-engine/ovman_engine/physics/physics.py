"""Rigid bodies under gravity: MuJoCo moves the free bodies against all others, which are fixed.

Bodies of floor plans overlap (chairs in desks, objects in drawers): if all were free, half of them would jump apart. So a body is
fixed until something wakes it, and does not collide with what it overlaps at that moment until it sleeps again.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import mujoco
import numpy as np

from ovman_engine.bodies.forms import AGENT
from ovman_engine.physics.contacts import Overlap, overlaps, struck, touching_pairs
from ovman_engine.physics.geoms import SWAP, matrix, quaternion
from ovman_engine.physics.layout import AGENT_GROUP, STEP_S, Layout, Solid
from ovman_engine.plan.floorplan import Box

TICK_STEPS = 4
TICK_S = STEP_S * TICK_STEPS
"""AI2-THOR's fixed time step: speeds are read, and limited, once a tick."""
STILL_M, STILL_RAD, SLEEP_S = 0.002, 0.02, 0.2
"""A body sleeps if it stays within both distances of one pose for this long. Speeds are no criterion: light bodies tremble."""
CAP_M_S, CAP_RAD_S = 4.0, 20.0
DRAG_1_S = 0.05
"""Fraction of its speed that a body loses to the air in a second."""
MIN_MASS_KG = 0.01

_ABSENT_GROUP = 4


class Model:
    """A compiled scene with free bodies."""

    def __init__(self, layout: Layout) -> None:
        """Wrap a compiled `model`; `solids` are its bodies."""
        self.free, self.strangers = tuple(sorted(layout.free)), layout.strangers
        solids, boxes = layout.solids, layout.boxes
        self.model = layout.model()
        self.data = mujoco.MjData(self.model)
        self._ids = {s.name: self.model.body(s.name).id for s in solids}
        self._name = [self.model.body(i).name for i in range(self.model.nbody)]
        self._name[0] = "Floor"
        self._loose = layout.free
        self._agent = self.model.body(AGENT).mocapid[0]
        self._bits = (self.model.geom_contype.copy(), self.model.geom_conaffinity.copy(), self.model.geom_group.copy())
        self._present = dict.fromkeys(self._ids, True)
        self._weigh(solids)
        self.still_s = dict.fromkeys(self.free, 0.0)
        self._rested = {name: boxes[name] for name in self.free}
        self._before = (self.data.qpos.copy(), self.data.qvel.copy())
        self.forward()

    def _weigh(self, solids: Sequence[Solid]) -> None:
        """Set the recorded masses of bodies. Their distribution follows the pieces."""
        model = self.model
        for solid in solids:
            i = self._ids[solid.name]
            scale = max(solid.mass, MIN_MASS_KG) / max(model.body_mass[i], 1e-9)
            model.body_mass[i] *= scale
            if solid.name not in self._loose:
                continue
            # The inertia of a needle about its own axis is too small for the time step.
            inertia = model.body_inertia[i] * scale
            model.body_inertia[i] = np.maximum(inertia, max(0.05 * inertia.max(), 1e-6))
            first = model.body_dofadr[i]
            model.dof_damping[first : first + 3] = DRAG_1_S * model.body_mass[i]
            model.dof_damping[first + 3 : first + 6] = DRAG_1_S * model.body_inertia[i].min()
        mujoco.mj_setConst(model, self.data)

    # State

    def set_box(self, name: str, box: Box, velocity: np.ndarray | None = None) -> None:
        """Move a body; `velocity` (6,) is linear, then angular, m/s and rad/s. Call `forward` afterwards."""
        i = self._ids[name]
        if name in self._loose:
            q, v = self.model.jnt_qposadr[self.model.body_jntadr[i]], self.model.body_dofadr[i]
            self.data.qpos[q : q + 3], self.data.qpos[q + 3 : q + 7] = box.centre[SWAP], quaternion(box.rotation)
            self.data.qvel[v : v + 6] = 0.0 if velocity is None else self._into_body(velocity, box.rotation)
            self.still_s[name], self._rested[name] = 0.0, box
        elif (slot := self.model.body_mocapid[i]) >= 0:
            self.data.mocap_pos[slot], self.data.mocap_quat[slot] = box.centre[SWAP], quaternion(box.rotation)
        else:
            self.model.body_pos[i], self.model.body_quat[i] = box.centre[SWAP], quaternion(box.rotation)

    def box(self, name: str, half: np.ndarray) -> tuple[Box, np.ndarray]:
        """Oriented box of a free body with half extents `half`, and its velocity (6,)."""
        i = self._ids[name]
        q, v = self.model.jnt_qposadr[self.model.body_jntadr[i]], self.model.body_dofadr[i]
        entries = np.empty(9)
        mujoco.mju_quat2Mat(entries, self.data.qpos[q + 3 : q + 7])
        frame = entries.reshape(3, 3)
        linear, spin = self.data.qvel[v : v + 3], frame @ self.data.qvel[v + 3 : v + 6]
        # Unity is left-handed, so angular velocities change their sign.
        velocity = np.concatenate([linear[SWAP], -spin[SWAP]])
        return Box(self.data.qpos[q : q + 3][SWAP], half, matrix(frame)), velocity

    @staticmethod
    def _into_body(velocity: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        return np.concatenate([velocity[:3][SWAP], matrix(rotation).T @ -velocity[3:][SWAP]])

    def set_present(self, name: str, present: bool) -> None:
        """Set whether a body takes part in collisions."""
        if self._present[name] == present:
            return
        self._present[name] = present
        geoms = self.model.geom_bodyid == self._ids[name]
        contype, affinity, group = self._bits
        self.model.geom_contype[geoms] = contype[geoms] if present else 0
        self.model.geom_conaffinity[geoms] = affinity[geoms] if present else 0
        self.model.geom_group[geoms] = group[geoms] if present else _ABSENT_GROUP

    def set_agent(self, position: np.ndarray) -> None:
        """Put the centre of the agent's capsule at `position` (3,) metres."""
        self.data.mocap_pos[self._agent] = position[SWAP]

    def forward(self) -> None:
        """Recomputes everything that follows from the state."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)

    # Queries

    def below(self, point: np.ndarray, length_m: float, but: str) -> tuple[float, str] | None:
        """Height and name of the first surface within `length_m` below `point`, ignoring the agent and the body `but`."""
        groups = np.ones(6, dtype=np.uint8)
        groups[[_ABSENT_GROUP, AGENT_GROUP]] = 0
        geom = np.full(1, -1, dtype=np.int32)
        down = np.array([0.0, 0.0, -1.0])
        distance = mujoco.mj_ray(self.model, self.data, point[SWAP], down, groups, 1, self._ids.get(but, -1), geom, None)
        if geom[0] < 0 or distance > length_m:
            return None
        return float(point[1] - distance), self._name[self.model.geom_bodyid[geom[0]]]

    def overlaps(self, name: str) -> list[Overlap]:
        """Overlaps of a free body, one for each other body, deepest first."""
        return overlaps(self.model, self.data, self._name, self._ids[name])

    def touching(self, name: str) -> list[tuple[str, float]]:
        """(name, depth in metres) of what a free body overlaps, deepest first."""
        return [(o.other, o.depth) for o in self.overlaps(name)]

    def struck(self, light: Collection[str]) -> set[str]:
        """Which of the fixed bodies `light` an impact of the last tick would move."""
        numbers = {self._ids[name] for name in light}
        hit = (struck(self.model, self.data, *self._before, self._ids[name], numbers) for name in self.free)
        return {self._name[i] for found in hit for i in found}

    def heaps(self) -> list[set[str]]:
        """Set of free bodies that touch each other."""
        out = [{name} for name in self.free]
        for first, second in sorted(touching_pairs(self.model, self.data)):
            pair = {self._name[first], self._name[second]}
            if pair <= self._loose:
                joined = [heap for heap in out if heap & pair]
                out = [heap for heap in out if not heap & pair] + [set().union(*joined)]
        return out

    # Motion

    def tick(self) -> None:
        """Simulate one tick. Call `watch` to accept it, or `undo`."""
        self._before = (self.data.qpos.copy(), self.data.qvel.copy())
        mujoco.mj_step(self.model, self.data, TICK_STEPS)
        for name in self.free:
            v = self.model.body_dofadr[self._ids[name]]
            for part, cap in ((slice(v, v + 3), CAP_M_S), (slice(v + 3, v + 6), CAP_RAD_S)):
                speed = float(np.linalg.norm(self.data.qvel[part]))
                if speed > cap:
                    self.data.qvel[part] *= cap / speed

    def undo(self) -> None:
        """Restores the state before the last tick."""
        self.data.qpos[:], self.data.qvel[:] = self._before

    def watch(self) -> None:
        """Update how long each free body has been still."""
        for name in self.free:
            box, _ = self.box(name, np.zeros(3))
            since, turned = self._rested[name], np.trace(self._rested[name].rotation.T @ box.rotation)
            if np.linalg.norm(box.centre - since.centre) < STILL_M and turned > 1 + 2 * np.cos(STILL_RAD):
                self.still_s[name] += TICK_S
            else:
                self.still_s[name], self._rested[name] = 0.0, box

    def rouse(self, name: str) -> None:
        """Restarts the time for which a free body has been still."""
        self.still_s[name], self._rested[name] = 0.0, self.box(name, np.zeros(3))[0]

    def sleeps(self, name: str) -> bool:
        """Whether a free body has been still for long enough to sleep."""
        return self.still_s[name] >= SLEEP_S - 1e-9

    @property
    def asleep(self) -> bool:
        """Whether all free bodies have been still for long enough to sleep."""
        return all(self.sleeps(name) for name in self.free)

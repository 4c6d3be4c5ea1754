"""A scene for cameras other than the agent's: it shows the agent, and is open on the side of the camera.

AI2-THOR's walls and ceilings have faces on the inside only; a camera outside looks through them. World frame as in `floorplan`.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ovman_engine import kernels
from ovman_engine.bodies.embodiment import DEFAULT
from ovman_engine.picture import agent_body, painter
from ovman_engine.picture.painter import Appearance
from ovman_engine.picture.scene_mesh import PlanMeshes
from ovman_engine.picture.triangle_mesh import figure
from ovman_engine.plan.floorplan import Box, rotation_matrix

SHELL = frozenset({"wall", "door", "ceiling"})
"""Structures that enclose the room."""
BEYOND_M = 1e-3
"""A face that looks away from the room this far beyond its limits is the back of a wall."""
THICKEST_M = 0.1
"""Depth behind the face of a wall inside the room from which nothing is visible."""


class Stage:
    """The shell of a floor plan's room, triangle by triangle, and the agent's body."""

    def __init__(self, meshes: PlanMeshes, room) -> None:
        """`room`: room.Room of the plan."""
        self._mesh = meshes.untouched
        names = meshes.untouched.names
        of_plan = len(meshes.plan.objects)
        numbers = [i for i, name in enumerate(names) if i >= of_plan and name.split("|", 1)[0] in SHELL]
        corners = self._mesh.vertices[self._mesh.triangles].astype(float)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normals, axis=1)
        self._shell = np.isin(self._mesh.instance, numbers)
        shell = self._shell & (length > 0)
        centres, normals = corners.mean(axis=1), normals / np.where(length > 0, length, 1.0)[:, None]
        shell[shell] &= ~_is_back(centres[shell], normals[shell], room)
        ceilings = [i for i in numbers if names[i].startswith("ceiling|")]
        # of the ceiling and its lamps only what faces down: a camera above looks through them
        shell &= ~np.isin(self._mesh.instance, ceilings) | (normals[:, 1] < -0.5)
        self._triangles = np.flatnonzero(shell)
        self._centres, self._normals = centres[shell], normals[shell]
        self._ceiling = np.isin(self._mesh.instance[self._triangles], ceilings)
        self._last_body: tuple[tuple, kernels.Solid] | None = None
        self._nothing = painter.solid(meshes.posed(()))
        slots = dict.fromkeys(part.slot for part in agent_body.parts(DEFAULT, standing=True))
        self._paint = Appearance.of(agent_body.PALETTE[slot] for slot in slots)

    def hidden(self, view) -> np.ndarray:
        """(T,) bool: the triangles of the plan that a camera.View hides: backs of the shell, and the ceiling where asked."""
        if view.orthographic_size is None:
            facing = ((np.asarray(view.position) - self._centres) * self._normals).sum(axis=1) > 0
        else:
            facing = self._normals @ view.axes()[2] < 0
        mask = self._shell.copy()
        mask[self._triangles[facing & (view.onlooker.ceiling | ~self._ceiling)]] = False
        return mask

    def body(self, view, agent) -> kernels.Solid:
        """Return the body of a body.Agent, whose instance is -1; nothing where `view` shows no body, or lies within it.

        The body's materials, which `looks` gives, follow those of the plan.
        """
        if not view.onlooker.agent or agent_body.encloses(agent, np.asarray(view.position)):
            return self._nothing
        return self._body(agent)

    def looks(self, plan: Appearance) -> Appearance:
        """Return the materials of the plan, followed by those of the body."""
        pairs = ((getattr(plan, f.name), getattr(self._paint, f.name)) for f in fields(Appearance))
        return Appearance(*(np.concatenate(pair) for pair in pairs))

    def _body(self, agent) -> kernels.Solid:
        key = (agent.embodiment, agent.standing, *np.round(agent.position, 6).tolist(), agent.yaw_deg)
        if self._last_body is None or self._last_body[0] != key:
            box = Box(np.asarray(agent.position, dtype=float), np.ones(3), rotation_matrix(np.array([0.0, agent.yaw_deg, 0.0])))
            parts = agent_body.parts(agent.embodiment, agent.standing)
            self._last_body = key, painter.solid(figure(parts, agent_body.PALETTE, box, self._mesh))
        return self._last_body[1]


def _is_back(centres: np.ndarray, normals: np.ndarray, room) -> np.ndarray:
    """(N,) bool: which triangles (N, 3) of the shell cannot be seen from inside the room."""
    x_0, z_0, x_1, z_1 = room.outline
    low, high = np.array([x_0, room.floor_y, z_0]), np.array([x_1, room.ceiling_y, z_1])
    back = ((normals > 0.5) & (centres > high + BEYOND_M)).any(axis=1)
    back |= ((normals < -0.5) & (centres < low - BEYOND_M)).any(axis=1)
    for block in room.blocks:
        if np.isfinite(block.thick):
            continue
        along, across = (2, 0) if block.axis == 0 else (0, 2)
        depth = block.outwards * (centres[:, across] - block.plane)
        within = (centres[:, along] > block.low - BEYOND_M) & (centres[:, along] < block.high + BEYOND_M)
        away = block.outwards * normals[:, across] > 0.5
        back |= within & (((depth > BEYOND_M) & away) | (depth > THICKEST_M - BEYOND_M) & ~_on_end(centres, along, block))
    return np.asarray(back)


def _on_end(centres: np.ndarray, along: int, block) -> np.ndarray:
    """(N,) bool: whether triangles are on the sides of a block, which are visible from the room beside it."""
    return np.minimum(np.abs(centres[:, along] - block.low), np.abs(centres[:, along] - block.high)) < BEYOND_M

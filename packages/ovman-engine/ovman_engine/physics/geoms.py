"""Conversion to MuJoCo: frames, quaternions, and one geom for each convex piece.

MuJoCo's frame is right-handed with z up: its (x, y, z) are Unity's (x, z, y).
"""

from __future__ import annotations

import mujoco
import numpy as np

Piece = tuple
"""One convex piece of a body in the frame of its oriented box; see `shapes.collision`."""

FRICTION = (0.7, 0.005, 0.002)
"""Sliding, torsional and rolling friction."""
MIN_M = 0.0005
"""Least half extent of a piece: thinner ones fall through their support."""

SWAP = np.array([0, 2, 1])
"""Index that converts a vector from either frame to the other."""
_SWAP_ROWS = SWAP[:, None]


def matrix(rotation: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) of either frame, in the other."""
    return rotation[_SWAP_ROWS, SWAP]


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """MuJoCo's quaternion (4,) of a rotation (3, 3) of Unity's frame."""
    out = np.empty(4)
    mujoco.mju_mat2Quat(out, np.ascontiguousarray(matrix(rotation)).ravel())
    return out


def add(spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, piece: Piece, contype: int, conaffinity: int) -> None:
    """Add a piece to `body` as a geom. Raises ValueError for an unknown kind of piece."""
    kinds = mujoco.mjtGeom
    common = {
        "contype": contype,
        "conaffinity": conaffinity,
        "friction": FRICTION,
        "condim": 6,
        "density": 500.0,
        "name": name,
    }
    kind, rest = piece[0], piece[1:]
    if kind == "hull":
        _add_hull(spec, body, rest[0][:, SWAP], common)
        return
    centre = np.asarray(rest[0])[SWAP]
    if kind == "sphere":
        body.add_geom(type=kinds.mjGEOM_SPHERE, pos=centre, size=[max(rest[1], MIN_M), 0, 0], **common)
    elif kind in ("cylinder", "capsule"):
        shape = kinds.mjGEOM_CYLINDER if kind == "cylinder" else kinds.mjGEOM_CAPSULE
        size = [max(rest[1], MIN_M), max(rest[2], MIN_M), 0]
        body.add_geom(type=shape, pos=centre, size=size, quat=quaternion(rest[3]), **common)
    elif kind in ("box", "ellipsoid"):
        shape = kinds.mjGEOM_BOX if kind == "box" else kinds.mjGEOM_ELLIPSOID
        size = np.maximum(np.asarray(rest[1])[SWAP], MIN_M)
        body.add_geom(type=shape, pos=centre, size=size, quat=quaternion(rest[2]), **common)
    else:
        raise ValueError(f"unknown kind of piece {kind!r}")


def _add_hull(spec: mujoco.MjSpec, body: mujoco.MjsBody, vertices: np.ndarray, common: dict) -> None:
    """Add a convex hull. A flat hull has no volume and is added as a box."""
    spread = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False)
    if spread[-1] < MIN_M * np.sqrt(len(vertices)):
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        half = np.maximum((high - low) / 2, MIN_M)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=(low + high) / 2, size=half, **common)
        return
    spec.add_mesh(
        name=common["name"],
        uservert=np.ascontiguousarray(vertices).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
    )
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=common["name"], **common)

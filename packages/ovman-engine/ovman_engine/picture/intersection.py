"""Where a ray meets a triangle, by arithmetic of our own: Embree searches its tree and asks here about each triangle on the way.

Embree's own test of a triangle depends on the processor in its last bits: in the distance, for which it divides by an approximate
reciprocal, in the side of an edge on which a ray passes, and in which it keeps of several triangles at one distance. Here every
product and quotient is one of double precision, and of triangles at one distance the first in number is met.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import carray, cfunc, njit, types
from numba.extending import intrinsic

MARGIN_M = np.float32(1e-4)
"""Boxes in Embree's tree are larger by this on each side than their triangles, more than Embree's rounding on a floor plan."""
_ORIGIN, _WAY, _REACH, _U, _V, _TRIANGLE, _MESH = 0, 4, 8, 15, 16, 17, 18
"""Rows of an RTCRayHitN. An RTCRayN has those up to _REACH at the same places."""
_ANY = 1 << 28
"""Length of the arrays over Embree's memory: none that a valid number exceeds."""


def _pointer(kind: ir.Type, item: types.Type):
    """Return an intrinsic that gives the pointer to `item` of an address."""

    @intrinsic
    def at(_typing, address):
        def generate(_context, builder, _signature, values):
            return builder.inttoptr(values[0], kind.as_pointer())

        return types.CPointer(item)(types.int64), generate

    return at


_floats = _pointer(ir.FloatType(), types.float32)
_integers = _pointer(ir.IntType(32), types.int32)
_words = _pointer(ir.IntType(64), types.int64)


@njit(cache=True, error_model="numpy", inline="always")
def _triangle(mesh, number):
    """Return the corners, each (x, y, z) in double precision, of a triangle of an embree.Scene.

    `mesh`: address of its addresses.
    """
    addresses = carray(_words(mesh), 2)
    points, corners = carray(_floats(addresses[0]), _ANY), carray(_integers(addresses[1]), _ANY)
    a, b, c = 3 * np.int64(corners[3 * number]), 3 * np.int64(corners[3 * number + 1]), 3 * np.int64(corners[3 * number + 2])
    return (
        (np.float64(points[a]), np.float64(points[a + 1]), np.float64(points[a + 2])),
        (np.float64(points[b]), np.float64(points[b + 1]), np.float64(points[b + 2])),
        (np.float64(points[c]), np.float64(points[c + 1]), np.float64(points[c + 2])),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _meeting(numbers, lanes, k, triangle):
    """Return (distance, u, v) at which the ray of a lane meets a triangle (Moeller and Trumbore 1997), in double precision.

    The distance is in lengths of the ray's direction, NaN where it misses; u and v are the barycentric coordinates of the second
    and third corner.
    """
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    ex, ey, ez, fx, fy, fz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    wx = np.float64(numbers[_WAY * lanes + k])
    wy = np.float64(numbers[(_WAY + 1) * lanes + k])
    wz = np.float64(numbers[(_WAY + 2) * lanes + k])
    sx, sy, sz = (
        numbers[_ORIGIN * lanes + k] - ax,
        numbers[(_ORIGIN + 1) * lanes + k] - ay,
        numbers[(_ORIGIN + 2) * lanes + k] - az,
    )
    px, py, pz = wy * fz - wz * fy, wz * fx - wx * fz, wx * fy - wy * fx
    qx, qy, qz = sy * ez - sz * ey, sz * ex - sx * ez, sx * ey - sy * ex
    inverse = 1.0 / (ex * px + ey * py + ez * pz)
    u, v = (sx * px + sy * py + sz * pz) * inverse, (wx * qx + wy * qy + wz * qz) * inverse
    distance = (fx * qx + fy * qy + fz * qz) * inverse
    return distance if u >= 0 and v >= 0 and u + v <= 1 and distance > 0 else np.nan, u, v


@cfunc(types.void(types.CPointer(types.int64)), cache=True, error_model="numpy")
def bounds(arguments):
    """RTCBoundsFunction: the box of a triangle. Words of the arguments: mesh; number and time step; box."""
    words = carray(arguments, 3)
    corners, box = _triangle(words[0], words[1] & 0xFFFFFFFF), carray(_floats(words[2]), 8)
    for a in range(3):
        x, y, z = corners[0][a], corners[1][a], corners[2][a]
        box[a], box[4 + a] = np.float32(min(x, y, z)) - MARGIN_M, np.float32(max(x, y, z)) + MARGIN_M


@cfunc(types.void(types.CPointer(types.int64)), cache=True, error_model="numpy")
def intersect(arguments):
    """RTCIntersectFunctionN: notes a triangle in the lanes whose rays meet it first so far.

    Words of the arguments: active lanes; mesh; number; context; packet; lanes and geomID.
    """
    words = carray(arguments, 6)
    number, lanes, mesh = words[2] & 0xFFFFFFFF, words[5] & 0xFFFFFFFF, words[5] >> 32
    active, numbers, bits = carray(_integers(words[0]), _ANY), carray(_floats(words[4]), _ANY), carray(_integers(words[4]), _ANY)
    triangle = _triangle(words[1], number)
    for k in range(lanes):
        if active[k] != 0:
            meeting, u, v = _meeting(numbers, lanes, k, triangle)
            distance, best = np.float32(meeting), numbers[_REACH * lanes + k]
            rival = np.int64(bits[_MESH * lanes + k]), np.int64(bits[_TRIANGLE * lanes + k])
            if distance < best or (distance == best and (mesh, number) < rival):
                numbers[_REACH * lanes + k], numbers[_U * lanes + k], numbers[_V * lanes + k] = distance, u, v
                bits[_TRIANGLE * lanes + k], bits[_MESH * lanes + k] = number, mesh


@cfunc(types.void(types.CPointer(types.int64)), cache=True, error_model="numpy")
def occlude(arguments):
    """RTCOccludedFunctionN: gives the lanes whose rays meet a triangle a negative reach. Arguments are those of `intersect`."""
    words = carray(arguments, 6)
    number, lanes = words[2] & 0xFFFFFFFF, words[5] & 0xFFFFFFFF
    active, numbers = carray(_integers(words[0]), _ANY), carray(_floats(words[4]), _ANY)
    triangle = _triangle(words[1], number)
    for k in range(lanes):
        if active[k] != 0 and _meeting(numbers, lanes, k, triangle)[0] <= numbers[_REACH * lanes + k]:
            numbers[_REACH * lanes + k] = -np.inf

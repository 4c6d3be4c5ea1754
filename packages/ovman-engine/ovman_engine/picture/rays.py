"""Casts rays on Embree against two scenes: one of all undisplaced objects, and one of the displaced objects.

A movement rebuilds only the second, small scene. Each packet is cast into it directly afterwards, up to the hits in the first.
Kernels call Embree by the address of its function, so numba can cache them. Embree in turn calls kernels, for each triangle that
a ray may meet (intersection.py).
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from ovman_engine.picture import embree
from ovman_engine.picture.scene_mesh import PlanMeshes
from ovman_engine.picture.triangle_mesh import TriangleMesh

FAR = np.float32(1e30)
SIDE = 4
"""Columns of the rectangle of pixels that a packet of primary rays covers."""
_ORIGIN, _NEAR, _WAY, _TIME, _REACH, _MASK, _NUMBER, _FLAGS, _U, _V, _TRIANGLE, _MESH = 0, 3, 4, 7, 8, 9, 10, 11, 15, 16, 17, 18
"""Rows of an RTCRayHit16 or an RTCRayHit8."""
_FIXED, _DISPLACED = 0, 1
"""geomIDs of the two scenes."""


@intrinsic
def _query(_typing, function, valid, scene, packet, arguments):
    """Call one of Embree's functions for packets; all arguments are addresses."""

    def generate(context, builder, _signature, values):
        byte = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [byte] * 4)
        function = builder.inttoptr(values[0], kind.as_pointer())
        builder.call(function, [builder.inttoptr(value, byte) for value in values[1:]])
        return context.get_dummy_value()

    return types.void(*[types.intp] * 5), generate


@njit(cache=True, error_model="numpy")
def _clear(numbers, bits):
    """Set the fields of a packet that no cast changes."""
    lanes = numbers.shape[1]
    for k in range(lanes):
        numbers[_NEAR, k], numbers[_TIME, k] = np.float32(0), np.float32(0)
        bits[_MASK, k], bits[_NUMBER, k], bits[_FLAGS, k] = -1, 0, 0


@njit(cache=True, error_model="numpy")
def _view(function, fixed, displaced, valid, numbers, bits, arguments, offset, right, up, forward, tan_x, tan_y, eye, near, flat,
          reach, width, height, triangle, distance, u, v):  # fmt: skip
    """Compute the hits of all pixels of a view, in tiles.

    See optics.primary for the camera, Caster.closest for the results.
    """
    lanes = len(valid)
    _clear(numbers, bits)
    (right_x, right_y, right_z), (up_x, up_y, up_z), (on_x, on_y, on_z) = right, up, forward
    eye_x, eye_y, eye_z = eye
    columns, rows = np.empty(width, np.float32), np.empty(height, np.float32)
    for i in range(width):
        columns[i] = (np.float32(2) * (np.float32(i) + np.float32(0.5)) / np.float32(width) - np.float32(1)) * tan_x
    for j in range(height):
        rows[j] = (np.float32(1) - np.float32(2) * (np.float32(j) + np.float32(0.5)) / np.float32(height)) * tan_y
    for top in range(0, height, lanes // SIDE):
        for left in range(0, width, SIDE):
            for k in range(lanes):
                i, j = left + k % SIDE, top + k // SIDE
                valid[k] = -1 if i < width and j < height else 0
                x, y = columns[min(i, width - 1)], rows[min(j, height - 1)]
                aside_x, aside_y, aside_z = right_x * x + up_x * y, right_y * x + up_y * y, right_z * x + up_z * y
                if flat:
                    numbers[_WAY, k], numbers[_WAY + 1, k], numbers[_WAY + 2, k] = on_x, on_y, on_z
                    numbers[_ORIGIN, k] = eye_x + near * on_x + aside_x
                    numbers[_ORIGIN + 1, k] = eye_y + near * on_y + aside_y
                    numbers[_ORIGIN + 2, k] = eye_z + near * on_z + aside_z
                else:
                    way_x, way_y, way_z = aside_x + on_x, aside_y + on_y, aside_z + on_z
                    numbers[_WAY, k], numbers[_WAY + 1, k], numbers[_WAY + 2, k] = way_x, way_y, way_z
                    numbers[_ORIGIN, k] = eye_x + near * way_x
                    numbers[_ORIGIN + 1, k] = eye_y + near * way_y
                    numbers[_ORIGIN + 2, k] = eye_z + near * way_z
                numbers[_REACH, k] = reach
                bits[_MESH, k] = -1
            if fixed != 0:
                _query(function, valid.ctypes.data, fixed, bits.ctypes.data, arguments.ctypes.data)
            if displaced != 0:
                _query(function, valid.ctypes.data, displaced, bits.ctypes.data, arguments.ctypes.data)
            for k in range(lanes):
                if valid[k] != 0:
                    n = (top + k // SIDE) * width + left + k % SIDE
                    mesh = bits[_MESH, k]
                    triangle[n] = -1 if mesh < 0 else bits[_TRIANGLE, k] + (offset if mesh == _DISPLACED else 0)
                    distance[n], u[n], v[n] = numbers[_REACH, k], numbers[_U, k], numbers[_V, k]


@njit(cache=True, error_model="numpy", inline="always")
def _load(origins, ways, first, valid, numbers):
    """Load the rays first to first + lanes into a packet; lanes beyond the last ray are inactive."""
    lanes = len(valid)
    for k in range(lanes):
        i = min(first + k, len(origins) - 1)
        valid[k] = -1 if first + k < len(origins) else 0
        for a in range(3):
            numbers[_ORIGIN + a, k], numbers[_WAY + a, k] = origins[i, a], ways[i, a]


@njit(cache=True, error_model="numpy")
def _closest(function, fixed, displaced, valid, numbers, bits, arguments, offset, origins, ways, triangle, distance, u, v):
    """See Caster.closest."""
    lanes = len(valid)
    _clear(numbers, bits)
    for first in range(0, len(origins), lanes):
        _load(origins, ways, first, valid, numbers)
        for k in range(lanes):
            numbers[_REACH, k] = FAR
            bits[_MESH, k] = -1
        if fixed != 0:
            _query(function, valid.ctypes.data, fixed, bits.ctypes.data, arguments.ctypes.data)
        if displaced != 0:
            _query(function, valid.ctypes.data, displaced, bits.ctypes.data, arguments.ctypes.data)
        for k in range(min(lanes, len(origins) - first)):
            n, mesh = first + k, bits[_MESH, k]
            triangle[n] = -1 if mesh < 0 else bits[_TRIANGLE, k] + (offset if mesh == _DISPLACED else 0)
            distance[n], u[n], v[n] = numbers[_REACH, k], numbers[_U, k], numbers[_V, k]


@njit(cache=True, error_model="numpy")
def _occluded(function, fixed, displaced, valid, numbers, bits, arguments, origins, ways, reach, blocked):
    """See Caster.occluded."""
    lanes = len(valid)
    _clear(numbers, bits)
    for first in range(0, len(origins), lanes):
        _load(origins, ways, first, valid, numbers)
        for k in range(lanes):
            numbers[_REACH, k] = reach[min(first + k, len(origins) - 1)]
        if fixed != 0:
            _query(function, valid.ctypes.data, fixed, bits.ctypes.data, arguments.ctypes.data)
        if displaced != 0:
            _query(function, valid.ctypes.data, displaced, bits.ctypes.data, arguments.ctypes.data)
        for k in range(min(lanes, len(origins) - first)):
            blocked[first + k] = numbers[_REACH, k] < 0


def committed(mesh: TriangleMesh, number: int = _FIXED) -> embree.Scene:
    """Return the Embree scene of a mesh."""
    return embree.Scene(mesh.vertices, mesh.triangles, number)


_untouched: WeakKeyDictionary[PlanMeshes, embree.Scene] = WeakKeyDictionary()


def untouched(meshes: PlanMeshes) -> embree.Scene:
    """Return the Embree scene of an untouched floor plan, shared by the camera and the agent's visibility."""
    if meshes not in _untouched:
        _untouched[meshes] = committed(meshes.untouched)
    return _untouched[meshes]


class Caster:
    """Casts rays into a fixed and a displaced scene. Triangles of the second are numbered after those of the first."""

    def __init__(self, fixed: embree.Scene, offset: int, displaced: TriangleMesh) -> None:
        """`offset`: number of triangles of the fixed mesh."""
        self._fixed, self._displaced = fixed, committed(displaced, _DISPLACED)
        self._offset = np.int32(offset)
        self._packet = embree.Packet.new()

    def _call(self, name: str, coherent: bool) -> tuple[object, ...]:
        packet = self._packet
        scenes = (self._fixed.handle, self._displaced.handle)
        arguments = packet.coherent if coherent else packet.scattered
        return embree.entry(name), *scenes, packet.valid, packet.numbers, packet.bits, arguments

    def view(self, right, up, forward, tan_x, tan_y, eye, near, flat, reach, width, height):
        """`closest` of the primary rays of a view (optics.primary), one for each pixel, row by row.

        Hits farther than `reach` lengths of the ray do not count.
        """
        count = width * height
        triangle, distance = np.empty(count, np.int32), np.empty(count, np.float32)
        u, v = np.empty(count, np.float32), np.empty(count, np.float32)
        _view(
            *self._call("rtcIntersect", True), self._offset, right, up, forward, tan_x, tan_y, eye, near, flat, reach,
            width, height, triangle, distance, u, v,
        )  # fmt: skip
        return triangle, distance, u, v

    def closest(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the first hit of each ray (N, 3) float32.

        Triangle (N,) int32 (-1 for none), distance in lengths of the direction (N,) float32 (at least 1e30 for none), and two
        barycentric coordinates (N,) float32.
        """
        count = len(origins)
        triangle, distance = np.empty(count, np.int32), np.empty(count, np.float32)
        u, v = np.empty(count, np.float32), np.empty(count, np.float32)
        _closest(*self._call("rtcIntersect", True), self._offset, origins, directions, triangle, distance, u, v)
        return triangle, distance, u, v

    def occluded(self, origins: np.ndarray, directions: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(N,) bool: whether each ray (N, 3) float32 has a hit before `reach` (N,) float32, in lengths of the direction."""
        blocked = np.empty(len(origins), bool)
        _occluded(*self._call("rtcOccluded", False), origins, directions, reach, blocked)
        return blocked

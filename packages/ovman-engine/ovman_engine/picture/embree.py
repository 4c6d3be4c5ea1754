"""Embree's C interface, from the library that embreex ships: scenes of triangles, and the addresses that kernels call.

embreex itself casts single rays. The rays of a view are coherent: in packets they cost a fifth of the time, and hit the same
triangles. Source of names and layouts: Embree 4, rtcore.h.
"""

from __future__ import annotations

import ctypes
import weakref
from dataclasses import dataclass
from functools import cache

import numpy as np

from ovman_engine.picture import intersection

WIDEST, NARROWEST = 16, 8
"""Rays of a packet, on processors with AVX-512 and on others."""
ROWS = 22
"""Rows of 32-bit words, one a ray, that an RTCRayHit16 or an RTCRayHit8 may have, with instances."""
_NATIVE_WIDEST = 34
"""RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED"""
COHERENT = 1 << 16
"""RTC_RAY_QUERY_FLAG_COHERENT"""
EVERYTHING = 0xFFFFFFFF
"""RTC_FEATURE_FLAG_ALL"""
_USER = 120
"""RTC_GEOMETRY_TYPE_USER"""
_LOW = 0
"""RTC_BUILD_QUALITY_LOW: builds in half the time, and packets are as fast"""
_BYTES = 64
"""Alignment of packets."""


@cache
def _library() -> ctypes.CDLL:
    """Return the Embree library that embreex is linked with; the dynamic linker finds it among the dependencies of embreex."""
    from embreex import rtcore_scene

    library = ctypes.CDLL(rtcore_scene.__file__)
    pointer, number = ctypes.c_void_p, ctypes.c_uint
    signatures = {
        "rtcNewDevice": (pointer, ctypes.c_char_p),
        "rtcGetDeviceError": (ctypes.c_int, pointer),
        "rtcGetDeviceProperty": (ctypes.c_ssize_t, pointer, ctypes.c_int),
        "rtcNewScene": (pointer, pointer),
        "rtcSetSceneBuildQuality": (None, pointer, ctypes.c_int),
        "rtcCommitScene": (None, pointer),
        "rtcReleaseScene": (None, pointer),
        "rtcNewGeometry": (pointer, pointer, ctypes.c_int),
        "rtcSetGeometryUserPrimitiveCount": (None, pointer, number),
        "rtcSetGeometryUserData": (None, pointer, pointer),
        "rtcSetGeometryBoundsFunction": (None, pointer, pointer, pointer),
        "rtcSetGeometryIntersectFunction": (None, pointer, pointer),
        "rtcSetGeometryOccludedFunction": (None, pointer, pointer),
        "rtcCommitGeometry": (None, pointer),
        "rtcAttachGeometryByID": (None, pointer, pointer, number),
        "rtcReleaseGeometry": (None, pointer),
    }
    for name, (result, *arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


@cache
def _device() -> int:
    """Return the device of the process, without threads of its own: an engine uses one core."""
    device = _library().rtcNewDevice(b"threads=1")
    if not device:
        raise RuntimeError(f"Embree does not start: error {_library().rtcGetDeviceError(None)}")
    return device


@cache
def lanes() -> int:
    """Rays of the widest packet that Embree has kernels for on this processor: wider ones it casts one ray after the other."""
    return WIDEST if _library().rtcGetDeviceProperty(_device(), _NATIVE_WIDEST) else NARROWEST


@cache
def entry(name: str) -> int:
    """Address of Embree's function "rtcIntersect" or "rtcOccluded" for packets of `lanes`, for kernels."""
    return ctypes.cast(getattr(_library(), f"{name}{lanes()}"), ctypes.c_void_p).value or 0


class Scene:
    """A built Embree scene of one triangle mesh, whose triangles intersection.py tests.

    `handle` is its address, for kernels; 0 for a mesh without triangles.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, number: int = 0) -> None:
        """Build a scene of vertices (V, 3) float32 and triangles (T, 3) int32, which must not be written to afterwards.

        No ray meets a triangle with infinite or NaN vertices.

        Hits report `number` as geomID. Raises RuntimeError if Embree reports an error.
        """
        self.handle = 0
        if len(triangles) == 0:
            return
        library, device = _library(), _device()
        self._vertices = np.ascontiguousarray(vertices, np.float32)
        self._triangles = np.ascontiguousarray(triangles, np.int32)
        self._addresses = np.array([self._vertices.ctypes.data, self._triangles.ctypes.data])
        self.handle = library.rtcNewScene(device)
        self._release = weakref.finalize(self, library.rtcReleaseScene, self.handle)
        self._release.atexit = False
        library.rtcSetSceneBuildQuality(self.handle, _LOW)
        geometry = library.rtcNewGeometry(device, _USER)
        library.rtcSetGeometryUserPrimitiveCount(geometry, len(triangles))
        library.rtcSetGeometryUserData(geometry, self._addresses.ctypes.data)
        library.rtcSetGeometryBoundsFunction(geometry, intersection.bounds.address, None)
        library.rtcSetGeometryIntersectFunction(geometry, intersection.intersect.address)
        library.rtcSetGeometryOccludedFunction(geometry, intersection.occlude.address)
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometryByID(self.handle, geometry, number)
        library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self.handle)
        if error := library.rtcGetDeviceError(device):
            raise RuntimeError(f"Embree refuses a scene of {len(triangles)} triangles: error {error}")


def _aligned(words: int) -> np.ndarray:
    """(words,) int32 at an address aligned for packets."""
    raw = np.zeros(4 * words + _BYTES, np.uint8)
    start = -raw.ctypes.data % _BYTES
    return raw[start : start + 4 * words].view(np.int32)


@dataclass(frozen=True)
class Packet:
    """Memory of a packet of `lanes` rays.

    It has the active lanes (lanes,) int32 (-1 for active), the rows (ROWS, lanes) as numbers and as bits, and the arguments of
    queries for coherent and for scattered rays.
    """

    valid: np.ndarray
    numbers: np.ndarray
    bits: np.ndarray
    coherent: np.ndarray
    scattered: np.ndarray

    @staticmethod
    def new() -> Packet:
        """Return an empty packet."""
        bits = _aligned(ROWS * lanes()).reshape(ROWS, lanes())
        coherent, scattered = np.zeros(32, np.uint32), np.zeros(32, np.uint32)
        coherent[0], scattered[0] = COHERENT, 0
        coherent[1] = scattered[1] = EVERYTHING
        return Packet(_aligned(lanes()), bits.view(np.float32), bits, coherent, scattered)

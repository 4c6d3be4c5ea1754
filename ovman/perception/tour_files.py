"""Read recorded tours: zip files of `visit.json` with the poses and, for view i, `{i:02d}_rgb.png` and `{i:02d}_depth.png`.

Depth has 16 bit, in millimetres. Every file is compared with its recorded digest.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.perception.backprojection import Camera
from ovman.records.visit import REMEDY, TourError, Visit, VisitFiles, picture_name, read_verified

MILLIMETRES = np.float32(1000)
"""Millimetres in a metre."""
PICTURES = ("rgb", "depth")
"""Kinds of pictures that an agent may see."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One frame. rgb: (H, W, 3) uint8; depth: (H, W) metres along the optical axis, 0 if unknown; camera: of both."""

    rgb: np.ndarray
    depth: np.ndarray
    camera: Camera


def cameras(file: Path, field_of_view_deg: float) -> list[Camera]:
    """Read the cameras of the views of a recorded tour as an agent is told them, with the errors of its sensors.

    Raises as `Visit.load`.
    """
    told = [look.sensed or look for look in Visit.load(file).views]
    return [
        Camera((one.camera.x, one.camera.y, one.camera.z), one.pose.yaw_deg, one.pose.horizon_deg, field_of_view_deg)
        for one in told
    ]


def tour(file: Path, field_of_view_deg: float) -> Iterator[View]:
    """Read the views of a recorded tour in their order. Raises TourError for a picture that is missing or damaged."""
    files = VisitFiles.load(file)
    for number, camera in enumerate(cameras(file, field_of_view_deg)):
        yield View(rgb(file, number, files), depth(file, number, files), camera)


def rgb(file: Path, number: int, files: VisitFiles | None = None) -> np.ndarray:
    """Read the colours (H, W, 3) uint8 of a view. files: of its tour, if they were loaded already. Raises TourError as `tour`."""
    return np.ascontiguousarray(picture(file, number, "rgb", files)[..., ::-1])


def depth(file: Path, number: int, files: VisitFiles | None = None) -> np.ndarray:
    """Read the depth (H, W) float32 of a view, metres along the optical axis. files, errors: as `rgb`."""
    return picture(file, number, "depth", files) / MILLIMETRES


def digest(file: Path, field_of_view_deg: float, seen_by: str) -> str:
    """Return the digest of a recorded tour's frames, depths and cameras, and of `seen_by`, the key of the networks.

    Raises:
        TourError: A file is missing or damaged.
    """
    found = hashlib.sha256(seen_by.encode())
    files = VisitFiles.load(file)
    for number, camera in enumerate(cameras(file, field_of_view_deg)):
        found.update(repr(camera).encode())
        for kind in PICTURES:
            found.update(hashlib.sha256(read_verified(file, picture_name(number, kind), files)).digest())
    return found.hexdigest()


def picture(file: Path, number: int, kind: str, files: VisitFiles | None = None) -> np.ndarray:
    """Read a picture of a view: "rgb" (H, W, 3) in the order blue, green, red, "depth" (H, W) in mm, or "ids" (H, W), 16 bit.

    files: of the tour, if they were loaded already. Raises TourError if it is missing or damaged.
    """
    name = picture_name(number, kind)
    image = cv2.imdecode(np.frombuffer(read_verified(file, name, files), np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise TourError(f"{file}: {name} is no picture; {REMEDY}")
    return image

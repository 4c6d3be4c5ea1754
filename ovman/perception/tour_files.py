"""Recorded tours as files: `visit.json` with the poses and, for view i, `{i:02d}_rgb.png` and `{i:02d}_depth.png` (16 bit,
millimetres). Nothing else of a recording is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from ovman.perception.backprojection import Camera
from ovman.perception.tour import View

MILLIMETRES = np.float32(1000)
PICTURES = ("rgb", "depth")


class TourError(ValueError):
    """A recorded tour that cannot be read; one line with the file and the remedy."""

    says_all = True


def cameras(directory: Path, field_of_view_deg: float) -> list[Camera]:
    """The cameras of the views of a recorded tour. TourError if its record cannot be read."""
    file = directory / "visit.json"
    try:
        views = json.loads(file.read_text(encoding="utf-8"))["views"]
        return [
            Camera(
                (view["camera"]["x"], view["camera"]["y"], view["camera"]["z"]),
                view["pose"]["yaw_deg"],
                view["pose"]["horizon_deg"],
                field_of_view_deg,
            )
            for view in views
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TourError(f"{file}: not a readable tour ({type(error).__name__}: {error}); record the visit again") from None


def tour(directory: Path, field_of_view_deg: float) -> Iterator[View]:
    """The views of a recorded tour in their order. TourError for a picture that cannot be read."""
    for number, camera in enumerate(cameras(directory, field_of_view_deg)):
        yield view(directory, number, camera)


def view(directory: Path, number: int, camera: Camera) -> View:
    """One view of a recorded tour. TourError for a picture that cannot be read."""
    rgb, depth = (_picture(_file(directory, number, kind)) for kind in PICTURES)
    return View(np.ascontiguousarray(rgb[..., ::-1]), depth / MILLIMETRES, camera)


def digest(directory: Path, field_of_view_deg: float, seen_by: str) -> str:
    """Digest of a recorded tour's frames, depths and cameras, and of `seen_by`, the key of the networks."""
    found = hashlib.sha256(seen_by.encode())
    for number, camera in enumerate(cameras(directory, field_of_view_deg)):
        found.update(repr(camera).encode())
        for kind in PICTURES:
            path = _file(directory, number, kind)
            try:
                found.update(hashlib.sha256(path.read_bytes()).digest())
            except OSError as error:
                raise TourError(f"{path}: {error.strerror}; record the visit again") from None
    return found.hexdigest()


def _file(directory: Path, number: int, kind: str) -> Path:
    return directory / f"{number:02d}_{kind}.png"


def _picture(path: Path) -> np.ndarray:
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if picture is None:
        raise TourError(f"{path}: not a readable picture; record the visit again")
    return picture

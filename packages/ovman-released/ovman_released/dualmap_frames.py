"""Views as the input that DualMap reads, its data set "self_collected".

A visit is a directory with `rgb/000000.png` (8 bit), `depth/000000.png` (16 bit, millimetres, 0 is invalid), `pose.txt` with a
line a frame (a time in seconds and the 16 numbers of the camera-to-world matrix, row by row) and `lens.json`. A sequence joins
visits.

DualMap's world is right-handed with z up and the floor at z = 0, its camera OpenCV's: x right, y down, z forward. Ours is
Unity's, left-handed with y up, so that (x, y, z) here is (x, z, y) there.
"""

from __future__ import annotations

import hashlib
import json
import math
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import yaml

from ovman.atomic import clear_partials, partial_path, put, remove
from ovman.perception.backprojection import Camera
from ovman.sim.images import write_png

DATASET = "self_collected"
DEPTH_SCALE = 1000.0
"""Units of a depth picture in a metre."""
FARTHEST_M = 65.535
SECONDS = 1.0
"""Between two frames. DualMap takes a frame as a keyframe when half a second has passed, so each of these is one."""
SWAP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
"""S: from Unity's axes to DualMap's, and back."""


class FramesError(ValueError):
    """Frames that cannot be used; one line with the directory and the remedy."""


@dataclass(frozen=True, slots=True)
class Lens:
    """What the frames of a visit share: size and focal length in pixels; how many they are, and the digest of their content."""

    width: int
    height: int
    focal: float
    frames: int
    content: str


def camera_to_world(camera: Camera, floor_y: float) -> np.ndarray:
    """The pose (4, 4) of a camera in DualMap's world, whose floor is at our height `floor_y`, metres. A proper rotation."""
    right, up, forward = camera.axes().T
    pose = np.eye(4)
    pose[:3, :3] = SWAP @ np.stack([right, -up, forward], axis=1)
    pose[:3, 3] = SWAP @ (np.array(camera.position) - (0.0, floor_y, 0.0))
    return pose


def floor_points(points: np.ndarray) -> np.ndarray:
    """Unity's floor-plane positions (N, 2), x and z in metres, of points (N, 3) in DualMap's world."""
    return np.asarray(points, np.float64).reshape(-1, 3)[:, :2].copy()


def focal_px(height: int, field_of_view_deg: float) -> float:
    """Focal length in pixels of a picture of `height` pixels with a vertical field of view in degrees; pixels are square."""
    return height / 2 / math.tan(math.radians(field_of_view_deg) / 2)


def millimetres(depth: np.ndarray) -> np.ndarray:
    """Depth (H, W) in metres as it is written: uint16 millimetres, 0 where it is not finite, not positive or beyond 65.535 m."""
    with np.errstate(invalid="ignore"):
        there = np.isfinite(depth) & (depth > 0) & (depth <= FARTHEST_M)
    return np.round(np.where(there, depth, 0.0) * DEPTH_SCALE).astype(np.uint16)


class Seen(Protocol):
    """A view. rgb: (H, W, 3) uint8; depth: (H, W) metres along the optical axis."""

    @property
    def rgb(self) -> np.ndarray:
        """The picture."""

    @property
    def depth(self) -> np.ndarray:
        """The depth."""

    @property
    def camera(self) -> Camera:
        """Where it was seen from."""


def write_visit(directory: Path, views: Iterable[Seen], floor_y: float) -> Lens:
    """Writes the frames of a visit under `directory`, whole or not at all; views are read one after the other.

    floor_y: height of the floor in Unity's world, metres. FramesError for no view, or for views that differ in size or lens.
    """
    clear_partials(directory)
    partial = partial_path(directory)
    remove(partial)
    for kind in ("rgb", "depth"):
        (partial / kind).mkdir(parents=True)
    content, lines, lenses = hashlib.sha256(), [], set()
    for number, view in enumerate(views):
        height, width = view.depth.shape
        lenses.add((width, height, focal_px(height, view.camera.field_of_view_deg)))
        if view.rgb.shape != (height, width, 3) or len(lenses) > 1:
            raise FramesError(f"{directory}: frame {number} has another size or lens than the first; use one camera")
        for kind, picture in (("rgb", view.rgb), ("depth", millimetres(view.depth))):
            content.update(np.ascontiguousarray(picture).data)
            write_png(partial / kind / f"{number:06d}.png", picture)
        lines.append(" ".join(repr(float(value)) for value in camera_to_world(view.camera, floor_y).ravel()))
        content.update(lines[-1].encode())
    if not lines:
        raise FramesError(f"{directory}: a walk without frames; record it again")
    ((width, height, focal),) = lenses
    content.update(repr((width, height, focal)).encode())
    lens = Lens(width, height, focal, len(lines), content.hexdigest())
    (partial / "pose.txt").write_text(_timed(lines))
    (partial / "lens.json").write_text(json.dumps(asdict(lens)) + "\n")
    put(partial, directory, "lens.json")
    return lens


def read_lens(directory: Path) -> Lens:
    """What the frames of a written visit share. FramesError where there is no such visit."""
    try:
        return Lens(**json.loads((directory / "lens.json").read_text()))
    except (OSError, ValueError, TypeError) as error:
        raise FramesError(f"{directory}: no frames of a visit ({type(error).__name__}); export the walk again") from None


def join(visits: Sequence[Path], root: Path, scene_id: str) -> Path:
    """One sequence `root`/`scene_id` of the frames of `visits`, one after the other; times and numbers go on.

    Gives the yaml of its data set. The pictures are links to those of the visits.
    FramesError if the visits were seen through different lenses.
    """
    lenses = [read_lens(visit) for visit in visits]
    if len({(lens.width, lens.height, lens.focal) for lens in lenses}) != 1:
        raise FramesError(f"{root}: {', '.join(v.name for v in visits)} were seen through different lenses; export them again")
    sequence = root / scene_id
    shutil.rmtree(sequence, ignore_errors=True)
    for kind in ("rgb", "depth"):
        (sequence / kind).mkdir(parents=True)
    lines: list[str] = []
    for visit, lens in zip(visits, lenses, strict=True):
        poses = [line.split(" ", 1)[1] for line in (visit / "pose.txt").read_text().splitlines()]
        if len(poses) != lens.frames:
            raise FramesError(f"{visit}: {len(poses)} poses for {lens.frames} frames; export the walk again")
        for number in range(lens.frames):
            for kind in ("rgb", "depth"):
                picture = (visit / kind / f"{number:06d}.png").resolve()
                (sequence / kind / f"{len(lines) + number:06d}.png").symlink_to(picture)
        lines += poses
    (sequence / "pose.txt").write_text(_timed(lines))
    settings = root / f"{scene_id}.yaml"
    settings.write_text(yaml.safe_dump({"dataset_name": DATASET, "camera_params": camera_parameters(lenses[0])}))
    return settings


def camera_parameters(lens: Lens) -> dict[str, float]:
    """The section "camera_params" of a data set. To DualMap a pixel's index is its centre: the middle is at (size - 1) / 2."""
    return {
        "image_height": lens.height,
        "image_width": lens.width,
        "fx": lens.focal,
        "fy": lens.focal,
        "cx": (lens.width - 1) / 2,
        "cy": (lens.height - 1) / 2,
        "png_depth_scale": DEPTH_SCALE,
        "crop_edge": 0,
    }


def _timed(poses: Sequence[str]) -> str:
    return "".join(f"{number * SECONDS!r} {pose}\n" for number, pose in enumerate(poses))

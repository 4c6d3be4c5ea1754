"""The objects of a run of DualMap, as its process left them: plain arrays, in DualMap's world or in ours."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.agents.dualmap.mapped import OBJECT, Mapped
from ovman_released.dualmap_frames import floor_points
from ovman_released.dualmap_process.objects import ANCHOR, COLUMNS, LOCAL, SCHEMA


class ObjectsError(ValueError):
    """A file that holds no objects of a run; one line with the file and the remedy."""


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """N objects, by the columns of `dualmap_process.objects`; positions in metres of DualMap's world.

    nouns: what DualMap's text tower makes of noun phrases, (K,) of unit length.
    """

    columns: Mapping[str, np.ndarray]
    nouns: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["uid"])

    @property
    def anchors(self) -> tuple[str, ...]:
        """The ids of the anchors of a global map."""
        return tuple(self.columns["uid"][self.columns["kind"] == ANCHOR].tolist())

    def mapped(self, frames: int) -> Mapped:
        """The objects as a map of ours of so many keyframes has them: centres of boxes on our floor plane, and features.

        DualMap saves neither which observations an object has nor when it was seen. first_seen and last_seen are those of the
        process's own record, -1 if unknown.
        """
        columns = self.columns
        return Mapped(
            frames,
            position=floor_points(columns["center_xyz"]),
            feature=unit(columns["clip_ft"]),
            sort=np.where(columns["kind"] == LOCAL, OBJECT, columns["kind"]),
            **{name: columns[name] for name in ("class_id", "first_seen", "last_seen")},
            members=(np.zeros(0, np.int64),) * len(self),
        )


def unit(features: np.ndarray) -> np.ndarray:
    """Features (N, K) as float64 of unit length; DualMap's means of unit vectors are so up to rounding."""
    f = np.asarray(features, np.float64)
    length = np.linalg.norm(f, axis=-1, keepdims=True)
    scaled: np.ndarray = np.divide(f, length, out=np.zeros_like(f), where=length > 0)
    return scaled


def read_objects(path: Path) -> Objects:
    """The objects of a file `objects.npz`. ObjectsError for a file that is none."""
    try:
        with np.load(path) as file:
            schema = str(file["schema"]) if "schema" in file else "nothing"
            arrays = {name: file[name] for name in file.files} if schema == SCHEMA else {}
    except (OSError, zipfile.BadZipFile, ValueError, EOFError, AttributeError) as error:
        raise ObjectsError(f"{path}: no readable file of objects ({type(error).__name__}); run DualMap again") from None
    if schema != SCHEMA:
        raise ObjectsError(f"{path}: schema is {schema}, not {SCHEMA}; run DualMap again")
    columns = {name: arrays[name] for name in COLUMNS}
    if not (np.isfinite(columns["center_xyz"]).all() and np.isfinite(columns["clip_ft"]).all()):
        raise ObjectsError(f"{path}: an object has a position or a feature that is not finite; run DualMap again")
    return Objects(columns, dict(zip(arrays["nouns"].tolist(), unit(arrays["noun_ft"]), strict=True)))

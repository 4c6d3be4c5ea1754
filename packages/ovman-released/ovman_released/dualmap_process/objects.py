"""From DualMap's saved objects to plain arrays. Pickles are opened here and nowhere else, in the process that made them."""

from __future__ import annotations

import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np

SCHEMA = "ovman-dualmap-objects/1"
LOCAL, ANCHOR, RELATED = "local", "anchor", "related"
KINDS = {"LocalObject": LOCAL, "GlobalObject": ANCHOR}


class ObjectsError(Exception):
    """Saved objects that are not what DualMap saves; one line."""


def read(directory: Path, names: list[str], sights: dict[str, tuple[int, int]]) -> list[dict[str, Any]]:
    """The records of the saved objects `*.pkl` of a map, in an order that does not depend on their random ids.

    names: the list of classes; sights: first and last keyframe of objects by id, where they are known.
    """
    found = []
    for path in sorted(directory.glob("*.pkl")):
        with path.open("rb") as file:
            saved = pickle.load(file)
        kind = KINDS.get(type(saved).__name__)
        if kind is None:
            raise ObjectsError(f"{path.name} holds a {type(saved).__name__}; there are {', '.join(KINDS)}")
        found += records(kind, saved.__getstate__(), names, sights)
    return sorted(found, key=lambda r: (r["kind"], *np.round(r["center_xyz"], 6).tolist(), r["class_id"]))


def records(kind: str, state: dict[str, Any], names: list[str], sights: dict[str, tuple[int, int]]) -> list[dict[str, Any]]:
    """The record of one saved object, then those of the objects that an anchor is related to; none for an object without points.

    uid, kind (local, anchor, related), class_id, class_name, n_points, clip_ft (K,) as saved, center_xyz, aabb_min, aabb_max (3,)
    in metres of DualMap's world, first_seen and last_seen (number of the keyframe, -1 where it is not known). A related object
    has no points of its own in the file, so n_points is 0.
    """
    uid = str(state["uid"])
    first, last = sights.get(uid, (-1, -1))
    seen = {"first_seen": first, "last_seen": last}
    points = np.asarray(state["pcd_points"], np.float64).reshape(-1, 3)
    found = []
    if len(points):
        low, high = points.min(axis=0), points.max(axis=0)
        found.append(_record(uid, kind, int(state["class_id"]), names, len(points), state["clip_ft"], low, high, seen))
    if kind == ANCHOR:
        boxes, features, classes = (list(state[name]) for name in ("related_bbox", "related_objs", "related_color"))
        if not len(boxes) == len(features) == len(classes):
            raise ObjectsError(f"anchor {uid} has {len(boxes)} related boxes, {len(features)} features, {len(classes)} classes")
        for number, (box, feature, class_id) in enumerate(zip(boxes, features, classes, strict=True)):
            low, high = (np.asarray(box[name], np.float64) for name in ("min_bound", "max_bound"))
            found.append(_record(f"{uid}/{number}", RELATED, int(class_id), names, 0, feature, low, high, seen))
    return found


def _record(
    uid: str,
    kind: str,
    class_id: int,
    names: list[str],
    n_points: int,
    feature: Any,
    low: np.ndarray,
    high: np.ndarray,
    seen: dict[str, int],
) -> dict[str, Any]:
    if not 0 <= class_id < len(names):
        raise ObjectsError(f"object {uid} has class {class_id}, and the list has {len(names)}; use one list for both visits")
    return {
        "uid": uid,
        "kind": kind,
        "class_id": class_id,
        "class_name": names[class_id],
        "n_points": n_points,
        "clip_ft": np.asarray(feature, np.float32).reshape(-1),
        "center_xyz": (low + high) / 2,
        "aabb_min": low,
        "aabb_max": high,
        **seen,
    }


COLUMNS = {
    "uid": (str, 0),
    "kind": (str, 0),
    "class_id": (np.int64, 0),
    "class_name": (str, 0),
    "n_points": (np.int64, 0),
    "clip_ft": (np.float32, None),
    "center_xyz": (np.float64, 3),
    "aabb_min": (np.float64, 3),
    "aabb_max": (np.float64, 3),
    "first_seen": (np.int64, 0),
    "last_seen": (np.int64, 0),
}
"""Type of every key of a record, and its length: 0 for a single value, None for that of the features."""


def write(path: Path, found: list[dict[str, Any]], nouns: dict[str, np.ndarray]) -> None:
    """Writes records and the text features (K,) of nouns as one .npz file without pickles, whole or not at all."""
    size = len(next(iter(nouns.values()))) if nouns else len(found[0]["clip_ft"]) if found else 0
    arrays = {"schema": np.array(SCHEMA), "nouns": np.array(list(nouns), dtype=str)}
    arrays["noun_ft"] = np.array(list(nouns.values()), np.float32).reshape(len(nouns), size)
    for name, (kind, length) in COLUMNS.items():
        column: np.ndarray = np.array([record[name] for record in found], dtype=kind)
        arrays[name] = column if length == 0 else column.reshape(len(found), size if length is None else length)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with partial.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]  # NumPy 2's stubs have a flag that NumPy 1 would save
    partial.replace(path)

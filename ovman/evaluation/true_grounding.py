"""Grounding by the truth over an agent's own map objects, for diagnostic arms.

It needs the true positions of instances; an agent proper grounds with ``ovman.agents.reference.reasoning``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.reference.association import distances, positions
from ovman.perception.labels import Labels
from ovman.records.scene import Scene
from ovman.records.visit import Sighting
from ovman.settings import Reading
from ovman.sim.scenes import load_scene


def grounding_by_labels(
    category: str, members: Sequence[np.ndarray], labels: Sequence[Labels], reading: Reading
) -> tuple[int, ...]:
    """Return the sorted indices of the map objects that the category means by what their detections truly show.

    members: of each object the numbers of its detections, counted through the tours of `labels` one after the other. MAJORITY:
    the objects of whose detections, of those that show an instance at all, most show this category; ties go to the category with
    the larger masks in sum, then to the first in the alphabet. ANY: objects with one detection of it. ValueError for a reading
    that positions decide, and for a number that no detection has. Source: Table static, "over its own map objects".
    """
    if reading.by_position:
        raise ValueError(f"the reading {reading} is by true positions, not by labels")
    names = np.concatenate([np.zeros(0, str), *(np.array([*one.categories, ""])[one.category] for one in labels)])
    pixels = np.concatenate([np.zeros(0, np.int64), *(one.pixels for one in labels)])
    if any(len(own) and int(own.max()) >= len(names) for own in members):
        raise ValueError(f"the map has a detection beyond the {len(names)} of its tours; make the stages of its labels again")
    if reading is Reading.ANY:
        return tuple(i for i, own in enumerate(members) if category in names[own])
    return tuple(i for i, own in enumerate(members) if commonest(names[own], pixels[own]) == category)


def commonest(names: np.ndarray, pixels: np.ndarray) -> str | None:
    """Return the category that most of an object's detections show; None where none shows an instance.

    names (T,): the category of each, "" for none; pixels (T,): sizes of their masks.
    """
    sums: dict[str, tuple[int, int]] = {}
    for name, size in zip(names.tolist(), pixels.tolist(), strict=True):
        if name:
            count, area = sums.get(name, (0, 0))
            sums[name] = count + 1, area + size
    return min(sums, key=lambda name: (-sums[name][0], -sums[name][1], name), default=None)


def grounding_by_truth(recorded: ArrayLike, p: ArrayLike, radius_m: float) -> tuple[int, ...]:
    """Return the sorted indices of the map objects that stand for true instances.

    recorded (T, 2): every floor-plane position, metres, at which an instance of the category was recorded in a visit; p (N, 2):
    positions of the objects of that visit's map. Each recorded position names the object nearest to it, if that is at most
    radius_m away; of objects equally near the one of smallest x, then z. Raises ValueError for a wrong shape or a value that is
    not finite. Source: Table static, "grounding handed over".
    """
    recorded, p = positions(recorded, "recorded"), positions(p, "p")
    if not len(recorded) or not len(p):
        return ()
    order = np.lexsort(p.T[::-1])
    gap = distances(recorded, p[order])
    nearest = gap.argmin(axis=1)
    return tuple(sorted({int(order[j]) for t, j in enumerate(nearest) if gap[t, j] <= radius_m}))


def grounding_by_places(recorded: ArrayLike, p: ArrayLike, radius_m: float) -> tuple[int, ...]:
    """Return the sorted indices of the map objects (N, 2) within radius_m of a recorded position (T, 2) of either visit.

    Unlike `grounding_by_truth` it does not say which object stands for an instance, nor whether a place is taken in the visit of
    the map. Source: Table static, "grounding handed over"; the reading is ours.
    """
    recorded, p = positions(recorded, "recorded"), positions(p, "p")
    if not len(recorded) or not len(p):
        return ()
    return tuple(np.flatnonzero(distances(recorded, p).min(axis=0) <= radius_m).tolist())


def recorded_positions(sightings: Sequence[Sighting], min_mask_px: int) -> np.ndarray:
    """Return the (T, 2) positions in metres at which a tour recorded the instances, with masks of at least min_mask_px.

    sightings: those of one category in one visit (`ovman.records.visit.Visit.sightings`).
    """
    return positions([(seen.x, seen.z) for seen in sightings if seen.px >= min_mask_px], "recorded")


def read_looks(scene: Scene) -> dict[str, str]:
    """Return what an instance of a scene looks like, by its id: its asset in homes, the size of its box in floor plans.

    Instances of one asset are equal. Floor plans name no assets. There a box counts to 2 cm, and a quarter turn does not matter.
    """
    house = load_scene(scene.scene)
    if not isinstance(house, str):
        return dict(_list_assets(house["objects"]))
    sizes = {one.id: (*sorted((one.size.x, one.size.z)), one.size.y) for one in scene.objects}
    return {k: " x ".join(f"{round(side / 0.02) * 0.02:.2f}" for side in size) for k, size in sizes.items()}


def _list_assets(objects: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    for one in objects:
        yield one["id"], one["assetId"]
        yield from _list_assets(one.get("children", ()))

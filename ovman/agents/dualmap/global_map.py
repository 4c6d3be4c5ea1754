"""DualMap's global (abstract) map: anchors, i.e. furniture that seldom moves, with the objects on them.

Source: DualMap's abstract map. Anchors are never deleted; furniture at a new place becomes a new anchor.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ovman.agents.dualmap.cloud import FLOOR, UP, area, shared_area
from ovman.agents.dualmap.grid import thinned
from ovman.agents.dualmap.local_map import Departure
from ovman.agents.dualmap.map_object import MapObject
from ovman.agents.dualmap.settings import DualmapGlobal


@dataclass(frozen=True, slots=True, eq=False)
class Related:
    """An object on an anchor: position (2,) x and z of its box's centre, metres; feature (K,) of unit length; members (M,):
    numbers of its observations."""

    position: np.ndarray
    feature: np.ndarray
    class_id: int
    observations: int
    first_seen: int
    last_seen: int
    members: np.ndarray

    @staticmethod
    def of(thing: MapObject, before: int = 0) -> Related:
        """The record of an object on furniture. before: number of observations of an earlier visit."""
        members = thing.members(0, before)
        return Related(thing.position, thing.feature, thing.class_id, len(thing.seen), thing.first_seen, thing.last_seen, members)


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A piece of furniture.

    uid: of its first object; flat (N, 2): its points on the floor plane, one a voxel, metres; related: the objects on it; members
    (M,): numbers of its own observations.
    """

    uid: int
    flat: np.ndarray
    feature: np.ndarray
    class_id: int
    observations: int
    first_seen: int
    last_seen: int
    related: tuple[Related, ...]
    members: np.ndarray

    @staticmethod
    def of(departure: Departure, voxel_m: float, before: int = 0) -> Anchor:
        """The anchor of furniture that leaves a local map. before: number of observations of an earlier visit."""
        thing = departure.object
        return Anchor(
            thing.uid,
            _thin(thing.columns[FLOOR], voxel_m),
            thing.feature,
            thing.class_id,
            len(thing.seen),
            thing.first_seen,
            thing.last_seen,
            tuple(Related.of(up, before) for up in departure.related),
            thing.members(0, before),
        )

    @property
    def footprint(self) -> np.ndarray:
        """(4,): least x, z and greatest x, z, metres."""
        return np.concatenate([self.flat.min(axis=0), self.flat.max(axis=0)])

    @property
    def position(self) -> np.ndarray:
        """(2,) x and z of the footprint's centre, metres."""
        centre: np.ndarray = (self.flat.min(axis=0) + self.flat.max(axis=0)) / 2
        return centre


class GlobalMap:
    """Anchors in the order of arrival, after preloaded ones of an earlier visit."""

    def __init__(self, voxel_m: float, constants: DualmapGlobal, preloaded: Iterable[Anchor] = ()) -> None:
        self.anchors: list[Anchor] = list(preloaded)
        self._voxel_m, self._constants = voxel_m, constants

    def take(self, departures: Iterable[Departure], before: int = 0) -> None:
        """Add departures from a local map, in their order. before: number of observations of an earlier visit."""
        for departure in departures:
            self.merge(Anchor.of(departure, self._voxel_m, before))

    def merge(self, new: Anchor) -> None:
        """Merge with the anchor of greatest overlap of footprints if that is above `overlap`; else add the anchor."""
        if self.anchors:
            prints = np.stack([anchor.footprint for anchor in self.anchors])
            shared = overlap(new.footprint, prints)
            nearest = int(shared.argmax())
            if shared[nearest] > self._constants.overlap:
                self.anchors[nearest] = merged(self.anchors[nearest], new, self._voxel_m)
                return
        self.anchors.append(new)


def overlap(rectangle: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """(N,) area that a rectangle (4,) shares with each of rectangles (N, 4), over the smaller of the two areas."""
    smaller = np.minimum(area(rectangle), area(rectangles))
    fractions: np.ndarray = np.divide(
        shared_area(rectangle, rectangles), smaller, out=np.zeros(len(rectangles)), where=smaller > 0
    )
    return fractions


def merged(old: Anchor, new: Anchor, voxel_m: float) -> Anchor:
    """Both anchors as one, with the uid of the old one, and feature and class of the one with more points on the floor plane."""
    looks = new if len(new.flat) > len(old.flat) else old
    return replace(
        old,
        flat=_thin(np.concatenate([old.flat, new.flat]).T, voxel_m),
        feature=looks.feature,
        class_id=looks.class_id,
        observations=old.observations + new.observations,
        last_seen=new.last_seen,
        related=old.related + new.related,
        members=np.concatenate([old.members, new.members]),
    )


def _thin(columns: np.ndarray, voxel_m: float) -> np.ndarray:
    """Points (M, 2) of the floor plane, one a voxel, of their columns (2, N)."""
    return thinned(np.insert(columns, UP, 0.0, axis=0), voxel_m)[FLOOR].T

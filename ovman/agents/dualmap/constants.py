"""DualMap's constants as its maps are given them; the values are in config.yaml, section ``dualmap``."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, TypeVar

Read = TypeVar("Read", "LifeConstants", "LocalConstants", "GlobalConstants")


@dataclass(frozen=True, slots=True)
class LifeConstants:
    """How long an object of the local map lives.

    window: keyframes since it was seen last during which it is being updated; stable: observations that a stable object has at
    least; majority_one_in: more than one in so many of them are of its commonest class; otherwise its class filter has
    converged, i.e. its greatest probability is above filter_probability, its entropy (nats) below filter_entropy and that
    probability has changed by less than filter_change over the last filter_span observations; pending, waiting: keyframes that
    an unstable and a stable object stay on after the window.
    """

    window: int
    stable: int
    majority_one_in: int
    filter_probability: float
    filter_entropy: float
    filter_change: float
    filter_span: int
    pending: int
    waiting: int

    @property
    def flush(self) -> int:
        """Empty keyframes after which nothing that was seen is undecided."""
        return self.window + max(self.pending, self.waiting) + 1


@dataclass(frozen=True, slots=True)
class LocalConstants:
    """near_m: a point of an observation this near to an object's cloud is shared; least_iou: of the two 3-D boxes, below which
    nothing is shared; match: sum of the shared fraction and the features' cosine above which they are one object; voxel_m,
    thin_every: an object's cloud is thinned to one point a voxel at every so many observations; split_frames, split_window: two
    classes that an object is seen as in one keyframe, in more than split_frames of the last split_window, are two objects.
    """

    near_m: float
    least_iou: float
    match: float
    voxel_m: float
    thin_every: int
    split_frames: int
    split_window: int
    life: LifeConstants


@dataclass(frozen=True, slots=True)
class GlobalConstants:
    """overlap: two footprints that share more than this fraction of the smaller one are one anchor. "On": plane_bin_m, bin of the
    heights of which the commonest is an object's major plane; on_overlap: least fraction of the upper footprint over the lower;
    on_below_m, on_above_m: the plane lies at most so far below and above the upper object's lowest point.
    """

    overlap: float
    plane_bin_m: float
    on_overlap: float
    on_below_m: float
    on_above_m: float


@dataclass(frozen=True, slots=True)
class MapConstants:
    """All constants of the maps. unknown: the class of what no name fits, which becomes no anchor; None where there is none."""

    local: LocalConstants
    anchors: GlobalConstants
    unknown: int | None = None

    @staticmethod
    def of(dualmap: Any, unknown: int | None = None) -> MapConstants:
        """Read from the section ``dualmap`` of a stage's view of config.yaml."""
        m, g = dualmap.local_map, dualmap.global_map
        return MapConstants(
            _read(LocalConstants, m, life=_read(LifeConstants, m.life)),
            _read(GlobalConstants, g),
            unknown,
        )


def _read(kind: type[Read], section: Any, **made: Any) -> Read:
    """The constants of a kind from the settings of the same names, but for those that are made."""
    return kind(**made, **{field.name: getattr(section, field.name) for field in fields(kind) if field.name not in made})

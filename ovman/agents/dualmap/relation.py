"""The relation "on" between objects of a local map."""

from __future__ import annotations

import numpy as np

from ovman.agents.dualmap.cloud import UP, area, footprint, shared_area
from ovman.agents.dualmap.map_object import MapObject
from ovman.agents.dualmap.settings import DualmapGlobal


def major_plane(thing: MapObject, bin_m: float) -> float | None:
    """Height in metres of the commonest bin of an object's points, the lowest in a tie; None unless it is furniture."""
    if not thing.low_mobility:
        return None
    bins, counts = np.unique(np.floor(thing.columns[UP] / bin_m).astype(np.int64), return_counts=True)
    return float((bins[counts.argmax()] + 0.5) * bin_m)


def lies_on(upper: MapObject, lower: MapObject, constants: DualmapGlobal) -> bool:
    """Whether an object without a major plane lies on one with a major plane."""
    if upper.low_mobility or not lower.low_mobility:
        return False
    above = footprint(upper.box)
    shared = float(shared_area(above, footprint(lower.box)[None])[0])
    if shared <= 0 or shared < constants.on_overlap * float(area(above)):
        return False
    plane, lowest = major_plane(lower, constants.plane_bin_m), float(upper.box[UP])
    return plane is not None and lowest - constants.on_below_m <= plane <= lowest + constants.on_above_m

"""Wakes a body that overlaps others: lifts it out of its support, and checks whether it is supported."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from ovman_engine.bodies.body import Body, Pose

if TYPE_CHECKING:
    from ovman_engine.physics.physics import Model

OVERLAP_M = 0.005
"""A deeper overlap of a waking body is not treated as a contact."""
LIFT_M, LIFT_STEP_M, LIFT_EXACT_M = 0.05, 0.005, 0.0005
"""A waking body that has sunk at most this deep into its support is lifted out of it, in steps, then by halves."""
PROBE_M = 0.01
"""A body this close below another supports it."""
UPRIGHT = 0.5
"""Least vertical component of a contact with a support."""


def lift(model: Model, name: str, body: Body, awake: Collection[str]) -> tuple[Pose, frozenset[str]]:
    """Return the pose, at most LIFT_M higher, at which a free body overlaps the fewest bodies, and those bodies.

    The body is moved there.

    Contact forces would make it jump. Bodies of `awake` may be overlapped, and the body is not lifted out of them. It is always
    lifted out of the floor.
    """
    floor = next((o.depth for o in _at(model, name, body, body.pose) if o.other == "Floor" and o.depth > OVERLAP_M), 0.0)
    base = body.pose if floor == 0.0 else _raised(body.pose, floor)

    def strange(pose: Pose) -> frozenset[str]:
        return frozenset(o.other for o in _at(model, name, body, pose) if o.depth > OVERLAP_M and o.other != "Floor")

    def sunk(pose: Pose) -> frozenset[str]:
        return strange(pose).difference(awake)

    deep = fewest = sunk(base)
    best = 0.0
    for k in range(1, round(LIFT_M / LIFT_STEP_M) + 1):
        if not fewest:
            break
        found = sunk(_raised(base, k * LIFT_STEP_M))
        if len(found) < len(fewest):
            fewest, best = found, k * LIFT_STEP_M
    if best == 0.0:
        return base, strange(base)
    left = deep - fewest

    def clear(by_m: float) -> bool:
        found = _at(model, name, body, _raised(base, by_m))
        return not any(o.other in left and o.depth > LIFT_EXACT_M for o in found)

    low = best - LIFT_STEP_M
    high = best if clear(best) else best + 2 * OVERLAP_M
    while high - low > LIFT_EXACT_M:
        middle = (low + high) / 2
        low, high = (low, middle) if clear(middle) else (middle, high)
    pose = _raised(base, high)
    return pose, strange(pose)


def supported(model: Model, name: str, body: Body, pose: Pose, strangers: Collection[str]) -> bool:
    """Whether the floor, or a body that is not among `strangers`, is right below a free body at `pose`, to which it is moved."""
    found = _at(model, name, body, _raised(pose, -PROBE_M))
    _at(model, name, body, pose)
    return any(o.other not in strangers and (abs(o.up) > UPRIGHT or o.other == "Floor") for o in found)


def _raised(pose: Pose, by_m: float) -> Pose:
    return Pose(pose.position + [0.0, by_m, 0.0], pose.rotation)


def _at(model: Model, name: str, body: Body, pose: Pose) -> list:
    model.set_box(name, body.box_at(pose), body.velocity)
    model.forward()
    return model.overlaps(name)

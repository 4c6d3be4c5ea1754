"""Training pictures: a scene from random poses and heights, with randomised finishes, lights and clutter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

VIEWS_A_DRAW = 8
"""Views of a scene between two randomisations."""
HORIZONS_DEG, HORIZON_SHARES = (0.0, 15.0, 30.0, 60.0, -15.0), (0.6, 0.1, 0.2, 0.05, 0.05)
"""The camera's pitch and its probabilities. Tours look straight ahead, the look-down sweep 30 and 60 degrees down."""
HEIGHTS_M, RAISED = (-0.7, 0.3), 0.4
"""Range of the camera's extra height, in this share of the views."""
CLUTTER = 0.5
"""Share of the randomisations that move pickupable objects."""
EMPTY = 0.25
"""Share of the views with fewer than two objects that are kept."""
TAKEN = 0.15
"""Share of the movable objects that a randomisation removes."""
DRAWN_ANEW = 0.7
"""Share of the randomisations that change finishes and lights."""
UNSEEN = frozenset(["Floor"])
"""Types that are no instances."""


@dataclass(frozen=True, slots=True)
class ShownObject:
    """An object in a picture: type, asset and materials by AI2-THOR's names, and the size of its box along x, y and z, metres."""

    type: str
    asset: str
    materials: tuple[str, ...]
    size_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One view. rgb: (H, W, 3) uint8; ids: (H, W) int16, indices into objects, or -1."""

    rgb: np.ndarray
    ids: np.ndarray
    objects: tuple[ShownObject, ...]


def pictures(controller: Any, scene: str, count: int, rng: np.random.Generator) -> Iterator[Picture]:
    """`count` views of a scene on a running Controller with instance segmentation; the same for the same state of `rng`."""
    made = 0
    while made < count:
        controller.reset(scene, renderImage=False)
        spots = _draw(controller, rng, own=made == 0)
        for _ in range(min(VIEWS_A_DRAW, count - made)):
            picture = _view(controller, rng, spots)
            while len(picture.objects) < 2 and rng.random() > EMPTY:
                picture = _view(controller, rng, spots)
            yield picture
            made += 1


def _view(controller: Any, rng: np.random.Generator, spots: list[dict[str, float]]) -> Picture:
    spot = spots[rng.integers(len(spots))]
    height = rng.uniform(*HEIGHTS_M) if rng.random() < RAISED else 0.0
    event = controller.step(
        "TeleportFull",
        position={**spot, "y": spot["y"] + height},
        rotation={"x": 0.0, "y": float(rng.uniform(0, 360)), "z": 0.0},
        horizon=float(rng.choice(HORIZONS_DEG, p=HORIZON_SHARES)),
        standing=True,
        forceAction=True,
    )
    if not event.metadata["lastActionSuccess"]:
        raise RuntimeError(f"a view was refused: {event.metadata['errorMessage']}")
    return picture_of(event)


def _draw(controller: Any, rng: np.random.Generator, own: bool) -> list[dict[str, float]]:
    """Draws the scene anew, unless its `own` state is wanted, and says where the agent can stand in it."""

    def step(action: str, **arguments: Any) -> Any:
        return controller.step(action, renderImage=False, **arguments)

    if not own:
        step("SetRandomSeed", seed=int(rng.integers(2**31)))
        if rng.random() < DRAWN_ANEW:
            step("RandomizeMaterials")
            step("RandomizeLighting", brightness=[0.5, 1.5], randomizeColor=True, hue=[0, 1], saturation=[0, 0.4])
        if rng.random() < CLUTTER:
            step("InitialRandomSpawn", randomSeed=int(rng.integers(2**31)), allowFloor=True)
        for found in controller.last_event.metadata["objects"]:
            if (found["pickupable"] or found["moveable"]) and rng.random() < TAKEN:
                step("DisableObject", objectId=found["objectId"])
    positions: list[dict[str, float]] = step("GetReachablePositions").metadata["actionReturn"]
    return positions


def picture_of(event: Any) -> Picture:
    """The picture of an event with RGB and instance segmentation."""
    frame = event.instance_segmentation_frame.astype(np.int32)
    code = frame[..., 0] << 16 | frame[..., 1] << 8 | frame[..., 2]
    values, inverse = np.unique(code, return_inverse=True)
    known = {o["objectId"]: o for o in event.metadata["objects"] if o["objectType"] not in UNSEEN}
    names = {c["color"][0] << 16 | c["color"][1] << 8 | c["color"][2]: c["name"] for c in event.metadata["colors"]}
    table = np.full(len(values), -1, np.int16)
    objects: list[ShownObject] = []
    for i, value in enumerate(values.tolist()):
        found = known.get(names.get(value, ""))
        if found is not None:
            table[i] = len(objects)
            size = found["axisAlignedBoundingBox"]["size"]
            materials = tuple(found["salientMaterials"] or ())
            objects.append(ShownObject(found["objectType"], found["assetId"], materials, (size["x"], size["y"], size["z"])))
    return Picture(event.frame.copy(), table[inverse].reshape(code.shape), tuple(objects))

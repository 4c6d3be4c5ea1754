"""Let objects fall from 1,336 poses at which they came to rest in AI2-THOR 5.0, and measure how far they move in two seconds.

    python bench/unity/rests.py

The objects of the first episode of every scene are put at their poses, all at once, and woken. Names differ between builds of
AI2-THOR, so objects are matched by type where a scene has one of a type. Shapes and physics were chosen on two thirds of the
scenes; the other third is held out. "val" are the 208 objects of the 20 scenes of RoomR's validation split.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import numpy as np
from positions import held_out

from ovman_engine.plan import floorplan
from ovman_engine.plan.floorplan import FloorPlan, SimObject, rotation_matrix
from ovman_engine.world.world import World

SECONDS = 2.0
NEAR_M, CLOSE_M, FAR_M = 0.01, 0.05, 0.15
VAL = frozenset(f"FloorPlan{hundred + k}" for hundred in (0, 200, 300, 400) for k in range(21, 26))

Rest = tuple[SimObject, np.ndarray, np.ndarray]
"""An object, its position (3,) metres and its rotation (3,) degrees."""


def matched(plan: FloorPlan, types: list[str], positions: np.ndarray, rotations: np.ndarray) -> list[Rest]:
    """Return the recorded poses of the objects that are the only ones of their type."""
    mine, theirs = defaultdict(list), defaultdict(list)
    for obj in plan.objects:
        if obj.pickupable:
            mine[obj.type].append(obj)
    for index, kind in enumerate(types):
        theirs[kind].append(index)
    return [
        (mine[kind][0], positions[found[0]], rotations[found[0]])
        for kind, found in theirs.items()
        if len(found) == len(mine[kind]) == 1
    ]


def moved(plan: FloorPlan, rests: list[Rest]) -> list[float]:
    """Return how far each object moves, metres."""
    world = World(plan)
    poses = [{"objectName": o.name, "position": p, "rotation": rotation_matrix(r)} for o, p, r in rests]
    world.set_poses(poses, stationary=False, skip_moveable=True)
    world.advance(SECONDS)
    at = {body.name: body.pose.position for body in world.bodies.values()}
    return [float(np.linalg.norm(at[o.name] - p)) for o, p, _ in rests]


def main() -> None:
    """Print the figures of both parts of the scenes, and of RoomR's validation split."""
    recorded = np.load(Path(__file__).with_name("recorded.npz"))
    scenes = sorted(set(recorded["rest_scene"].tolist()))
    found = {}
    for scene in scenes:
        here, plan = recorded["rest_scene"] == scene, floorplan.read(scene)
        position, rotation = (recorded[f"rest_{key}"][here].astype(float) for key in ("position", "rotation"))
        found[scene] = moved(plan, matched(plan, recorded["rest_type"][here].tolist(), position, rotation))
    held = held_out(scenes)
    print(f"{'scenes':<12}{'objects':>10}{'<= 1 cm':>10}{'<= 5 cm':>10}{'> 15 cm':>10}")
    for name, part in (("chosen on", sorted(set(scenes) - set(held))), ("held out", held), ("all", scenes), ("val", sorted(VAL))):
        far = np.array([distance for scene in part for distance in found[scene]])
        shares = [(far <= NEAR_M).mean(), (far <= CLOSE_M).mean(), (far > FAR_M).mean()]
        print(f"{name:<12}{len(far):>10}" + "".join(f"{share:>10.1%}" for share in shares))


if __name__ == "__main__":
    main()

"""A walk through a floor plan, as a GIF: what the robot sees, how far it is, and which object it is.

    python examples/engine_tour.py [--scene FloorPlan212] [--out tour.gif]

Nothing here knows the embedded engine but the one line that names its executable: on a machine with Unity, leave it out.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections import deque

import numpy as np
from ai2thor.controller import Controller
from PIL import Image

from ovman_engine import executable

STEP_M, TURN_DEG = 0.25, 30
FARTHEST_M = 6.0
"""Depth that is drawn black."""

Cell = tuple[int, int]


def cells(controller: Controller) -> set[Cell]:
    """Where the robot can stand, in steps."""
    return {cell(p) for p in controller.step("GetReachablePositions").metadata["actionReturn"]}


def cell(position: dict[str, float]) -> Cell:
    return round(position["x"] / STEP_M), round(position["z"] / STEP_M)


def roomy(free: set[Cell]) -> set[Cell]:
    """Cells with free cells all around, so that the walk does not end with its nose at a wall."""
    around = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return {c for c in free if all((c[0] + i, c[1] + j) in free for i, j in around)}


def path(free: set[Cell], start: Cell) -> list[Cell]:
    """The shortest path from `start` to the cell that is farthest away."""
    came: dict[Cell, Cell] = {start: start}
    queue = deque([start])
    last = start
    while queue:
        last = queue.popleft()
        for aside, ahead in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            after = (last[0] + aside, last[1] + ahead)
            if after in free and after not in came:
                came[after] = last
                queue.append(after)
    way = [last]
    while way[-1] != start:
        way.append(came[way[-1]])
    return way[::-1]


def picture(event) -> Image.Image:
    """RGB, depth and instances side by side."""
    depth = np.clip(255 * (1 - event.depth_frame / FARTHEST_M), 0, 255).astype(np.uint8)
    panels = event.frame, np.repeat(depth[..., None], 3, axis=2), event.instance_segmentation_frame
    return Image.fromarray(np.concatenate(panels, axis=1))


def walk(controller: Controller, way: list[Cell]):
    """Follows a path; yields the event of every action."""
    for here, after in itertools.pairwise(way):
        heading = math.degrees(math.atan2(after[0] - here[0], after[1] - here[1]))
        while turn := round((heading - controller.last_event.metadata["agent"]["rotation"]["y"] + 180) % 360 - 180):
            yield controller.step("RotateRight" if turn > 0 else "RotateLeft", degrees=min(abs(turn), TURN_DEG))
        yield controller.step("MoveAhead")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="FloorPlan212")
    parser.add_argument("--out", default="tour.gif")
    options = parser.parse_args()
    controller = Controller(
        local_executable_path=executable(), scene=options.scene, width=200, height=200, gridSize=STEP_M, snapToGrid=False,
        rotateStepDegrees=TURN_DEG, renderDepthImage=True, renderInstanceSegmentation=True,
    )  # fmt: skip
    try:
        free, frames = cells(controller), []
        for _ in range(2):  # to the far end of the room, and to the far end from there
            start = cell(controller.last_event.metadata["agent"]["position"])
            frames += [picture(event) for event in walk(controller, path(roomy(free) | {start}, start))]
            frames += [picture(controller.step("RotateRight")) for _ in range(round(360 / TURN_DEG) // 2)]
    finally:
        controller.stop()
    palette = [frame.quantize(128, dither=Image.Dither.NONE) for frame in frames]
    palette[0].save(options.out, save_all=True, append_images=palette[1:], duration=120, loop=0, optimize=True)
    print(f"{options.out}: {len(frames)} frames of {options.scene}")


if __name__ == "__main__":
    main()

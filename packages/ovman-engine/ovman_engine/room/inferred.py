"""The room of an iTHOR floor plan: where its walls are, inferred from the objects.

Floor plans record no walls. The recorded floor is a rectangle, too large in half of the scenes; but paintings, windows, mirrors
and switches hang on walls, and furniture stands inside them. So the room is taken to be a rectangle. Where something hangs on a
wall deeper inside it, a block of wall stands there, which extends to both sides until an object shows that the room goes on.

The agent and the objects are confined by different rectangles: windows, curtains and lamps reach into walls and beyond. Rules and
lengths were chosen so that walls cover none of the positions that agents of AI2-THOR 5.0 took in two thirds of the scenes, see
docs/engine.md. World frame as in `floorplan`; plan rectangles are (x_0, z_0, x_1, z_1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ovman_engine.paint.materials import palette
from ovman_engine.plan import counters
from ovman_engine.plan.floorplan import Box, FloorPlan, SimObject
from ovman_engine.room import masonry
from ovman_engine.room.room import Block, Rectangle, Room, Structure, Wall, structure_name
from ovman_engine.shapes import stoves

BEHIND_M = 0.05
"""The outermost wall is this far behind the outermost object, unless the recorded floor ends before."""
WALL_ITEMS = frozenset(
    ["Window", "Painting", "LightSwitch", "Mirror", "Blinds", "Poster", "Curtains"]
    + ["HandTowelHolder", "TowelHolder", "ToiletPaperHanger"]
)
"""Types that hang flat on a wall."""
MOUNTED = frozenset(["LightSwitch", "HandTowelHolder", "TowelHolder", "ToiletPaperHanger"])
"""Types whose recorded rotation tells the direction of the wall: behind them, at -z. For other types, the wall is on the nearer
side of the floor."""
SQUARE = 0.9
"""Least cosine between an item's back and an axis of the world."""
THIN_M, STICKS_OUT_M = 0.2, 0.3
"""A wall item this thick, or a mounted one that sticks out this far, does not tell where its wall is."""
BESIDE_M = 0.3
"""A wall ends this far before an object that shows that the room goes on, but not before the item that it carries."""
BEYOND_M = 0.05
"""An object that reaches this far beyond a plane shows that no wall is there."""
OUTSIDE_M = 0.3
"""An object farther outside the recorded floor than this is scenery beyond a window."""
ELBOW_M = 0.2
"""No wall is this close to the agent's start."""
PARTITION_ITEMS = frozenset(["Window", "Painting", "LightSwitch", "Mirror", "Poster"])
"""Types that show a thin wall where they hang in the middle of a room. Holders do not: they hang on furniture as well."""
PARTITION_M = 0.12
SLAB_M = 3.0
"""Depth of the solid behind a wall's face: nothing passes it at any speed of the simulation."""
SHELL_M = 0.02
"""Distance of the shell from all objects."""
CEILING_M = (2.5, 3.0)
"""Lowest and highest ceiling above the floor."""


@dataclass(frozen=True)
class InferredRoom(Room):
    """A room of which only the objects are recorded."""

    @staticmethod
    def of(plan: FloorPlan) -> InferredRoom:
        """Return the room of an iTHOR floor plan."""
        rectangle, outline, ceiling_y = _agent_rectangle(plan), _outline(plan), _ceiling(plan)
        blocks = _blocks(plan, rectangle)
        heights = plan.floor_y - 1.0, ceiling_y + 1.0
        bounds = [o.box.bounds() for o in plan.objects]
        low, high = np.min([b[0] for b in bounds], axis=0) - SHELL_M, np.max([b[1] for b in bounds], axis=0) + SHELL_M
        everything = (float(low[0]), float(low[2]), float(high[0]), float(high[2]))
        beyond = (everything[0] - SLAB_M, everything[1] - SLAB_M, everything[2] + SLAB_M, everything[3] + SLAB_M)
        inner = [_wall("wall", b.rectangle(beyond), *heights) for b in blocks]
        bases = _stoves(plan)
        return InferredRoom(
            plan,
            rectangle,
            outline,
            blocks,
            (*(_wall("wall", sides, *heights) for sides in _around(rectangle)), *inner, *bases),
            (
                *(_wall("wall", sides, *heights) for sides in _around(outline)),
                *inner,
                *(_wall("shell", sides, *heights) for sides in _around(everything)),
                *bases,
            ),
            ceiling_y,
        )

    def lamps(self) -> tuple[np.ndarray, ...]:
        """As `Room.lamps`."""
        return masonry.lamps(self)

    def parts(self) -> tuple[Structure, ...]:
        """Walls, a door, the ceiling with its lamps, and stoves."""
        made = ((name, parts, palette(burner, self.plan, "Stove")) for name, burner, parts in stoves(self.plan))
        return (*masonry.structures(self), *made)


def _around(inside: Rectangle) -> list[Rectangle]:
    x_0, z_0, x_1, z_1 = inside
    return [
        (x_0 - SLAB_M, z_0 - SLAB_M, x_0, z_1 + SLAB_M),
        (x_1, z_0 - SLAB_M, x_1 + SLAB_M, z_1 + SLAB_M),
        (x_0 - SLAB_M, z_0 - SLAB_M, x_1 + SLAB_M, z_0),
        (x_0 - SLAB_M, z_1, x_1 + SLAB_M, z_1 + SLAB_M),
    ]


def _wall(kind: str, sides: Rectangle, low: float, high: float) -> Wall:
    x_0, z_0, x_1, z_1 = sides
    centre = np.array([(x_0 + x_1) / 2, (low + high) / 2, (z_0 + z_1) / 2])
    half = np.array([x_1 - x_0, high - low, z_1 - z_0]) / 2
    return Wall(structure_name(kind, centre), Box(centre, half, np.eye(3)))


def _stoves(plan: FloorPlan) -> list[Wall]:
    return [_wall("stove", s.rect, plan.floor_y, s.grate) for s in counters.stoves(plan)]


def _plan_bounds(box: Box) -> tuple[np.ndarray, np.ndarray]:
    low, high = box.bounds()
    return low[[0, 2]], high[[0, 2]]


def _agent_rectangle(plan: FloorPlan) -> Rectangle:
    floor = _plan_bounds(plan.floor.box)
    others = [_plan_bounds(o.box) for o in plan.objects if o.type != "Floor"]
    low = np.maximum(floor[0], np.min([b[0] for b in others], axis=0) - BEHIND_M)
    high = np.minimum(floor[1], np.max([b[1] for b in others], axis=0) + BEHIND_M)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _outline(plan: FloorPlan) -> Rectangle:
    """Return the least rectangle around the agent's bounds, the objects in the room, and the planes of its wall items."""
    rectangle, floor = np.array(_agent_rectangle(plan)), _plan_bounds(plan.floor.box)
    low, high = rectangle[:2], rectangle[2:]
    for obj in plan.objects:
        first, last = _plan_bounds(obj.box)
        middle = (first + last) / 2
        if obj.type == "Floor" or (middle < floor[0] - OUTSIDE_M).any() or (middle > floor[1] + OUTSIDE_M).any():
            continue
        hung = _hung(obj, plan)
        if hung is not None:
            axis, outwards, plane = hung
            first, last = middle.copy(), middle.copy()
            first[axis] = last[axis] = plane
        low, high = np.minimum(low, first), np.maximum(high, last)
    low, high = np.maximum(low, floor[0] - OUTSIDE_M), np.minimum(high, floor[1] + OUTSIDE_M)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _ceiling(plan: FloorPlan) -> float:
    tops = [o.box.bounds()[1][1] for o in plan.objects if o.type != "Floor"]
    return plan.floor_y + float(np.clip(max(tops) - plan.floor_y + 0.1, *CEILING_M))


def _hung(item: SimObject, plan: FloorPlan) -> tuple[int, int, float] | None:
    """Axis, outward direction and coordinate of the wall on which `item` hangs; None if it does not tell."""
    if item.type not in WALL_ITEMS:
        return None
    low, high = _plan_bounds(item.box)
    size, back = high - low, -item.rotation[[0, 2], 2]
    if item.type in MOUNTED and np.abs(back).max() > SQUARE:
        axis = int(np.abs(back).argmax())
        outwards = -1 if back[axis] < 0 else 1
        return (axis, outwards, float(low[axis] if outwards < 0 else high[axis])) if size[axis] < STICKS_OUT_M else None
    axis = int(np.argmin(size))
    if size[axis] >= THIN_M or size[axis] >= size[1 - axis]:
        return None
    middle = float(low[axis] + high[axis]) / 2
    floor_low, floor_high = _plan_bounds(plan.floor.box)
    outwards = -1 if abs(middle - floor_low[axis]) < abs(middle - floor_high[axis]) else 1
    return axis, outwards, middle


def _blocks(plan: FloorPlan, rectangle: Rectangle) -> tuple[Block, ...]:
    start = plan.start[[0, 2]]
    objects = [(o, *_plan_bounds(o.box)) for o in plan.objects if o.type != "Floor"]
    blocks = []
    for item, item_low, item_high in objects:
        hung = _hung(item, plan)
        if hung is None:
            continue
        axis, outwards, plane = hung
        along = 1 - axis
        intruders = []
        if outwards * (start[axis] - plane) > -ELBOW_M:
            intruders.append((start[along] - ELBOW_M, start[along] + ELBOW_M))
        for other, low, high in objects:
            beyond = plane - low[axis] if outwards < 0 else high[axis] - plane
            if other is not item and beyond > BEYOND_M:
                intruders.append((low[along], high[along]))
        limits = float(rectangle[along]) - SLAB_M, float(rectangle[2 + along]) + SLAB_M
        stretch, thick = _stretch(float(item_low[along]), float(item_high[along]), limits, intruders), np.inf
        if stretch is None and item.type in PARTITION_ITEMS:
            stretch, thick = _partition(item, hung, objects, start), PARTITION_M
        if stretch is not None:
            blocks.append(Block(axis, outwards, plane, *stretch, thick))
    return tuple(blocks)


def _partition(
    item: SimObject, hung: tuple[int, int, float], objects: list[tuple[SimObject, np.ndarray, np.ndarray]], start: np.ndarray
) -> tuple[float, float] | None:
    """Return the stretch of a thin wall with room behind it that carries an item, if one fits between the objects."""
    axis, outwards, plane = hung
    along = 1 - axis
    near, far = sorted((plane + outwards * BEYOND_M, plane + outwards * PARTITION_M))
    through = [(low[along], high[along]) for o, low, high in objects if o is not item and low[axis] < far and high[axis] > near]
    if near - ELBOW_M < start[axis] < far + ELBOW_M:
        through.append((start[along] - ELBOW_M, start[along] + ELBOW_M))
    low, high = _plan_bounds(item.box)
    first, last = float(low[along]), float(high[along])
    return _stretch(first, last, (first - PARTITION_M, last + PARTITION_M), through)


def _stretch(
    low: float, high: float, limits: tuple[float, float], intruders: list[tuple[float, float]]
) -> tuple[float, float] | None:
    """Return the longest stretch around [`low`, `high`] within `limits` that is clear of intruders; None if one covers it."""
    first, last = limits
    for begin, end in intruders:
        if begin < low + BEYOND_M and end > high - BEYOND_M:
            return None
        if end <= low:
            first = max(first, end)
        elif begin >= high:
            last = min(last, begin)
        elif begin + end < low + high:
            first = max(first, end)
        else:
            last = min(last, begin)
    if last - first <= BEYOND_M:
        return None
    if first > limits[0]:
        first = max(first, min(first + BESIDE_M, low))
    if last < limits[1]:
        last = min(last, max(last - BESIDE_M, high))
    return float(first), float(last)

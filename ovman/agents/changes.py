"""Pieces: what one tour shows and the other sees through, found from depth. The control `largest_box` goes to the largest.

It reads no noun, runs no network, and nothing in it is fitted. `ovman.agents.noun_blind` chooses among the same pieces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Abstention, AbstentionReason, Answer, PredictionContext, Query, Relation, Visit
from ovman.agents.joint import Joint
from ovman.agents.joint.segments import Frame, grid_frames, grid_votes, vote
from ovman.agents.sharing import keep_last

VOXEL_M = 0.1
"""Points in voxels that touch are one piece."""
LEAST_POINTS, LEAST_VOXELS = 12, 6
"""Smaller pieces are noise of the sensors."""
NEIGHBOURS = 3
"""Least number of changed cells in the square of nine around a cell that counts as changed."""
RIM = 4.0
"""Percentage of a piece's points that its box leaves out at each end of each axis."""
TRANSIENT = 0.15
"""Least share of a moving piece's points that its own tour sees through."""
CELL_M, STEP_M, TALL_M = 0.25, 0.1, 1.2
"""Free floor: cells in which something is lower than STEP_M over the floor, and nothing is between that and TALL_M."""
REACH_M = 0.9
"""Things whose middle is farther than this from free floor are out of reach: `admissibility.validity_radius_m`."""
OUT_OF_REACH = 3.0
"""Penalty of a box out of reach, in units of the logarithm of its volume."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A connected part of what a tour shows and the other sees through. Metres, world coordinates.

    Attributes:
        low: (3,) lower corner of its box.
        high: (3,) upper corner of its box.
        last: (2,) median of its points (x, z) in the last view that shows it.
        view: Share of the tour that is over when it is seen first.
        transient: Share of its points that other views of its own tour see through.
        reach_m: From its middle to the nearest free floor.
        height_m: From the floor to the bottom of its box.
    """

    low: np.ndarray
    high: np.ndarray
    last: np.ndarray
    view: float
    transient: float
    reach_m: float
    height_m: float

    @property
    def middle(self) -> np.ndarray:
        """Middle of its box (x, z)."""
        middle: np.ndarray = (self.low + self.high)[[0, 2]] / 2
        return middle

    @property
    def log_volume(self) -> float:
        """Logarithm of the volume of its box, each side longer by 5 cm."""
        return float(np.log(np.prod(self.high - self.low + 0.05)))

    def place(self, relation: Relation) -> np.ndarray:
        """Return where it is (x, z), for MOVING where it was seen last."""
        return self.last if relation is Relation.MOVING else self.middle


# Pieces -----------------------------------------------------------------------------------------------------------------------


@keep_last
def compare_tours(first: Visit, second: Visit, constants: Joint) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]:
    """Return the pieces that the first tour alone shows, and those that the second alone shows."""
    frames_1, frames_2 = grid_frames(first, constants), grid_frames(second, constants)
    if not frames_1 or not frames_2:
        return (), ()
    return find_pieces(frames_1, frames_2, constants), find_pieces(frames_2, frames_1, constants)


def find_pieces(mine: Sequence[Frame], other: Sequence[Frame], constants: Joint) -> tuple[Piece, ...]:
    """Return the pieces of a tour that the frames of the other tour see through, in the order of their voxels."""
    from scipy.ndimage import label, uniform_filter

    changed = [votes[0] > votes[1] for votes in grid_votes(mine, other, constants)]
    changed = [one & (uniform_filter(one.astype(float), 3, mode="constant") * 9 > NEIGHBOURS - 0.5) for one in changed]
    parts = [frame.points[one] for frame, one in zip(mine, changed, strict=True)]
    points = np.concatenate(parts)
    if not len(points):
        return ()
    view = np.repeat(np.arange(len(mine)), [np.count_nonzero(one) for one in changed])
    votes = [vote(part, [*mine[:k], *mine[k + 1 :]], constants) for k, part in enumerate(parts)]
    open_here = np.concatenate([through > at for through, at in votes])
    voxel = np.floor((points - points.min(axis=0)) / VOXEL_M).astype(np.int64)
    grid = np.zeros(voxel.max(axis=0) + 1, bool)
    grid[tuple(voxel.T)] = True
    number = label(grid, np.ones((3, 3, 3)))[0][tuple(voxel.T)]
    floor_y, free = find_floor(mine)
    pieces = []
    for k in range(1, number.max() + 1):
        own = number == k
        if np.count_nonzero(own) < LEAST_POINTS or len(np.unique(voxel[own], axis=0)) < LEAST_VOXELS:
            continue
        low, high = np.percentile(points[own], [RIM, 100 - RIM], axis=0)
        reach_m = np.hypot(*(free - (low + high)[[0, 2]] / 2).T).min(initial=np.inf)
        last = np.median(points[own & (view == view[own].max())], axis=0)[[0, 2]]
        seen = float(view[own].min()) / len(mine)
        pieces.append(Piece(low, high, last, seen, float(open_here[own].mean()), min(float(reach_m), 5.0), low[1] - floor_y))
    return tuple(pieces)


def find_floor(frames: Sequence[Frame]) -> tuple[float, np.ndarray]:
    """Return the height of the floor and the middles (K, 2) of the cells of free floor that a tour shows."""
    points = np.concatenate([frame.points[frame.known] for frame in frames])
    floor_y = float(np.percentile(points[:, 1], 1.0))
    above = points[:, 1] - floor_y
    low, tall = (np.floor(points[some][:, [0, 2]] / CELL_M) for some in (above < STEP_M, (above >= STEP_M) & (above < TALL_M)))
    free = np.array(sorted({*map(tuple, low.tolist())} - {*map(tuple, tall.tolist())})).reshape(-1, 2)
    return floor_y, (free + 0.5) * CELL_M


# Largest box ------------------------------------------------------------------------------------------------------------------


def predict_largest_box(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm largest_box. Reads joint.*."""
    return find_largest_box(query, context.tour("first"), context.tour("second"), context.settings.joint), None


def find_largest_box(query: Query, first: Visit, second: Visit, constants: Joint) -> Answer | Abstention:
    """Return the place of the piece with the largest box that is in reach; of equal ones the first. It reads no noun.

    For MOVING, pieces that the tour itself sees through count first. Abstains with NO_CANDIDATE without a piece.
    """
    relation = Relation(query.relation)
    gone, come = compare_tours(first, second, constants)
    pieces = _select_pieces(relation, gone, come)
    if not pieces:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    best = max(pieces, key=lambda piece: piece.log_volume - OUT_OF_REACH * (piece.reach_m > REACH_M))
    return answer_at(best.place(relation))


def _select_pieces(relation: Relation, gone: Sequence[Piece], come: Sequence[Piece]) -> Sequence[Piece]:
    """Return the pieces that a relation is about, for MOVING those that its own tour sees through if there are some."""
    if relation.past:
        return gone
    return ([one for one in come if one.transient >= TRANSIENT] or come) if relation is Relation.MOVING else come


def answer_at(place: np.ndarray) -> Answer:
    """Return the answer at a place (x, z)."""
    return Answer(float(place[0]), float(place[1]))

"""Segments: what one frame shows in one piece, and what both tours say of its place.

A segment is a detection, or a part of the picture that the other tour sees through and no detection has: something whose name is
not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.joint.settings import Joint
from ovman.agents.joint.sight import Frame, frames, grid_votes
from ovman.perception.detected import Detected


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """S segments of a tour, detections first, each in the order of the views.

    view (S,): index in the tour; place (S, 3): median of the points, metres; cells (S,): of the grid, with depth; feature (S, K):
    unit embeddings, zeros where there is no detection; named (S,) bool: whether there is one; changed (S,): log odds that the
    place is otherwise in the other tour; moving (S,): the same for the other frames of the segment's own tour.
    """

    view: np.ndarray
    place: np.ndarray
    cells: np.ndarray
    feature: np.ndarray
    named: np.ndarray
    changed: np.ndarray
    moving: np.ndarray

    def __len__(self) -> int:
        return len(self.view)


def log_odds(open_share: np.ndarray, standing_share: np.ndarray, doubt: float) -> np.ndarray:
    """Log odds that something is gone, by the shares of its cells that are seen through and at which something is seen.

    doubt: share of the cells that may be wrong. Cells that the other frames do not observe count for neither, so that what is
    hidden has odds of 1.
    """
    odds: np.ndarray = np.log((open_share + doubt) / (standing_share + doubt))
    return odds


def evidence(first: Visit, second: Visit, in_first: Detected, in_second: Detected, constants: Joint) -> tuple[Segments, Segments]:
    """The segments of both visits, which know no query. in_first, in_second: what was detected in their frames."""
    frames_1, frames_2 = frames(first, constants), frames(second, constants)
    return segments(frames_1, in_first, frames_2, constants), segments(frames_2, in_second, frames_1, constants)


def segments(mine: Sequence[Frame], detected: Detected, other: Sequence[Frame], constants: Joint) -> Segments:
    """The segments of a tour. mine: its frames; detected: in them; other: the frames of the other tour."""
    there, here = grid_votes(mine, other, constants), grid_votes(mine, mine, constants, itself=True)
    masks = detected.masks() if len(detected) else ()
    found: list[tuple[int, np.ndarray, int]] = []
    for number in range(len(detected)):
        view = int(detected.view[number])
        found.append((view, masks[number][mine[view].rows[:, None], mine[view].columns], number))
    for view, one in enumerate(mine):
        taken = np.zeros(one.known.shape, bool)
        for seen_in, cells, _ in found:
            if seen_in == view:
                taken |= cells
        found += [(view, cells, -1) for cells in left_over(there[view], taken, constants)]
    rows = [row for view, cells, number in found if (row := _row(view, cells, number, mine[view], there[view], here[view]))]
    return _gathered(rows, detected, constants)


def left_over(grid: np.ndarray, taken: np.ndarray, constants: Joint) -> list[np.ndarray]:
    """The parts (h, w) bool of a picture's grid that the other tour sees through and no detection has."""
    from scipy.ndimage import label

    parts, count = label((grid[0] > grid[1]) & ~taken)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    return [parts == k for k in range(1, count + 1) if sizes[k] >= constants.part_cells]


_Row = tuple[int, np.ndarray, int, int, tuple[float, float], tuple[float, float]]


def _row(view: int, cells: np.ndarray, number: int, one: Frame, there: np.ndarray, here: np.ndarray) -> _Row | None:
    seen = cells & one.known
    if not (count := int(seen.sum())):
        return None
    place = np.median(one.points[seen], axis=0)
    shares = [
        (float((grid[0][seen] > grid[1][seen]).mean()), float(((grid[1][seen] >= grid[0][seen]) & (grid[1][seen] > 0)).mean()))
        for grid in (there, here)
    ]
    return view, place, number, count, shares[0], shares[1]


def _gathered(rows: Sequence[_Row], detected: Detected, constants: Joint) -> Segments:
    numbers = np.array([row[2] for row in rows], np.int64)
    feature = np.zeros((len(rows), detected.feature.shape[1]))
    feature[numbers >= 0] = detected.feature[numbers[numbers >= 0]]
    shares = np.array([[row[4], row[5]] for row in rows]).reshape(len(rows), 2, 2)
    return Segments(
        view=np.array([row[0] for row in rows], np.int64),
        place=np.array([row[1] for row in rows]).reshape(len(rows), 3),
        cells=np.array([row[3] for row in rows], np.int64),
        feature=feature,
        named=numbers >= 0,
        changed=log_odds(shares[:, 0, 0], shares[:, 0, 1], constants.doubt),
        moving=log_odds(shares[:, 1, 0], shares[:, 1, 1], constants.doubt),
    )

"""Segments: what one frame shows in one piece, and what both tours say of its place.

A segment is a detection, or a part of the picture that the other tour sees through and no detection has: something whose name is
not known. Whether a place has changed is read from depth: a frame of the other tour sees through it, or sees something at it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress, pairwise
from pathlib import Path

import cv2
import numpy as np

from ovman.agents.interface import Observation, Visit
from ovman.agents.joint import Joint
from ovman.agents.sharing import keep_last
from ovman.perception.array_file import read_arrays, write_arrays
from ovman.perception.backprojection import Camera, may_show, pixel_points, project
from ovman.perception.records import Detected

NEAREST_M = 0.2
"""A place that is nearer to a camera than this, or behind it, is not in its picture."""
AROUND_PX = 3
"""Side of the square around a pixel of which some depth may be the place's."""
SPAN = (0.05, 0.5, 0.95)
"""Quantiles of a segment's points along each axis: the outer ones leave out the background that a mask took along."""
GAMMA = 2.2
"""Exponent from a picture's values to light."""
SCHEMA = "ovman-segments/2"


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """S segments of a tour, detections first, each in the order of the views.

    Attributes:
        view: (S,) index of the frame in the tour.
        place: (S, 3) median of the points, metres.
        low, high: (S, 3) lower and upper ends of the points along each axis, metres.
        colour: (S, 3) logarithm of the mean light in red, green and blue.
        cells: (S,) number of the grid's cells with depth.
        feature: (S, K) unit embeddings, zeros for a segment that is not a detection.
        named: (S,) bool, whether it is a detection.
        changed: (S,) log odds that the place is different in the other tour.
        moving: (S,) log odds that the place is different in the other frames of the segment's own tour.
    """

    view: np.ndarray
    place: np.ndarray
    low: np.ndarray
    high: np.ndarray
    colour: np.ndarray
    cells: np.ndarray
    feature: np.ndarray
    named: np.ndarray
    changed: np.ndarray
    moving: np.ndarray

    def __len__(self) -> int:
        return len(self.view)


def weigh_tours(
    first: Visit, second: Visit, in_first: Detected, in_second: Detected, constants: Joint
) -> tuple[Segments, Segments]:
    """Return the segments of both visits, which depend on no query. in_first, in_second: the detections in their frames."""
    frames_1, frames_2 = grid_frames(first, constants), grid_frames(second, constants)
    return segment(first, frames_1, in_first, frames_2, constants), segment(second, frames_2, in_second, frames_1, constants)


def segment(tour: Visit, mine: Sequence[Frame], detected: Detected, other: Sequence[Frame], constants: Joint) -> Segments:
    """Return the segments of a tour with the frames `mine` and their detections. other: the frames of the other tour."""
    there, here = grid_votes(mine, other, constants), grid_votes(mine, mine, constants, same_tour=True)
    masks = detected.masks() if len(detected) else ()
    found = [
        (view, mask[mine[view].rows[:, None], mine[view].columns], number)
        for number, (view, mask) in enumerate(zip(detected.view.tolist(), masks, strict=True))
    ]
    for view, one in enumerate(mine):
        taken = np.logical_or.reduce([np.zeros(one.known.shape, bool), *(cells for at, cells, _ in found if at == view)])
        found += [(view, cells, -1) for cells in find_unnamed_parts(there[view], taken, constants)]
    seen = [(view, cells & mine[view].known, number) for view, cells, number in found]
    seen = [one for one in seen if one[1].any()]
    numbers = np.array([number for *_, number in seen], np.int64)
    feature = np.zeros((len(seen), detected.feature.shape[1]))
    feature[numbers >= 0] = detected.feature[numbers[numbers >= 0]]
    spans = np.array([_span(mine[view].points[cells]) for view, cells, _ in seen]).reshape(len(seen), 3, 3)
    light = {view: _grid_light(tour.observations[view], mine[view]) for view in {view for view, *_ in seen}}
    return Segments(
        view=np.array([view for view, *_ in seen], np.int64),
        place=spans[:, 1],
        low=spans[:, 0],
        high=spans[:, 2],
        colour=np.log([light[view][cells].mean(axis=0) for view, cells, _ in seen]).reshape(len(seen), 3),
        cells=np.array([np.count_nonzero(cells) for _, cells, _ in seen], np.int64),
        feature=feature,
        named=numbers >= 0,
        changed=_odds([there[view][:, cells] for view, cells, _ in seen], constants.doubt),
        moving=_odds([here[view][:, cells] for view, cells, _ in seen], constants.doubt),
    )


def _span(points: np.ndarray) -> np.ndarray:
    """Return the quantiles SPAN of points (N, 3) along each axis: (3, 3), of two neighbours the nearer one."""
    ordered = np.sort(points, axis=0)
    found: np.ndarray = ordered[np.rint(np.multiply(SPAN, len(points) - 1)).astype(np.int64)]
    return found


def _grid_light(observation: Observation, frame: Frame) -> np.ndarray:
    """Return the light (h, w, 3) of the grid's pixels, more than 0. Raises ValueError for a picture without colours."""
    if observation.rgb is None:
        raise ValueError("the joint agent reads colours; write needs: [tours, detections] in its entry")
    light: np.ndarray = ((observation.rgb[frame.rows[:, None], frame.columns] + 1.0) / 256) ** GAMMA
    return light


def find_unnamed_parts(grid: np.ndarray, taken: np.ndarray, constants: Joint) -> list[np.ndarray]:
    """Return the parts (h, w) bool of a picture's grid that the other tour sees through and no detection has."""
    from scipy.ndimage import label

    parts, count = label((grid[0] > grid[1]) & ~taken)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    return [parts == k for k in range(1, count + 1) if sizes[k] >= constants.part_cells]


def log_odds(open_share: np.ndarray, standing_share: np.ndarray, doubt: float) -> np.ndarray:
    """Return the log odds that a segment is gone, from the shares of its cells that are seen through and that show something.

    Cells that the other frames do not observe count for neither share, so that a hidden segment has odds of 1. doubt: share of
    the cells that may be wrong.
    """
    odds: np.ndarray = np.log((open_share + doubt) / (standing_share + doubt))
    return odds


def _odds(votes: Sequence[np.ndarray], doubt: float) -> np.ndarray:
    """Return the log odds of segments from the votes (2, cells) on each."""
    open_share = np.array([(through > at).mean() for through, at in votes])
    return log_odds(open_share, np.array([((at >= through) & (at > 0)).mean() for through, at in votes]), doubt)


# Frames and their votes on places ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame and its grid of every n-th pixel, h rows of w cells.

    Attributes:
        nearest: (H, W) least depth around each pixel, metres along the optical axis, inf where unknown.
        farthest: (H, W) greatest depth around each pixel, -inf where unknown.
        camera: The camera.
        rows: (h,) rows of the grid's pixels.
        columns: (w,) columns of the grid's pixels.
        points: (h, w, 3) world coordinates of the grid's pixels, metres.
        known: (h, w) bool, whether they have depth.
    """

    nearest: np.ndarray
    farthest: np.ndarray
    camera: Camera
    rows: np.ndarray
    columns: np.ndarray
    points: np.ndarray
    known: np.ndarray


@keep_last
def grid_frames(visit: Visit, constants: Joint) -> tuple[Frame, ...]:
    """Return the frames of a visit. Raises ValueError for a tour without pictures."""
    return tuple(grid_frame(one, constants) for one in visit.observations)


def grid_frame(observation: Observation, constants: Joint) -> Frame:
    """Return the frame of one observation. Raises ValueError for one without depth."""
    if observation.depth is None:
        raise ValueError("the joint agent reads depth; write needs: [tours, detections] in its entry")
    depth, camera = np.asarray(observation.depth, np.float64), observation.camera
    rows, columns = (np.arange(constants.every_px // 2, side, constants.every_px) for side in depth.shape)
    at = np.meshgrid(rows, columns, indexing="ij")
    points = pixel_points(depth, at[0].ravel(), at[1].ravel(), camera).reshape(*at[0].shape, 3)
    known = depth > 0
    around = np.ones((AROUND_PX, AROUND_PX))
    nearest, farthest = cv2.erode(np.where(known, depth, np.inf), around), cv2.dilate(np.where(known, depth, -np.inf), around)
    return Frame(nearest, farthest, camera, rows, columns, points, known[at[0], at[1]])


def grid_votes(mine: Sequence[Frame], seen_by: Sequence[Frame], constants: Joint, same_tour: bool = False) -> list[np.ndarray]:
    """Return for each frame of a tour the votes (2, h, w) of another tour's frames on its grid: through, at.

    same_tour: Both tours are one, and a frame has no vote on its own places.
    """
    found = []
    for number, one in enumerate(mine):
        others = [other for k, other in enumerate(seen_by) if not (same_tour and k == number)]
        grid = np.zeros((2, *one.known.shape), np.int64)
        grid[:, one.known] = vote(one.points[one.known], others, constants)
        found.append(grid)
    return found


def vote(points: np.ndarray, seen_by: Iterable[Frame], constants: Joint) -> np.ndarray:
    """Count how many frames see through each of N places (N, 3), and how many see something at it: (2, N).

    A frame sees through a place if everything around its pixel is farther by more than the tolerance, and something at it if
    some of that is within the tolerance. The tolerance grows with the distance of the place, as the errors of depth and poses
    do. A place that is hidden from a frame gets no vote.
    """
    votes, frames = np.zeros((2, len(points)), np.int64), list(seen_by)
    if not len(points):
        return votes
    for one in compress(frames, may_show(points, [(frame.camera, frame.nearest.shape) for frame in frames])):
        places, beyond, away = _look_beyond(points, one)
        tolerance = constants.tolerance_m + constants.tolerance_per_m * away
        votes[0, places[beyond > tolerance]] += 1
        votes[1, places[np.abs(beyond) <= tolerance]] += 1
    return votes


def _look_beyond(points: np.ndarray, seen_by: Frame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which places (M,) are in a frame's picture, by how many metres it shows something farther, and their depths.

    Of the depths around a place's pixel the one nearest to its own counts; the difference is 0 if its own lies among them.
    """
    height, width = seen_by.nearest.shape
    places, rows, columns, own = project(points, seen_by.camera, (height, width), NEAREST_M)
    rows, columns = (np.floor(at).astype(np.int64) for at in (rows, columns))
    inside = (rows >= 1) & (rows < height - 1) & (columns >= 1) & (columns < width - 1)
    places, rows, columns, own = places[inside], rows[inside], columns[inside], own[inside]
    nearest, farthest = seen_by.nearest[rows, columns], seen_by.farthest[rows, columns]
    beyond = np.where(nearest > own, nearest - own, np.minimum(farthest - own, 0.0))
    seen = np.isfinite(beyond)
    return places[seen], beyond[seen], own[seen]


# Files ------------------------------------------------------------------------------------------------------------------------

Tours = tuple[str, str]
"""Content of the first and the second tour (`Visit.content`), since names of visits reveal the change."""


def select_segments(every: Mapping[Tours, tuple[Segments, Segments]], first: Visit, second: Visit) -> tuple[Segments, Segments]:
    """Return the segments of two tours. Raises ValueError for tours that were not weighed against each other."""
    contents = str(first.content), str(second.content)
    if contents not in every:
        raise ValueError(f"no segments of the tours with the contents {' and '.join(contents)}; make the stage segments again")
    return every[contents]


def write_segments(path: Path, every: Mapping[Tours, tuple[Segments, Segments]]) -> None:
    """Write the segments of pairs of tours."""
    parts = [segments for pair in every.values() for segments in pair]
    counts = np.array([len(part) for part in parts], np.int64)
    arrays = {"tours": np.array(list(every), str).reshape(len(every), 2), "counts": counts}
    for name in Segments.__slots__ if parts else ():
        values = np.concatenate([getattr(part, name) for part in parts])
        arrays[name] = values.astype(np.float32) if name == "feature" else values
    write_arrays(path, SCHEMA, arrays)


def read_segments(path: Path) -> dict[Tours, tuple[Segments, Segments]]:
    """Read the segments of pairs of tours. Raises ArrayFileError for a damaged file or one of another kind."""
    arrays = read_arrays(path, SCHEMA)
    spans = list(pairwise([0, *np.cumsum(arrays["counts"]).tolist()]))
    if spans:
        arrays["feature"] = arrays["feature"].astype(np.float64)
    parts = iter([Segments(**{name: arrays[name][start:end] for name in Segments.__slots__}) for start, end in spans])
    return {(first, second): (next(parts), next(parts)) for first, second in arrays["tours"].tolist()}

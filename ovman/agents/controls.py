"""Controls: agents that ignore part of the query and run no network. What they reach says what a split measures.

`category_only` knows true positions and ignores the relation; `true_first_visit` and `true_second_visit` know those of one visit.
`depth_difference` and `pixel_difference` compare the two tours and answer with their largest difference. Of the query they
read only whether the relation asks for a past place: then they look for what the first tour shows and the second does not,
otherwise for what the second shows and the first does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from typing import cast

import numpy as np

from ovman.agents.changes import find_largest_box
from ovman.agents.interface import (
    Abstention,
    AbstentionReason,
    AgentContext,
    Answer,
    Observation,
    PredictionContext,
    Query,
    Relation,
    UniformPick,
    Visit,
)
from ovman.agents.pilot import Executor
from ovman.agents.reference.reasoning import decide_by_spread
from ovman.agents.sharing import keep_last
from ovman.perception.backprojection import Camera, may_show, pixel_points, project
from ovman.settings.benchmark import Controls

NEAREST_M = 0.05
"""A place that is nearer to a camera than this, or behind it, is not in its picture."""
NO_PICTURE = "a control compares pictures; write needs: [tours] in its entry"
AROUND = 3
"""Side in cells of the square that stands for a place in a picture: places fall between the cells."""


# Category only: chance 1/n ----------------------------------------------------------------------------------------------------


def predict_answers_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Pick any recorded instance of the category in the visit that the answer belongs to."""
    return _pick_instance(query, context, "first" if query.relation.past else "second")


def predict_second_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Pick any recorded instance of the category in the second visit, at its last position."""
    return _pick_instance(query, context, "second")


def predict_true_first_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Pick any recorded instance of the category in the first visit."""
    return _pick_instance(query, context, "first")


def predict_true_second_visit(query: Query, context: PredictionContext) -> tuple[Answer | UniformPick | Abstention, None]:
    """Answer MOVING with the instance that moves in the second visit, else pick any recorded instance in it."""
    if query.relation is Relation.MOVING:
        tracks = [instance.track for instance in context.world("second").category(query.category)]
        return decide_by_spread(tracks, context.settings.association.track_spread_m), None
    return _pick_instance(query, context, "second")


def _pick_instance(query: Query, context: PredictionContext, which: str) -> tuple[UniformPick, None]:
    return UniformPick(tuple(instance.position for instance in context.world(which).category(query.category))), None


# Differences between the tours ------------------------------------------------------------------------------------------------


def predict_depth_difference(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm depth_difference."""
    return _predict(query, context, compare_depth)


def predict_pixel_difference(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm pixel_difference."""
    return _predict(query, context, compare_colours)


def _predict(query: Query, context: PredictionContext, compare: Compare) -> tuple[Answer | Abstention, None]:
    tours = context.tour("first"), context.tour("second")
    return find_difference(query.relation.past, *tours, compare, context.settings.controls), None


class DifferenceAgent(Executor):
    """Drives to the largest difference between the tours."""

    def __init__(self, context: AgentContext, compare: Compare) -> None:
        super().__init__(context)
        self._compare = compare

    def predict(self, query: Query) -> Answer | Abstention:
        """Compare the tours."""
        return find_difference(query.relation.past, self.first, self.second, self._compare, self.context.settings.controls)


class LargestBox(Executor):
    """The arm largest_box_embodied: drives to the thing with the largest box that came or went (`ovman.agents.changes`)."""

    def predict(self, query: Query) -> Answer | Abstention:
        """Compare the tours."""
        return find_largest_box(query, self.first, self.second, self.context.settings.joint)


def depth_difference(context: AgentContext) -> DifferenceAgent:
    """Make the agent of the embodied arm depth_difference_embodied."""
    return DifferenceAgent(context, compare_depth)


def pixel_difference(context: AgentContext) -> DifferenceAgent:
    """Make the agent of the embodied arm pixel_difference_embodied."""
    return DifferenceAgent(context, compare_colours)


@keep_last
def find_difference(past: bool, first: Visit, second: Visit, compare: Compare, constants: Controls) -> Answer | Abstention:
    """Return the place of the largest connected difference in any one frame: the median of its points on the floor plane.

    A cell of a frame differs if more frames of the other tour say that something else is there than say that it is the same. Of
    equal differences the first counts. Abstains with NO_CANDIDATE if nothing differs.

    past: whether to look for what the first tour shows and the second does not; compare: how a control compares two frames.
    """
    every_px = constants.every_px
    visits = (first, second) if past else (second, first)
    here, there = (sample_tour(visit, every_px) for visit in visits)
    most, place = 0, None
    for sample in here:
        votes = np.zeros(sample.depth.size, np.int64)
        for shown in look_up(sample, there, every_px, constants.changed_m):
            other_by = compare(shown, constants)
            votes[shown.which] += (other_by > 0).astype(np.int64) - (other_by < 0)
        part = _largest_part((votes > 0).reshape(sample.depth.shape) & np.isfinite(sample.depth))
        if (size := int(np.count_nonzero(part))) > most:
            most, place = size, np.median(sample.points[part], axis=0)
    if place is None:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    return Answer(float(place[0]), float(place[2]))


def _largest_part(mask: np.ndarray) -> np.ndarray:
    """Return the largest part of a mask whose cells touch, at corners as well; of equal ones the first."""
    if not mask.any():
        return mask
    from scipy.ndimage import label

    parts, _ = label(mask, structure=np.ones((3, 3), bool))
    part: np.ndarray = parts == np.bincount(parts[mask]).argmax()
    return part


# What a frame of the other tour shows -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Sample:
    """A frame at every n-th pixel: h rows of w cells. Colours are read from the frame at their first use.

    Attributes:
        depth: (h, w) metres along the optical axis, NaN where unknown.
        points: (h, w, 3) world coordinates, metres.
        frame: The frame.
        at: Rows (h, 1) and columns (1, w) of the pixels.
    """

    depth: np.ndarray
    points: np.ndarray
    frame: Observation
    at: tuple[np.ndarray, ...]

    @cached_property
    def camera(self) -> Camera:
        """The camera of the frame."""
        return self.frame.camera

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) of the frame."""
        height, width = cast(np.ndarray, self.frame.depth).shape
        return height, width

    @cached_property
    def rgb(self) -> np.ndarray:
        """(h, w, 3) colours in [0, 1]. ValueError for a frame without a picture."""
        if self.frame.rgb is None:
            raise ValueError(NO_PICTURE)
        colours: np.ndarray = self.frame.rgb[self.at] / 255.0
        return colours

    @cached_property
    def least_around(self) -> np.ndarray:
        """(h, w) least depth in the square around each cell, inf where none is known."""
        from scipy.ndimage import minimum_filter  # takes a quarter of a second; tours of equal poses do without

        least: np.ndarray = minimum_filter(np.where(np.isfinite(self.depth), self.depth, np.inf), AROUND, mode="nearest")
        return least

    @cached_property
    def colours_around(self) -> tuple[np.ndarray, np.ndarray]:
        """Darkest and lightest colours (h, w, 3) in the square around each cell."""
        from scipy.ndimage import maximum_filter, minimum_filter

        darkest, lightest = (
            extreme(self.rgb, (AROUND, AROUND, 1), mode="nearest") for extreme in (minimum_filter, maximum_filter)
        )
        return darkest, lightest


@dataclass(frozen=True, eq=False)
class Shown:
    """What a frame of the other tour shows at those k places of a sample that are in its picture.

    Attributes:
        sample: The sample.
        other: The sample of the other tour's frame.
        which: Flat indices of the k places in the sample.
        away: (k,) depth of each place for the other frame's camera, metres.
        depth: (k,) nearest depth that the frame shows there, metres, NaN where unknown.
        hidden: (k,) bool, whether the frame shows something nearer; None for frames of one pose, whose pixels are compared.
        rows: (k,) rows of the places in the other sample.
        columns: (k,) columns of the places.
    """

    sample: Sample
    other: Sample
    which: np.ndarray
    away: np.ndarray
    depth: np.ndarray
    hidden: np.ndarray | None = None
    rows: np.ndarray | None = None
    columns: np.ndarray | None = None

    @property
    def own(self) -> np.ndarray:
        """(k, 3) the sample's colours at the places."""
        own: np.ndarray = self.sample.rgb.reshape(-1, 3)[self.which]
        return own

    @cached_property
    def colours(self) -> tuple[np.ndarray, np.ndarray]:
        """The darkest and the lightest colours (k, 3) that the frame shows there, NaN where the place is hidden."""
        if self.hidden is None:
            same = self.other.rgb.reshape(-1, 3)
            return same, same
        darkest, lightest = (bound[self.rows, self.columns] for bound in self.other.colours_around)
        darkest[self.hidden] = lightest[self.hidden] = np.nan
        return darkest, lightest


Compare = Callable[[Shown, Controls], np.ndarray]
"""Returns by how much (k,) a frame shows something else at k places: above 0 if so, below 0 if not, NaN where it cannot tell."""


def compare_depth(shown: Shown, constants: Controls) -> np.ndarray:
    """Return by how many metres (k,) more than changed_m a frame sees beyond the places; NaN where they are hidden."""
    beyond = shown.depth - shown.away
    votes: np.ndarray = np.where(beyond < -constants.changed_m, np.nan, beyond - constants.changed_m)
    return votes


def compare_colours(shown: Shown, constants: Controls) -> np.ndarray:
    """Return by how much (k,) more than changed_level a colour channel differs; full scale is 1.

    Depth only places the difference and says which pixels of other cameras look at a place. Colours do not say which of the tours
    shows the object and which the background: a displaced object differs at both of its places.
    """
    (darkest, lightest), own = shown.colours, shown.own
    votes: np.ndarray = np.maximum(darkest - own, own - lightest).max(axis=1) - constants.changed_level
    return votes


@keep_last
def sample_tour(visit: Visit, every_px: int) -> tuple[Sample, ...]:
    """Return the frames of a visit at every `every_px`-th row and column. Raises ValueError for a tour without pictures."""
    return tuple(_sample(frame, every_px) for frame in visit.observations)


def _sample(frame: Observation, every_px: int) -> Sample:
    if frame.depth is None:
        raise ValueError(NO_PICTURE)
    height, width = frame.depth.shape
    at = np.ix_(*(np.arange(every_px // 2, side, every_px) for side in (height, width)))
    depth, rows, columns = frame.depth[at].astype(np.float64), *np.broadcast_arrays(*at)
    points = pixel_points(frame.depth, rows.ravel(), columns.ravel(), frame.camera).reshape(*depth.shape, 3)
    return Sample(np.where(depth > 0, depth, np.nan), points, frame, at)


def look_up(sample: Sample, tour: Sequence[Sample], every_px: int, hidden_m: float) -> Iterator[Shown]:
    """Yield what the frames of the other tour show at the places of a sample.

    If the tour has a frame from the sample's own pose, that frame alone counts, pixel against pixel. Otherwise every frame counts
    that has any of the places in its picture. A place is hidden where a frame shows something nearer by more than `hidden_m`.
    """
    for other in tour:
        if other.camera == sample.camera and other.depth.shape == sample.depth.shape:
            yield Shown(sample, other, np.arange(sample.depth.size), sample.depth.ravel(), other.depth.ravel())
            return
    points = sample.points.reshape(-1, 3)
    for other in compress(tour, may_show(points, [(one.camera, one.shape) for one in tour])):
        which, rows, columns, away = project(points, other.camera, other.shape, NEAREST_M)
        rows, columns = (np.floor(at / every_px).astype(np.int64) for at in (rows, columns))
        inside = (rows >= 0) & (rows < other.depth.shape[0]) & (columns >= 0) & (columns < other.depth.shape[1])
        which, rows, columns, away = which[inside], rows[inside], columns[inside], away[inside]
        if len(which):
            depth = other.least_around[rows, columns]
            depth[~np.isfinite(depth)] = np.nan
            yield Shown(sample, other, which, away, depth, ~(depth > away - hidden_m), rows, columns)

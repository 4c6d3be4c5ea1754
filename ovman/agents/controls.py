"""Controls: agents that ignore part of the query and run no network. What they reach says what a split measures.

`category_only` knows true positions and ignores the relation. `depth_difference` and `pixel_difference` compare the two tours and
answer with their largest difference; of the query they read only whether the relation asks for a past place. For a past place
they look for what the first tour shows and the second does not, otherwise for what the second shows and the first does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ovman.agents.interface import (
    Abstention,
    AbstentionReason,
    AgentContext,
    Answer,
    CameraPose,
    Observation,
    PredictionContext,
    Query,
    UniformPick,
    Visit,
)
from ovman.agents.pilot import GoalAgent, PredictionDriver
from ovman.perception.backprojection import Camera, pixel_points
from ovman.records.prediction import as_recorded
from ovman.settings.benchmark import Controls

NEAREST_M = 0.05
"""A place that is nearer to a camera than this, or behind it, is not in its picture."""
NO_PICTURES = "a control compares pictures; write needs: [tours] in its entry"
AROUND = 3
"""Side in cells of the square that stands for a place in a picture: places fall between the cells."""


# Category only: chance 1/n ----------------------------------------------------------------------------------------------------


def predict_answers_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Pick any recorded instance of the category in the visit that the answer belongs to."""
    return _pick_instance(query, context, "first" if query.relation.past else "second")


def predict_second_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Pick any recorded instance of the category in the second visit, at its last position."""
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


class DifferenceAgent(GoalAgent):
    """Drives to the largest difference between the tours."""

    def __init__(self, context: AgentContext, compare: Compare) -> None:
        super().__init__(context)
        self._compare = compare

    def decide(self, query: Query) -> Answer | Abstention:
        """Compare the tours."""
        constants = self.context.settings.controls
        return as_recorded(find_difference(query.relation.past, self.first, self.second, self._compare, constants))


def depth_difference(context: AgentContext) -> GoalAgent:
    """Make the agent of the embodied arm depth_difference_embodied."""
    return DifferenceAgent(context, compare_depth) if context.answered is None else PredictionDriver(context)


def pixel_difference(context: AgentContext) -> GoalAgent:
    """Make the agent of the embodied arm pixel_difference_embodied."""
    return DifferenceAgent(context, compare_colours) if context.answered is None else PredictionDriver(context)


def find_difference(past: bool, first: Visit, second: Visit, compare: Compare, constants: Controls) -> Answer | Abstention:
    """Return the place of the largest connected difference in any one frame: the median of its points on the floor plane.

    A cell of a frame differs if more frames of the other tour say that something else is there than say that it is the same. Of
    equal differences the first counts. Abstains with NO_CANDIDATE if nothing differs.

    Args:
        past: Whether to look for what the first tour shows and the second does not.
        first: The first tour.
        second: The second tour.
        compare: How a control compares two frames.
        constants: Section controls.

    Raises:
        ValueError: A tour has no pictures.
    """
    every_px = constants.every_px
    here, there = (sample_tour(visit, every_px) for visit in ((first, second) if past else (second, first)))
    most, place = 0, None
    for sample in here:
        votes = np.zeros(sample.depth.shape)
        for shown in look_up(sample, there, every_px, constants.changed_m):
            votes.reshape(-1)[shown.which] += np.nan_to_num(np.sign(compare(shown, constants)))
        part = _largest_part((votes > 0) & np.isfinite(sample.depth))
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
    """A frame at every n-th pixel: h rows of w cells.

    Attributes:
        depth: (h, w) metres along the optical axis, NaN where unknown.
        points: (h, w, 3) world coordinates, metres.
        camera: The camera of the frame.
        frame: The frame.
        pixels: Rows and columns of the cells in the frame.
    """

    depth: np.ndarray
    points: np.ndarray
    camera: Camera
    frame: Observation
    pixels: tuple[np.ndarray, np.ndarray]

    @property
    def pose(self) -> CameraPose:
        """Camera pose of the frame."""
        return self.frame.pose

    @cached_property
    def shape(self) -> tuple[int, int]:
        """(H, W) of the frame."""
        assert self.frame.depth is not None
        height, width = self.frame.depth.shape
        return height, width

    @cached_property
    def rgb(self) -> np.ndarray:
        """Colours (h, w, 3) in [0, 1]. Raises ValueError for a frame without colours."""
        if self.frame.rgb is None:
            raise ValueError(NO_PICTURES)
        colours: np.ndarray = self.frame.rgb[self.pixels] / 255.0
        return colours

    @cached_property
    def nearest(self) -> np.ndarray:
        """Least depth (h, w) in the square around each cell, inf where none is known."""
        from scipy.ndimage import (
            minimum_filter,
        )  # the import takes a quarter of a second, and tours of equal poses do not need it

        least: np.ndarray = minimum_filter(np.where(np.isfinite(self.depth), self.depth, np.inf), AROUND, mode="nearest")
        return least

    @cached_property
    def colours(self) -> tuple[np.ndarray, np.ndarray]:
        """Darkest and lightest value of each channel (h, w, 3) in the square around each cell."""
        from scipy.ndimage import maximum_filter, minimum_filter

        square = AROUND, AROUND, 1
        return minimum_filter(self.rgb, square, mode="nearest"), maximum_filter(self.rgb, square, mode="nearest")


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What a frame of the other tour shows at those k places of a sample that are in its picture.

    Attributes:
        which: Flat indices of the k places in the sample.
        away: (k,) depth of each place for the frame's camera, metres.
        depth: (k,) nearest depth that the frame shows there, metres, NaN where unknown.
        own: Returns the sample's colours at the places (k, 3).
        colours: Returns the darkest and the lightest colours that the frame shows there, both (k, 3), NaN where the place is
            hidden.
    """

    which: np.ndarray | slice
    away: np.ndarray
    depth: np.ndarray
    own: Callable[[], np.ndarray]
    colours: Callable[[], tuple[np.ndarray, np.ndarray]]


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
    darkest, lightest = shown.colours()
    own = shown.own()
    red, green, blue = np.maximum(darkest - own, own - lightest).T
    votes: np.ndarray = np.maximum(np.maximum(red, green), blue) - constants.changed_level
    return votes


def sample_tour(visit: Visit, every_px: int) -> tuple[Sample, ...]:
    """Return the frames of a visit at every `every_px`-th row and column. Raises ValueError for a tour without pictures."""
    return tuple(_sample(frame, every_px) for frame in visit.observations)


def _sample(frame: Observation, every_px: int) -> Sample:
    if frame.depth is None:
        raise ValueError(NO_PICTURES)
    pose = frame.pose
    camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, frame.field_of_view_deg)
    height, width = frame.depth.shape
    rows, columns = np.meshgrid(*(np.arange(every_px // 2, side, every_px) for side in (height, width)), indexing="ij")
    depth = frame.depth[rows, columns].astype(np.float64)
    points = pixel_points(frame.depth, rows.ravel(), columns.ravel(), camera).reshape(*rows.shape, 3)
    return Sample(np.where(depth > 0, depth, np.nan), points, camera, frame, (rows, columns))


def look_up(sample: Sample, tour: Sequence[Sample], every_px: int, hidden_m: float) -> Iterator[Shown]:
    """Yield what the frames of the other tour show at the places of a sample.

    If the tour has a frame from the sample's own pose, that frame alone counts, pixel against pixel. Otherwise every frame counts
    that has any of the places in its picture. A place is hidden where a frame shows something nearer by more than `hidden_m`.
    """
    for other in tour:
        if other.pose == sample.pose and other.camera == sample.camera and other.depth.shape == sample.depth.shape:
            yield Shown(
                slice(None), sample.depth.ravel(), other.depth.ravel(), partial(_colours, sample), partial(_bounds, other)
            )
            return
    for other in tour:
        shown = _shown(sample, other, every_px, hidden_m)
        if len(shown.away):
            yield shown


def _colours(sample: Sample) -> np.ndarray:
    return sample.rgb.reshape(-1, 3)


def _bounds(sample: Sample) -> tuple[np.ndarray, np.ndarray]:
    return _colours(sample), _colours(sample)


def _shown(sample: Sample, other: Sample, every_px: int, hidden_m: float) -> Shown:
    rows, columns, away, inside = _cells(sample.points.reshape(-1, 3), other, every_px)
    depth = other.nearest[rows, columns]
    depth[~np.isfinite(depth)] = np.nan

    def own() -> np.ndarray:
        colours: np.ndarray = _colours(sample)[inside]
        return colours

    def colours() -> tuple[np.ndarray, np.ndarray]:
        seen = depth > away - hidden_m
        darkest, lightest = np.full((2, len(inside), 3), np.nan)
        darkest[seen], lightest[seen] = (extreme[rows[seen], columns[seen]] for extreme in other.colours)
        return darkest, lightest

    return Shown(inside, away, depth, own, colours)


def _cells(points: np.ndarray, other: Sample, every_px: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return rows, columns and depths (k,) of the cells that points (N, 3) fall into, and the indices (k,) of the points."""
    height, width = other.shape
    aside, up, away = ((points - np.array(other.camera.position)) @ other.camera.axes()).T
    ahead = np.flatnonzero(away > NEAREST_M)
    focal_px = height / 2 / math.tan(math.radians(other.camera.field_of_view_deg) / 2)
    rows = np.floor((height / 2 - focal_px * up[ahead] / away[ahead]) / every_px).astype(np.int64)
    columns = np.floor((width / 2 + focal_px * aside[ahead] / away[ahead]) / every_px).astype(np.int64)
    inside = (rows >= 0) & (rows < other.depth.shape[0]) & (columns >= 0) & (columns < other.depth.shape[1])
    chosen = ahead[inside]
    return rows[inside], columns[inside], away[chosen], chosen

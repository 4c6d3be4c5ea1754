"""DualMap, reimplemented: observations of a dense tour, the local (concrete) map, and the answers from it.

Written from the paper's description of the method and its constants.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Count, Fraction, Metres, Probability, Section, Some, Whole


class DualmapWalk(Section):
    """The dense tours that DualMap sees. On the way between waypoints there is one frame per step of the agent."""

    # 400 gave no more objects on a held-out floor plan, as points are drawn as densely.
    side_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(300, description="pixels, sides of a frame")
    turn_deg: Annotated[float, Field(gt=0, le=180)] = Field(
        30.0, description="degrees between two frames of a spin at a waypoint"
    )


class DualmapObservation(Section):
    """From a frame to DualMap's observations. Pixel counts are those of a frame of published_px and are scaled to others."""

    # 640 x 480. In smaller frames masks may have fewer pixels, of which more are drawn: clouds are as dense.
    published_px: Some = Field(307200, description="pixels of a frame that counts of pixels are stated for")
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(0.2, description="detector confidence")
    min_mask_px: Some = Field(204, description="pixels, smallest mask")
    same_iou: Fraction = Field(0.8, description="IoU above which two masks are one")
    colour_bins: Annotated[Whole, Field(ge=1, le=256)] = Field(16, description="bins of a channel in a mask's colour histogram")
    same_colours: Fraction = Field(0.95, description="cosine of two overlapping masks' histograms above which they are one")
    border_px: Count = Field(20, description="pixels around a mask's box that are embedded with it")
    image_weight: Fraction = Field(0.7, description="of the crop's embedding in a feature")
    text_weight: Annotated[float, Field(ge=0, le=1)] = Field(0.3, description="of the class name's embedding in a feature")
    sample: Fraction = Field(0.04, description="share of a mask's pixels that become points")
    cluster_radius_m: Metres = Field(0.1, description="metres, DBSCAN of the points, whose largest cluster is the object")
    cluster_points: Some = Field(10, description="points, DBSCAN")
    ceiling_m: Annotated[float, Field(ge=0)] = Field(
        0.2, description="metres; an object whose middle is this near to the ceiling's height is part of the ceiling"
    )


class DualmapLife(Section):
    """Life of an object in DualMap's local map.

    A stable object has enough observations, and either a majority class or a converged Bayes filter over its class. An unstable
    one is removed some time after its last observation.
    """

    window: Some = Field(10, description="keyframes after the last observation during which an object is updated")
    stable: Some = Field(8, description="fewest observations of a stable object")
    majority_one_in: Some = Field(3, description="a majority class has more than one in so many observations")
    filter_probability: Probability = Field(0.5, description="a converged filter's greatest probability is above this")
    filter_entropy: Annotated[float, Field(gt=0)] = Field(0.2, description="a converged filter's entropy is below this, nats")
    filter_change: Fraction = Field(0.2, description="a converged filter's greatest probability has changed by less")
    filter_span: Some = Field(3, description="observations over which that change is taken")
    pending: Some = Field(5, description="keyframes after the window until an unstable object is removed")


class DualmapLocal(Section):
    """DualMap's local (concrete) map: from observations of keyframes to objects."""

    near_m: Metres = Field(0.02, description="metres; a point of an observation this near to an object's cloud is shared")
    least_iou: Annotated[float, Field(ge=0, lt=1)] = Field(1.0e-6, description="of two 3-D boxes, below which nothing is shared")
    match: Annotated[float, Field(ge=1, lt=2)] = Field(
        1.2, description="shared fraction + cosine above which two are one; at least 1, so that looks alone match nothing"
    )
    voxel_m: Metres = Field(0.02, description="metres; a thinned cloud has one point per voxel")
    thin_every: Annotated[Whole, Field(ge=2)] = Field(3, description="observations between two thinnings of a cloud")
    split_frames: Some = Field(6, description="keyframes with the same two classes above which an object is split")
    split_window: Some = Field(10, description="latest keyframes in which split_frames is counted")
    life: DualmapLife = DualmapLife()


class Dualmap(Section):
    """DualMap, reimplemented. Values are those of the published configuration unless a comment says otherwise."""

    walk: DualmapWalk = DualmapWalk()
    observation: DualmapObservation = DualmapObservation()
    # The rows of DualMap's arms are means over the runs, each of which draws its own pixels of every mask.
    runs: Some = Field(3, description="runs that differ in what DualMap draws at random")
    local_map: DualmapLocal = DualmapLocal()

"""The baselines CoW, DualMap, DynaMem and REACT, reimplemented."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ovman.settings.values import Count, Fraction, Metres, Probability, Section, Some, Voxels, Whole


class Locobot(Section):
    """AI2-THOR's LoCoBot, the body of CoW."""

    side_px: Some = Field(description="of its square frames")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(description="vertical and horizontal")


class Cow(Section):
    """CoW (Gadre et al., CVPR 2023). Lengths are metres unless the name says voxels."""

    similarity: Annotated[float, Field(ge=-1, le=1)] = Field(description="cosine from which an instance is the category")
    centre_only: bool = Field(description="whether the centre of a box alone is relevant, or all of it")
    image_px: Some = Field(description="side of the depth and relevance images that are mapped")
    voxel_m: Metres = Field(description="side of a voxel")
    camera_height_m: Metres = Field(description="of the camera above the floor")
    floor_tolerance_m: Metres = Field(description="up to which a point is at the height of the floor")
    ceiling_m: Metres = Field(description="height from which nothing is mapped")
    nearest_depth_m: Metres = Field(description="up to which a pixel has no depth")
    unchanged_depth_m: Metres = Field(description="mean and spread of a change of depth below which an action has failed")
    spin_turns: Some = Field(description="turns of a look around")
    ray_step_voxels: Voxels = Field(description="along rays over the floor")
    relevant: Probability = Field(description="relevance above which a voxel is of interest")
    frontier_cells: Some = Field(description="fewest cells that are a frontier")
    cluster_voxels: Annotated[float, Field(gt=1, le=2)] = Field(description="distance below which frontier cells hang together")
    waypoint_voxels: Voxels = Field(description="distance up to which a waypoint is reached")
    visited_voxels: Some = Field(description="side of the square around a target that was visited")
    expansions: Some = Field(description="of the search for actions to a waypoint")
    stop_voxels: Voxels = Field(description="distance to a region of interest below which the agent stops")


class DualmapLife(Section):
    """Life of an object in DualMap's local map.

    A stable object has enough observations, and either a majority class or a converged Bayes filter over its class. After the
    window an unstable object is removed and a stable one settles.
    """

    window: Some = Field(description="keyframes after the last observation during which an object is updated")
    stable: Some = Field(description="fewest observations of a stable object")
    majority_one_in: Some = Field(description="a majority class has more than one in so many observations")
    filter_probability: Probability = Field(description="a converged filter's greatest probability is above this")
    filter_entropy: Annotated[float, Field(gt=0)] = Field(description="a converged filter's entropy is below this, nats")
    filter_change: Fraction = Field(description="a converged filter's greatest probability has changed by less")
    filter_span: Some = Field(description="observations over which that change is taken")
    pending: Some = Field(description="keyframes after the window until an unstable object is removed")
    waiting: Some = Field(description="keyframes after the window until a stable object has settled")


class DualmapLocal(Section):
    """DualMap's local (concrete) map: from observations of keyframes to objects."""

    near_m: Metres = Field(description="metres; a point of an observation this near to an object's cloud is shared")
    least_iou: Annotated[float, Field(ge=0, lt=1)] = Field(description="of two 3-D boxes, below which nothing is shared")
    match: Annotated[float, Field(ge=1, lt=2)] = Field(
        description="shared fraction + cosine above which two are one; at least 1, so that looks alone match nothing"
    )
    voxel_m: Metres = Field(description="metres; a thinned cloud has one point a voxel")
    thin_every: Annotated[Whole, Field(ge=2)] = Field(description="observations between two thinnings of a cloud")
    split_frames: Some = Field(description="keyframes with the same two classes above which an object is split")
    split_window: Some = Field(description="latest keyframes in which split_frames is counted")
    life: DualmapLife


class DualmapGlobal(Section):
    """DualMap's global (abstract) map: anchors, and what lies on them."""

    overlap: Fraction = Field(description="shared fraction of the smaller footprint above which two anchors merge")
    plane_bin_m: Metres = Field(description="metres, bin of heights; the commonest bin is an anchor's major plane")
    on_overlap: Fraction = Field(description="least fraction of the upper footprint that lies over the lower one")
    on_below_m: Annotated[float, Field(ge=0)] = Field(description="metres; farthest plane below the upper object's lowest point")
    on_above_m: Annotated[float, Field(ge=0)] = Field(description="metres; farthest plane above that point")


class DualmapWalk(Section):
    """The dense walks that DualMap sees."""

    side_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels, sides of a frame")
    turn_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees between two frames of a spin")


class DualmapObservation(Section):
    """From a frame to DualMap's observations. Pixel counts are those of a frame of published_px and are scaled to others."""

    published_px: Some = Field(description="pixels of a frame that counts of pixels are stated for")
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="detector confidence")
    min_mask_px: Some = Field(description="pixels, smallest mask")
    same_iou: Fraction = Field(description="IoU above which two masks are one")
    colour_bins: Annotated[Whole, Field(ge=1, le=256)] = Field(description="bins of a channel in a mask's colour histogram")
    same_colours: Fraction = Field(description="cosine of two overlapping masks' histograms above which they are one")
    border_px: Count = Field(description="pixels around a mask's box")
    image_weight: Fraction = Field(description="of the crop in a feature")
    text_weight: Annotated[float, Field(ge=0, le=1)] = Field(description="of the class name in a feature")
    sample: Fraction = Field(description="share of a mask's pixels that become points")
    cluster_radius_m: Metres = Field(description="metres, DBSCAN")
    cluster_points: Some = Field(description="points, DBSCAN")
    ceiling_m: Annotated[float, Field(ge=0)] = Field(description="metres from the ceiling's height")
    mobility_margin: Annotated[float, Field(ge=0, le=2)] = Field(
        description="between the cosines to what moves and what does not"
    )
    low_mobility: Annotated[float, Field(ge=-1, le=1)] = Field(description="least cosine to furniture that seldom moves")


class Dualmap(Section):
    """DualMap, reimplemented."""

    walk: DualmapWalk
    observation: DualmapObservation
    runs: Some = Field(description="runs that differ in what DualMap draws at random")
    maintained: Literal["concatenated_local", "preloaded_global"] = Field(
        description="which map is maintained through both visits"
    )
    local_map: DualmapLocal
    global_map: DualmapGlobal


class Dynamem(Section):
    """DynaMem's memory and its query. Lengths are metres, depths are along the optical axis."""

    voxel_m: Metres = Field(description="side of a voxel")
    nearest_m: Metres = Field(description="depth from which a pixel becomes a point")
    farthest_m: Metres = Field(description="depth up to which a pixel becomes a point, and up to which points are deleted")
    hidden_m: Metres = Field(description="a point with something nearer before it, by more than this, is hidden")
    unknown_m: Metres = Field(description="up to which a depth is not known")
    median_px: Annotated[Whole, Field(ge=1, le=99)] = Field(description="side of the median filter of depth, odd")
    median_error_m: Metres = Field(description="a pixel that differs by as much from its median becomes no point")
    every_px: Some = Field(description="rows and columns of a frame that become points")
    cluster_voxels: Annotated[float, Field(gt=0)] = Field(description="sides of a voxel within which points are neighbours")
    cluster_points: Some = Field(description="neighbours of one frame, itself included, without which a point is noise")
    similarity: Annotated[float, Field(ge=-1, le=1)] = Field(description="cosine from which something is what the noun means")
    detected_m: Metres = Field(description="nearest depth of a detection that confirms an answer is below this")


class React(Section):
    """REACT's clusters of instances."""

    appearance: Annotated[float, Field(ge=0, le=2)] = Field(
        description="distance of two unit features up to which clusters of a category are one"
    )

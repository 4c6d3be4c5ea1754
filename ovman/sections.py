"""The settings of config.yaml as typed sections: what each may be, in which unit."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _sequence(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


Whole = Annotated[int, BeforeValidator(_whole)]
"""2.0 is 2."""
Count = Annotated[Whole, Field(ge=0)]
Some = Annotated[Whole, Field(ge=1)]
Metres = Annotated[float, Field(gt=0)]
Voxels = Annotated[float, Field(gt=0)]
Probability = Annotated[float, Field(ge=0, lt=1)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class PerRelation(_Section):
    """A count for each relation."""

    moved: Count = Field(description="MOVED")
    former: Count = Field(description="FORMER")
    moving: Count = Field(description="MOVING")
    stable: Count = Field(description="STABLE")
    appeared: Count = Field(description="APPEARED")
    removed: Count = Field(description="REMOVED")


FLOOR_PLANS = tuple(f"FloorPlan{n}" for first in (1, 201, 301, 401) for n in range(first, first + 30))


class Benchmark(_Section):
    """What is released."""

    seed: Count = Field(description="root of every random number")
    backend: Literal["embedded", "thor"] = Field(description="simulator: the engine of this project, or AI2-THOR's Unity build")
    scenes: Annotated[tuple[str, ...], BeforeValidator(_sequence), Field(min_length=1)] = Field(description="iTHOR floor plans")
    split: PerRelation = Field(description="episodes released per relation")

    @field_validator("scenes")
    @classmethod
    def _floor_plans(cls, scenes: tuple[str, ...]) -> tuple[str, ...]:
        for scene in scenes:
            if scene not in FLOOR_PLANS:
                raise ValueError(f"{scene} is not a floor plan; there are FloorPlan1-30, 201-230, 301-330 and 401-430")
            if scenes.count(scene) > 1:
                raise ValueError(f"{scene} is there twice")
        return scenes


class Camera(_Section):
    """The agent's camera."""

    width_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    height_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(description="degrees, vertical")


class Tour(_Section):
    """A visit's tour."""

    waypoints: Some = Field(description="W, farthest-point waypoints")
    headings: Annotated[Whole, Field(ge=1, le=360)] = Field(description="views per waypoint")


class Primitives(_Section):
    """What the agent does, and until when."""

    step_m: Metres = Field(description="metres, one MoveAhead and the spacing of the grid")
    turn_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees, one RotateLeft or RotateRight")
    heading_tolerance_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees")
    action_budget: Some = Field(description="actions")
    stop_within_m: Metres = Field(description="metres")
    blocked_edge_expiry: Some = Field(description="actions")
    stall_after: Some = Field(description="actions")


class Mover(_Section):
    """What moves on its own in MOVING episodes."""

    step_m: Metres = Field(description="metres per agent action")
    lane_min_m: Metres = Field(description="metres, shortest lane")
    pause_probability: Probability = Field(description="probability per agent action")
    turn_probability: Probability = Field(description="probability per agent action")


class Candidates(_Section):
    """What is drawn."""

    draws: PerRelation = Field(description="candidates per relation and scene")
    delta_min_m: Metres = Field(description="metres, Delta_min")
    spawn_clearance_m: Annotated[float, Field(ge=0)] = Field(description="metres")


class Measurement(_Section):
    """The loosest settings that a verdict may be re-derived for."""

    mask_px: Some = Field(description="pixels")
    answer_to_navigable_m: Metres = Field(description="metres")
    visible_px: Some = Field(description="pixels")


class Admissibility(_Section):
    """What makes a trial admissible and certified."""

    tau_m: Metres = Field(description="metres, tau")
    minimum_mask_px: Some = Field(description="pixels")
    validity_radius_m: Metres = Field(description="metres")
    drift_tolerance_m: Annotated[float, Field(ge=0)] = Field(description="metres")
    motion_m: Annotated[float, Field(ge=0)] = Field(description="metres")
    runs: Some = Field(description="certification runs")


class Success(_Section):
    """The success test (Eq. 4)."""

    radius_m: Metres = Field(description="metres, R")
    visible_px: Some = Field(description="pixels")
    sweep_deg: Annotated[tuple[Annotated[Whole, Field(ge=-30, le=60)], ...], BeforeValidator(_sequence), Field(min_length=1)] = (
        Field(description="degrees down")
    )


class Association(_Section):
    """The reference agent's association of two visits."""

    gate_m: Metres = Field(description="metres, gamma")
    feature_scale_m: Annotated[float, Field(ge=0)] = Field(description="metres, lambda")
    track_spread_m: Annotated[float, Field(ge=0)] = Field(description="metres, tau_trk")


Commit = Annotated[str, Field(pattern=r"^[0-9a-f]{40}$")]
Sha256 = Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")]


class DetectorNetwork(_Section):
    """The class-agnostic detector."""

    architecture: str = Field(min_length=1, description="segmentation network by ultralytics' name")
    weights: str = Field(min_length=1, description="file of weights, or ultralytics' name of released ones")
    sha256: Sha256 = Field(description="SHA-256 of the weights in hexadecimal, or empty")
    side_px: Annotated[Whole, Field(ge=32, le=4096, multiple_of=32)] = Field(
        description="pixels, side that pictures are scaled to"
    )
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="detector confidence")
    minimum_mask_px: Some = Field(description="pixels, smallest mask that is kept")


class EncoderNetwork(_Section):
    """The image and text towers."""

    model: str = Field(min_length=1, description="open_clip's name of a model, or the file of its configuration (.json)")
    weights: str = Field(min_length=1, description="file of weights, or open_clip's tag of released ones")
    sha256: Sha256 = Field(description="SHA-256 of the weights in hexadecimal, or empty")
    crop_padding: Annotated[float, Field(ge=0)] = Field(description="share of a mask's longer side that is added around it")


class Perception(_Section):
    """From pictures to detections."""

    device: Literal["cpu", "cuda"] = Field(description="where the networks run")
    trust_pickles: bool = Field(description="whether weights may be loaded that can run code of whoever made them (.pt)")
    detector: DetectorNetwork
    encoder: EncoderNetwork


class Maps(_Section):
    """From detections to a visit's map."""

    cluster_radius_m: Metres = Field(description="metres, epsilon")


class Grounding(_Section):
    """Which map objects a noun means."""

    band: Annotated[float, Field(ge=0)] = Field(description="delta_g, below the best similarity")


class DetectorTraining(_Section):
    """How the detector of the default configuration is made."""

    epochs: Some = Field(description="passes over all pictures")
    further_epochs: Some = Field(description="passes after that, without mosaics")
    batch: Some = Field(description="pictures a step")
    rate: Annotated[float, Field(gt=0)] = Field(description="peak learning rate")
    further_rate: Annotated[float, Field(gt=0)] = Field(description="peak learning rate of the further passes")
    weight_decay: Annotated[float, Field(ge=0)] = Field(description="weight decay")
    look_every: Some = Field(description="steps between two looks at the held-out scenes")
    look_at_one_in: Some = Field(description="one in so many held-out pictures is looked at meanwhile")


class EncoderTraining(_Section):
    """How the encoder of the default configuration is made."""

    crop_px: Annotated[Whole, Field(ge=32, multiple_of=32)] = Field(description="pixels, side of a crop")
    detected_one_in: Some = Field(description="one in so many pictures is shown to the detector for its crops")
    steps: Some = Field(description="steps on the crops of true masks")
    further_steps: Some = Field(description="steps on the crops of true and of detected masks after that")
    batch: Some = Field(description="crops a step")
    rate: Annotated[float, Field(gt=0)] = Field(description="peak learning rate")
    further_rate: Annotated[float, Field(gt=0)] = Field(description="peak learning rate of the further steps")
    weight_decay: Annotated[float, Field(ge=0)] = Field(description="weight decay")
    look_every: Some = Field(description="steps between two looks at the held-out scenes")


class Training(_Section):
    """How the networks of the default configuration are made; no part of the main job."""

    seed: Count = Field(description="root of every random number of the trainings")
    views: Some = Field(description="pictures of a floor plan that is learned from")
    held_out_views: Some = Field(description="pictures of a floor plan that is held out")
    detector: DetectorTraining
    encoder: EncoderTraining


class Locobot(_Section):
    """AI2-THOR's LoCoBot, the body of CoW."""

    side_px: Some = Field(description="of its square frames")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(description="vertical and horizontal")


class Cow(_Section):
    """The constants of CoW."""

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


Fraction = Annotated[float, Field(gt=0, le=1)]


class DualmapLife(_Section):
    """How long an object of DualMap's local map lives."""

    window: Some = Field(description="keyframes since it was seen during which it is being updated")
    stable: Some = Field(description="observations of a stable object")
    majority_one_in: Some = Field(description="more than one in so many observations are of its commonest class")
    filter_probability: Probability = Field(description="greatest probability of a converged class filter")
    filter_entropy: Annotated[float, Field(gt=0)] = Field(description="nats")
    filter_change: Fraction = Field(description="of the greatest probability")
    filter_span: Some = Field(description="observations over which it has changed by less")
    pending: Some = Field(description="keyframes after the window until an unstable object is removed")
    waiting: Some = Field(description="keyframes after the window until a stable object has settled")


class DualmapLocal(_Section):
    """DualMap's local map."""

    near_m: Metres = Field(description="metres between points that count as shared")
    least_iou: Annotated[float, Field(ge=0, lt=1)] = Field(description="of two 3-D boxes, below which nothing is shared")
    match: Annotated[float, Field(ge=1, lt=2)] = Field(
        description="shared fraction + cosine above which two are one; at least 1, so that looks alone match nothing"
    )
    voxel_m: Metres = Field(description="metres, one point a voxel")
    thin_every: Annotated[Whole, Field(ge=2)] = Field(description="observations between two thinnings of a cloud")
    split_frames: Some = Field(description="keyframes with two classes, above which an object is two")
    split_window: Some = Field(description="keyframes that are looked back on")
    life: DualmapLife


class DualmapGlobal(_Section):
    """DualMap's global map."""

    overlap: Fraction = Field(description="of the smaller footprint, above which two anchors are one")
    plane_bin_m: Metres = Field(description="metres, bin of heights")
    on_overlap: Fraction = Field(description="of the upper footprint over the lower, from which it is on it")
    on_below_m: Annotated[float, Field(ge=0)] = Field(description="metres below the upper object's lowest point")
    on_above_m: Annotated[float, Field(ge=0)] = Field(description="metres above it")


class DualmapWalk(_Section):
    """The dense walks that DualMap sees."""

    side_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels, sides of a frame")
    turn_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees between two frames of a spin")


class DualmapObservation(_Section):
    """What DualMap sees in a frame."""

    published_px: Some = Field(description="pixels of a frame that counts of pixels are stated for")
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="detector confidence")
    least_px: Some = Field(description="pixels, smallest mask")
    same_iou: Fraction = Field(description="of two masks that are one")
    colour_bins: Annotated[Whole, Field(ge=1, le=256)] = Field(description="bins of a channel")
    same_colours: Fraction = Field(description="cosine of two masks' histograms above which they are one")
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


class Dualmap(_Section):
    """DualMap, reimplemented."""

    walk: DualmapWalk
    observation: DualmapObservation
    runs: Some = Field(description="runs that differ in what DualMap draws at random")
    maintained: Literal["concatenated_local", "preloaded_global"] = Field(
        description="which map is maintained through both visits"
    )
    local_map: DualmapLocal
    global_map: DualmapGlobal


def _function(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", value):
        raise ValueError(f'{value!r} names no function; write "package.module:function"')
    return value


class ArmEntry(_Section):
    """One arm of the evaluation."""

    kind: Literal["static", "embodied"] = Field(description="judged by the point that it predicts, or by where it stops")
    agent: Annotated[str, AfterValidator(_function)] = Field(
        description='"module:function", docs/agents.md says what the function is given and gives back'
    )
    system: str = Field(min_length=1, description='title of its row; an embodied arm\'s "agent"')
    memory: str = Field(min_length=1, description="what it keeps of the two visits, in the tables")
    grounding: Literal["own", "handed"] = Field("own", description="whether it finds out itself what the noun means")
    positions: Literal["own", "handed"] = Field("own", description="whether it finds out itself where things are")
    answer: Literal["own", "handed"] = Field("own", description="handed to the oracle only")
    needs: Annotated[tuple[Literal["tours", "maps", "networks", "dualmap"], ...], BeforeValidator(_sequence)] = Field(
        (), description="what it is given beside query and observations"
    )
    constants: Annotated[tuple[str, ...], BeforeValidator(_sequence)] = Field(
        (), description='settings that it reads, "section.name" or "section.*"; a change of one reruns it'
    )
    executes: str | None = Field(None, description="the static arm whose predictions an embodied arm drives to")
    expected: bool = Field(False, description="its static success is the expectation over a stochastic pick")
    runs: Some = Field(1, description="runs of a static arm over all episodes; its rates are their means")
    embodiment: Literal["default", "locobot"] = Field("default", description="body and camera of an embodied arm")
    released: Literal["cow", "dualmap"] | None = Field(
        None, description="the released system that it is; the arm is left out while section released names no clone of it"
    )
    any_instance: bool = Field(False, description="its own task is to reach any instance; it is judged on that, too")
    budget: Some | None = Field(None, description="actions; primitives.action_budget if not given")
    cut_from: str | None = Field(None, description="the embodied arm whose runs, ended after `budget` actions, are its own")


def _there(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    for name in value:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", str(name)):
            raise ValueError(f"{name!r} cannot name an arm, whose files are called after it; write small letters, digits and _")
    return {name: entry for name, entry in value.items() if entry is not None}


Arms = Annotated[dict[str, ArmEntry], BeforeValidator(_there)]
"""By name, in the order of the tables; an entry that is null is left out."""


class ReleasedCow(_Section):
    """CoW's released code, run from the user's clone."""

    root: str = Field(description="folder of the clone; empty leaves the system out")
    commit: Commit = Field(description="Git commit that the clone must be at")
    python: str = Field(description="Python interpreter of the clone's own environment")
    device: Literal["cpu", "cuda"] = Field(description="where its networks run")
    threshold: Annotated[float, Field(gt=0, lt=1)] = Field(description="relevance from which it takes a detection, as released")
    budget: Some = Field(description="actions, as released")
    processes: Some = Field(description="runners side by side, each with an agent of its own for a share of the episodes")


class ReleasedDualmap(_Section):
    """DualMap's released code, run from the user's clone."""

    root: str = Field(description="folder of the clone; empty leaves the system out")
    commit: Commit = Field(description="Git commit that the clone must be at")
    python: str = Field(description="Python interpreter of the clone's own environment")
    device: Literal["cpu", "cuda"] = Field(description="where its networks run")
    guard: Literal["first_only", "every_frame"] = Field(description="frames without a detection that are kept from breaking it")
    maintained: Literal["concatenated_local", "concatenated_global", "preloaded_global"] = Field(
        description="the map that is maintained through two visits; the maps of single visits are of its kind"
    )
    side_px: Annotated[Whole, Field(ge=480, le=4096)] = Field(description="pixels, side of a frame of the dense walks")
    time_limit_s: Annotated[float, Field(gt=0)] = Field(description="seconds after which one run is ended")


class Released(_Section):
    """The baselines as their authors released them."""

    cow: ReleasedCow
    dualmap: ReleasedDualmap


class SingleVisit(_Section):
    """The single-visit baseline."""

    samples: Some = Field(description="Monte Carlo draws")


class Evaluation(_Section):
    """How arms are run and reported."""

    seeds: Annotated[tuple[Count, ...], BeforeValidator(_sequence), Field(min_length=1)] = Field(
        description="embodied runs per arm"
    )
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="level of the intervals")
    near_miss_m: Metres = Field(description="metres from the answer up to which a failed prediction is a near miss")

    @field_validator("seeds")
    @classmethod
    def _distinct(cls, seeds: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(seeds)) < len(seeds):
            raise ValueError("a seed is there twice")
        return seeds


class Config(_Section):
    """All settings."""

    benchmark: Benchmark
    camera: Camera
    tour: Tour
    primitives: Primitives
    mover: Mover
    candidates: Candidates
    measurement: Measurement
    admissibility: Admissibility
    success: Success
    perception: Perception
    maps: Maps
    grounding: Grounding
    association: Association
    single_visit: SingleVisit
    evaluation: Evaluation
    dualmap: Dualmap
    released: Released
    training: Training
    locobot: Locobot
    cow: Cow
    arms: Arms

    @model_validator(mode="before")
    @classmethod
    def _without_clones(cls, tree: Any) -> Any:
        """Arms of released systems of which no clone is named are left out."""

        def named(entry: Any) -> bool:
            here = tree.get("released")
            for key in (entry.get("released") if isinstance(entry, dict) else None, "root"):
                here = here.get(key) if isinstance(here, dict) and isinstance(key, str) else None
            return here != ""

        if not isinstance(tree, dict) or not isinstance(tree.get("arms"), dict):
            return tree
        return {**tree, "arms": {name: entry for name, entry in tree["arms"].items() if named(entry)}}

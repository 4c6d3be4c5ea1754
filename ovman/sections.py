"""The settings of config.yaml as typed sections: what each may be, in which unit."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _sequence(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


Whole = Annotated[int, BeforeValidator(_whole)]
"""2.0 is 2."""
Count = Annotated[Whole, Field(ge=0)]
Some = Annotated[Whole, Field(ge=1)]
Metres = Annotated[float, Field(gt=0)]
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
    training: Training

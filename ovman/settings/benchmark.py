"""The sections about the benchmark and the reference agent: tours, primitives, thresholds, sensors, limits of agents."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from ovman.section import Angle, Count, Distinct, Fraction, Metres, Probability, Section, Some, Spread, Whole

FLOOR_PLANS = tuple(f"FloorPlan{n}" for first in (1, 201, 301, 401) for n in range(first, first + 30))
HOUSE_NAME = r"House-([A-Za-z0-9_]+)"
"""A house in a file, by the name of the file (ovman/sim/scenes.py)"""
HOUSES = Path("houses")
"""Folder of the houses in files, below the working directory"""


def _scene(name: str) -> str:
    if name not in FLOOR_PLANS and not re.fullmatch(HOUSE_NAME, name):
        says = "there are FloorPlan1-30, 201-230, 301-330 and 401-430, and House-NAME for houses/NAME.json"
        raise ValueError(f"{name} is not a scene; {says}")
    return name


Scene = Annotated[str, AfterValidator(_scene)]
Seconds = Annotated[float, Field(gt=0)]


class PerRelation(Section):
    """A count for each relation."""

    moved: Count = Field(description="MOVED")
    former: Count = Field(description="FORMER")
    moving: Count = Field(description="MOVING")
    stable: Count = Field(description="STABLE")
    appeared: Count = Field(description="APPEARED")
    removed: Count = Field(description="REMOVED")


class Benchmark(Section):
    """Settings of all splits."""

    seed: Count = Field(description="root of every random number")
    backend: Literal["embedded", "thor"] = Field(description="simulator: the engine of this project, or AI2-THOR's Unity build")
    allow_short_split: bool = Field(description="whether a split is released with fewer episodes than it asks for")


class Camera(Section):
    """The agent's camera."""

    width_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    height_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(description="degrees, vertical")


class Tour(Section):
    """A visit's tour."""

    waypoints: Annotated[Some, Field(le=1000)] = Field(description="W, farthest-point waypoints")
    headings: Annotated[Whole, Field(ge=1, le=360)] = Field(description="views per waypoint")


class Primitives(Section):
    """The primitives of the agent, and when an episode ends."""

    step_m: Metres = Field(description="metres, one MoveAhead and the spacing of the grid")
    turn_deg: Angle = Field(description="degrees, one RotateLeft or RotateRight")
    heading_tolerance_deg: Angle = Field(description="degrees")
    action_budget: Some = Field(description="actions")
    stop_within_m: Metres = Field(description="metres")
    blocked_edge_expiry: Some = Field(description="actions")
    stall_after: Some = Field(description="actions")


class Mover(Section):
    """The movers of MOVING episodes."""

    step_m: Metres = Field(description="metres per agent action, and the spacing of its lattice")
    pause_probability: Probability = Field(description="probability per agent action")
    turn_probability: Probability = Field(description="probability per agent action")


class Candidates(Section):
    """Terms of candidates."""

    delta_min_m: Metres = Field(description="metres, Delta_min")
    spawn_clearance_m: Spread = Field(description="metres")
    mover_min_m: Metres = Field(description="metres that each of several movers leaves its start by, at least")


class Measurement(Section):
    """Bounds of measurement: the loosest settings that a verdict may be derived for."""

    min_mask_px: Some = Field(description="pixels")
    answer_to_navigable_m: Metres = Field(description="metres")
    visible_px: Some = Field(description="pixels")


class Admissibility(Section):
    """Thresholds of admissibility, and the number of certification runs."""

    tau_m: Metres = Field(description="metres, tau")
    min_mask_px: Some = Field(description="pixels")
    validity_radius_m: Metres = Field(description="metres")
    drift_tolerance_m: Spread = Field(description="metres")
    motion_m: Spread = Field(description="metres")
    mover_spread_m: Spread = Field(description="metres, least distance between two recorded places of a mover")
    runs: Some = Field(description="certification runs")


class Success(Section):
    """The success test (Eq. 4)."""

    radius_m: Metres = Field(description="metres, R")
    visible_px: Some = Field(description="pixels")
    sweep_deg: tuple[Annotated[Whole, Field(ge=-30, le=60)], ...] = Field(min_length=1, description="degrees down")


class Association(Section):
    """The reference agent's association of two visits."""

    gate_m: Metres = Field(description="metres, gamma")
    feature_scale_m: Spread = Field(description="metres, lambda")
    track_spread_m: Spread = Field(description="metres, tau_trk")


class Maps(Section):
    """From detections to a visit's map."""

    cluster_radius_m: Metres = Field(description="metres, epsilon")


class Grounding(Section):
    """Grounding of a noun in map objects."""

    similarity_margin: Spread = Field(description="delta_g, below the best similarity")


class Appearance(Section):
    """Cues of appearance in the association cost, fitted on one split and tested on another. No arm reads it."""

    agent: str = Field(description="static arm with maps of both visits whose grounding and rules the variants keep")
    hue_bins: Annotated[Some, Field(le=180)] = Field(description="bins of the histograms' hue")
    saturation_bins: Annotated[Some, Field(le=256)] = Field(description="and of their saturation")
    extent_share: Fraction = Field(description="share of a mask's points that its extent spans along each axis")
    least_extent_m: Metres = Field(description="metres, a shorter side counts as this long")
    weight_step: Annotated[float, Field(ge=0.005, le=1)] = Field(description="of the grid of weights, which sum to 1")
    equal_scales: bool = Field(description="whether cues are scaled to the features' mean disagreement before they are weighed")
    least_pairs: Some = Field(description="pairs of each kind, same and different, from which on weights are fitted")


class Controls(Section):
    """Controls that compare the tours' pictures."""

    changed_m: Metres = Field(description="metres by which depth differs where something has changed")
    changed_level: Annotated[float, Field(gt=0, lt=1)] = Field(description="of a colour channel, where something has changed")
    every_px: Annotated[Some, Field(le=20)] = Field(description="rows and columns from one compared pixel to the next")


class SingleVisit(Section):
    """The single-visit baseline."""

    samples: Some = Field(description="Monte Carlo draws")


class Evaluation(Section):
    """Runs of arms and statistics of reports."""

    seeds: Annotated[tuple[Count, ...], Distinct] = Field(min_length=1, description="embodied runs per arm")
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="level of the intervals")
    near_miss_m: Metres = Field(description="metres from the answer up to which a failed prediction is a near miss")


class Errors(Section):
    """Standard deviations of normal errors.

    A depth z has that of `depth_m + depth_per_m2 * (z - depth_nearest_m)^2`, each pixel its own. A visit begins at a pose that is
    wrong by `pose_m` along each axis of the floor and by `pose_deg`. What is gone and turned since then is measured with errors
    that grow as the root of what was done.
    """

    depth_m: Spread = Field(description="metres, of the depth of what is depth_nearest_m away")
    depth_per_m2: Spread = Field(description="metres per square metre, how it grows with the distance beyond that")
    depth_nearest_m: Spread = Field(description="metres, nearest distance that the sensor is made for")
    pose_m: Spread = Field(description="metres, of the position where a visit begins, along each axis")
    pose_deg: Spread = Field(description="degrees, of the yaw there")
    drift_m: Spread = Field(description="metres per root of a metre gone, along each axis")
    drift_deg: Spread = Field(description="degrees per root of a metre gone, and per root of a full turn")


class Levels(Section):
    """The levels that a split may name."""

    good: Errors = Field(description="of a robot that is well calibrated and localised")
    poor: Errors = Field(description="of one that is not")


Level = Literal["good", "poor"]


class Remote(Section):
    """Limits of an agent in its own process."""

    connect_s: Seconds = Field(description="seconds until an agent's server answers, its start included")
    tour_s: Seconds = Field(description="seconds for each of begin, familiarise, revisit and ask")
    act_s: Seconds = Field(description="seconds for an action")
    run_s: Seconds = Field(3600.0, description="seconds for all actions of a run; no action is asked for after them")
    memory_gb: Annotated[float, Field(gt=0)] = Field(description="GB of private memory of each process on this machine")

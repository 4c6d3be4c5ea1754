"""The constants of CoW."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ovman.models.settings import Settings


@dataclass(frozen=True, slots=True)
class CowConstants:
    """Section `cow` of config.yaml, where every constant has its unit and its reason, and the benchmark's step and turn.

    Distances in metres unless they are said to be in voxels, angles in degrees.
    """

    similarity: float
    centre_only: bool
    image_px: int
    voxel_m: float
    camera_height_m: float
    floor_tolerance_m: float
    ceiling_m: float
    nearest_depth_m: float
    unchanged_depth_m: float
    ray_step_voxels: float
    spin_turns: int
    relevant: float
    frontier_cells: int
    cluster_voxels: float
    waypoint_voxels: float
    visited_voxels: int
    expansions: int
    stop_voxels: float
    step_m: float
    turn_deg: float

    @staticmethod
    def of(constants: Settings) -> CowConstants:
        """From a stage's view that owns cow.*, primitives.step_m and primitives.turn_deg."""
        section, primitives = constants.cow, constants.primitives
        own = {field.name: getattr(section, field.name) for field in fields(CowConstants)[:-2]}
        return CowConstants(**own, step_m=primitives.step_m, turn_deg=primitives.turn_deg)

    @property
    def headings(self) -> int:
        """How many turns make a full circle: 12."""
        return round(360.0 / self.turn_deg)

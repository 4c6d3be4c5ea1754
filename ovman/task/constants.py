"""The constants that the definition of an episode needs; their values live in config.yaml."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class RelationConstants:
    """What Eq. 1 and 2 need, metres.

    delta_min_m: Delta_min, smallest displacement that is a move; tau_m: tau, displacement below which an instance is stable and
    above which a bystander spoils a query; motion_m: two positions within a visit farther apart than this are motion, for which
    Eq. 1 states no value.
    """

    delta_min_m: float
    tau_m: float
    motion_m: float


@dataclass(frozen=True, kw_only=True)
class SuccessConstants:
    """What Eq. 4 needs.

    radius_m: R, success radius, metres; visible_px: smallest mask of a visible target, pixels; sweep_deg: pitches of the
    look-down sweep at the stop, degrees.
    """

    radius_m: float
    visible_px: int
    sweep_deg: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class TaskConstants(RelationConstants, SuccessConstants):
    """All constants of the task (Table "params" of the paper)."""

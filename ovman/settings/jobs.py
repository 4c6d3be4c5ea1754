"""The job of one arm: its entry without the words of the tables, and the settings that its agents and its runs may read."""

from __future__ import annotations

from typing import Any

from ovman.settings.arms import WORDS, Arm, ArmJob
from ovman.settings.settings import Settings, matching

RUN_CONSTANTS = ("admissibility.min_mask_px",)
"""Constants that every arm's predictions and rollouts may read, with those that its entry names."""


def own_constants(arm: Arm) -> tuple[str, ...]:
    """Return patterns of the constants that an arm reads because its entry names them."""
    return (*arm.constants, *(("perception.*",) if "networks" in arm.needs else ()))


def job_of_arm(settings: Settings, name: str) -> dict[str, Any]:
    """Return the entry of an arm's jobs as JSON values, with the entry of the arm that it executes."""
    arm = settings.arms[name]
    job = _entry(settings, arm)
    if arm.executes is not None:
        job["executed"] = _entry(settings, settings.arms[arm.executes])
    return job


def arm_job(settings: Settings, name: str) -> ArmJob:
    """Return an arm as one of its jobs is given it."""
    return ArmJob.model_validate(job_of_arm(settings, name))


def settings_of_arm(settings: Settings, name: str) -> Settings:
    """Return the settings that the jobs of an arm may read. Reading another constant raises AttributeError."""
    arm = settings.arms[name]
    involved = [arm] if arm.executes is None else [arm, settings.arms[arm.executes]]
    constants = settings.constants()
    patterns = (*RUN_CONSTANTS, *(pattern for one in involved for pattern in own_constants(one)))
    return settings.partial({key: constants[key] for key in matching(patterns, constants)}, f"arm {name}")


def _entry(settings: Settings, arm: Arm) -> dict[str, Any]:
    marks = sorted(other.budget for other in settings.arms.values() if other.cut_from == arm.name and other.budget is not None)
    return {**{key: value for key, value in arm if key not in WORDS}, "marks": marks}

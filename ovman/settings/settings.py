"""All settings of config.yaml as one typed tree, and the part of them that the jobs of one arm read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Self

from pydantic import BaseModel, Field, model_validator

from ovman.agents.cow import Cow, Locobot
from ovman.agents.dualmap import Dualmap
from ovman.agents.dynamem import Dynamem
from ovman.agents.joint import Joint
from ovman.agents.react import React
from ovman.section import Section, plain
from ovman.settings import benchmark as common
from ovman.settings.arms import WORDS, Arm, ArmJob, Arms
from ovman.settings.comparisons import Comparisons, GateSweep, PaperRows, Sensitivity
from ovman.settings.networks import Perception, Training
from ovman.settings.splits import Splits, complete_splits


class Settings(Section):
    """All settings of config.yaml, by section. Each plug-in adds a section (`ovman.settings.plugins`)."""

    benchmark: common.Benchmark
    camera: common.Camera
    tour: common.Tour
    primitives: common.Primitives
    mover: common.Mover
    candidates: common.Candidates
    splits: Splits
    sensors: common.Levels
    measurement: common.Measurement
    admissibility: common.Admissibility
    success: common.Success
    perception: Perception
    maps: common.Maps
    grounding: common.Grounding
    association: common.Association
    appearance: common.Appearance
    single_visit: common.SingleVisit
    evaluation: common.Evaluation
    sensitivity: Sensitivity
    tolerances: Sensitivity
    gate_sweep: GateSweep
    dualmap: Dualmap = Dualmap()
    joint: Joint = Joint()
    dynamem: Dynamem = Dynamem()
    react: React = React()
    training: Training = Training()
    locobot: Locobot = Locobot()
    cow: Cow = Cow()
    controls: common.Controls
    remote: common.Remote
    plugins: dict[str, str] = Field(description="modules of plug-ins by the names of their sections")
    arms: Arms
    comparisons: Comparisons
    paper: PaperRows

    _complete_splits = model_validator(mode="before")(complete_splits)

    @classmethod
    def partial(cls, values: Mapping[str, Any], holder: str = "this job", path: str = "") -> Self:
        """Build settings that hold only these constants, by dotted name (as `constants` gives them) or by section.

        holder: whom the settings are for. Reading a constant that they lack raises AttributeError with this name.
        """
        tree: dict[str, Any] = {}
        for key, value in values.items():
            *sections, name = key.split(".")
            here = tree
            for section in sections:
                here = here.setdefault(section, {})
            here[name] = value
        return super().partial(tree, holder, path)

    def constants(self) -> dict[str, Any]:
        """Return every constant that these settings hold by its dotted name, in the order of the models.

        Sequences are tuples. A mapping, such as section `arms`, is one constant, a dictionary in the order of the tables. The
        entries of `splits` have constants of their own, such as "splits.main.scenes".
        """
        return dict(_walk("", self))

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return these settings with other values of some constants, by dotted name. AttributeError for one that they lack."""
        constants = self.constants()
        for name in values:
            if name not in constants:
                raise AttributeError(f"settings: {self._holder or 'all sections'} lack {name!r}, so it cannot be changed")
        return self.partial({**constants, **values}, self._holder)


def _walk(path: str, section: BaseModel) -> Iterator[tuple[str, Any]]:
    for name in type(section).model_fields:
        if name == "plugins" or name not in vars(section):  # section plugins says which sections there are
            continue
        value, where = getattr(section, name), f"{path}{name}"
        if isinstance(value, BaseModel):
            yield from _walk(f"{where}.", value)
        elif where == "splits":
            for key, split in value.items():
                yield from _walk(f"splits.{key}.", split)
        else:
            yield where, plain(value)


def matching(patterns: Iterable[str], names: Iterable[str]) -> tuple[str, ...]:
    """Return the dotted names that match a pattern, "a.b" or "a.*", in their order."""
    patterns = tuple(patterns)
    beginnings = tuple(pattern.removesuffix("*") for pattern in patterns if pattern.endswith(".*"))
    return tuple(name for name in names if name in patterns or name.startswith(beginnings))


RUN_CONSTANTS = ("admissibility.min_mask_px",)
"""Constants that every arm's predictions and rollouts may read, with those that its entry names."""


def own_constants(arm: Arm) -> tuple[str, ...]:
    """Return patterns of the constants that an arm reads because its entry names them."""
    return (*arm.constants, *(("perception.*",) if arm.embeds_phrases else ()))


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

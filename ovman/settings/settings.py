"""All settings of config.yaml as one typed tree."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Self

from pydantic import BaseModel, Field, model_validator

from ovman.agents.cow.settings import Cow, Locobot
from ovman.agents.dualmap.settings import Dualmap
from ovman.agents.dynamem.settings import Dynamem
from ovman.agents.joint.settings import Joint
from ovman.agents.react.settings import React
from ovman.section import Section, listed
from ovman.settings.arms import Arms
from ovman.settings.benchmark import (
    Admissibility,
    Appearance,
    Association,
    Benchmark,
    Camera,
    Candidates,
    Controls,
    Evaluation,
    Grounding,
    Maps,
    Measurement,
    Mover,
    Primitives,
    SingleVisit,
    Success,
    Tour,
)
from ovman.settings.comparisons import Comparisons, PaperRows
from ovman.settings.networks import Perception, Training
from ovman.settings.remote import Remote
from ovman.settings.sensitivity import GateSweep, Sensitivity
from ovman.settings.sensors import Levels
from ovman.settings.splits import Splits, complete_splits


class Settings(Section):
    """All settings of config.yaml, by section. Each plug-in adds a section (`ovman.settings.plugins`)."""

    benchmark: Benchmark
    camera: Camera
    tour: Tour
    primitives: Primitives
    mover: Mover
    candidates: Candidates
    splits: Splits
    sensors: Levels
    measurement: Measurement
    admissibility: Admissibility
    success: Success
    perception: Perception
    maps: Maps
    grounding: Grounding
    association: Association
    appearance: Appearance
    single_visit: SingleVisit
    evaluation: Evaluation
    sensitivity: Sensitivity
    gate_sweep: GateSweep
    dualmap: Dualmap = Dualmap()
    joint: Joint = Joint()
    dynamem: Dynamem = Dynamem()
    react: React = React()
    training: Training = Training()
    locobot: Locobot = Locobot()
    cow: Cow = Cow()
    controls: Controls
    remote: Remote
    plugins: dict[str, str] = Field(description="modules of plug-ins by the names of their sections")
    arms: Arms
    comparisons: Comparisons
    paper: PaperRows

    _complete_splits = model_validator(mode="before")(complete_splits)

    @classmethod
    def partial(cls, constants: Mapping[str, Any], holder: str = "this job") -> Self:
        """Build settings that hold only these constants.

        Args:
            constants: Valid values by dotted name, as `constants` gives them or as JSON keeps them.
            holder: What the settings are for. Reading a constant that they lack raises AttributeError with this name.
        """
        tree: dict[str, Any] = {}
        for key, value in constants.items():
            *sections, name = key.split(".")
            here = tree
            for section in sections:
                here = here.setdefault(section, {})
            here[name] = value
        return cls.owned(tree, holder)

    def constants(self) -> dict[str, Any]:
        """Return every constant that these settings hold by its dotted name, in the order of config.yaml.

        Sequences are tuples. A mapping, such as section `arms`, is one value: a list of its entries in the order of the tables.
        """
        return dict(_walk("", self))

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return these settings with other values of some constants, by dotted name.

        Raises:
            AttributeError: The settings do not hold one of the constants.
        """
        constants = self.constants()
        for name in values:
            if name not in constants:
                raise AttributeError(f"{self._stage!r} does not own the constant {name!r} and cannot change it")
        return self.partial({**constants, **values}, self._stage)


def _walk(path: str, section: BaseModel) -> Iterator[tuple[str, Any]]:
    for name in type(section).model_fields:
        if name == "plugins" or name not in vars(section):  # section plugins says which sections there are
            continue
        value, where = getattr(section, name), f"{path}{name}"
        if isinstance(value, BaseModel):
            yield from _walk(f"{where}.", value)
        else:
            yield where, listed(value)


def matching(patterns: Iterable[str], names: Iterable[str]) -> tuple[str, ...]:
    """Return those of `names` (dotted) that are among the patterns, "a.b" or "a.*"; sorted."""
    patterns = tuple(patterns)
    beginnings = tuple(pattern.removesuffix("*") for pattern in patterns if pattern.endswith(".*"))
    return tuple(sorted(name for name in names if name in patterns or name.startswith(beginnings)))

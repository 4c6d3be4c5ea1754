"""What is reported: comparisons of arms, rows of the paper, and sweeps of thresholds (config/report.yaml)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise, product
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from ovman.section import Count, Listed, Metres, Section, Some
from ovman.settings.arms import Arm, Kind, Need
from ovman.settings.benchmark import Measurement


class Pair(Section):
    """Two arms over the same episodes. A win is an episode on which `arm` succeeds and `baseline` does not."""

    name: str = Field(description="the key of its entry: the title of the comparison in the tables")
    arm: str = Field(description="the arm that is tested")
    baseline: str = Field(description="the arm that it is tested against")
    every_split: bool = Field(False, description="whether it is tested on the other splits, too, where both arms are asked")


def _without_nulls(value: Any) -> Any:
    return {key: entry for key, entry in value.items() if entry is not None} if isinstance(value, dict) else value


def _named(value: Any) -> Any:
    entries = _without_nulls(value)
    if not isinstance(entries, dict):
        return entries
    return {name: {**entry, "name": name} if isinstance(entry, dict) else entry for name, entry in entries.items()}


Pairs = Annotated[dict[str, Pair], BeforeValidator(_named)]
"""By title, in the order of the tables; an entry that is null is left out."""
ByArm = Annotated[dict[str, str], BeforeValidator(_without_nulls)]
"""By the name of an arm, in the order of the tables; an entry that is null is left out."""


class Memory(Section):
    """Two static arms that answer from the maps of both visits and from that of the second, with the same perception."""

    arm: str = Field(description="the arm that keeps both visits")
    baseline: str = Field(description="the arm that has the second alone")


class Control(Section):
    """An arm of the table of controls: a control, or an agent for comparison."""

    name: str = Field(description="the key of its entry: an arm")
    title: str = Field("", description="what the figure calls it; the arm's system if not given")
    role: Annotated[str, Field(pattern=r"^[a-z_]*$")] = Field(
        "", description='"controls.role" is the arm in statements of our own'
    )
    means: str = Field("", description="what it is, and what its success says, on the page of results; nothing for an agent")


Controls = Annotated[dict[str, Control], BeforeValidator(_named)]
"""By the name of an arm, in the order of the tables; an entry that is null is left out."""


class System(Section):
    """A row of the overview: the arms of one system."""

    name: str = Field(description="the key of its entry: the title of the row")
    static: str | None = Field(None, description="its arm on the static gate")
    embodied: str | None = Field(None, description="its arm that drives")


Systems = Annotated[dict[str, System], BeforeValidator(_named)]
"""By title, in the order of the table; an entry that is null is left out."""


class Comparisons(Section):
    """The arms that are tested against each other, and the arms of single tables.

    Arms that are named here need not be there: what needs them is left out.
    """

    agent: str = Field(description="static arm whose failures are told apart, and that held-out sentences are put to")
    memory: Memory = Field(
        description="whose margin is re-derived under other thresholds; its `arm` is asked again under other gates"
    )
    rungs: ByArm = Field(description="rungs of the error budget from the lowest: static arms, each with its title")
    pairs: Pairs = Field(description="pairs of arms with one answer an episode and seed, by title")
    pairings: Pairs = Field(description="pairs of static arms of which at least one has several runs, by title")
    readings: ByArm = Field(
        description="static arms of the table of readings, each with the map that it reads; a map's first is its baseline"
    )
    difficulty: ByArm = Field(description="static arms that the table of difficulty shows on a page, each with its title")
    shortcuts: ByArm = Field(description="arms that ignore the relation, each with its words in the table of chance")
    overview: Systems = Field(description="rows of the table of who reaches what on which split, by title")
    controls: Controls = Field(description="arms of the table of controls: agents and controls")


class PaperRows(Section):
    """The arms that are compared with rows of the paper's tables. Of several arms of a row the first stands for it."""

    static: ByArm = Field(description='row of the paper\'s table "static" by static arm')
    embodied: ByArm = Field(description='row of the paper\'s table "embodied" by embodied arm')


def comparison_contradictions(comparisons: Comparisons, arms: Mapping[str, Arm]) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield contradictions between section `comparisons` and the arms: the place, and the message."""
    of_kind = {kind: [name for name, arm in arms.items() if arm.kind is kind] for kind in Kind}
    if comparisons.agent not in of_kind[Kind.STATIC]:
        yield (
            ("comparisons", "agent"),
            f"is {comparisons.agent}, which is not a static arm; there are {', '.join(of_kind[Kind.STATIC])}",
        )
    for role, name in comparisons.memory:
        if name not in of_kind[Kind.STATIC]:
            yield (
                ("comparisons", "memory", role),
                f"is {name}, which is not a static arm; there are {', '.join(of_kind[Kind.STATIC])}",
            )
        elif set(arms[name].needs) - {Need.MAPS} or _another_game(arms[name]):
            yield (
                ("comparisons", "memory", role),
                f"is {name}; name an arm that needs maps at most, is handed nothing, is withheld nothing and runs once",
            )
    for section in ("rungs", "readings", "difficulty", "shortcuts"):
        for name in getattr(comparisons, section):
            if name in of_kind[Kind.EMBODIED]:
                yield ("comparisons", section, name), "is an embodied arm; name a static one"
    for title, system in comparisons.overview.items():
        for kind, arm in ((Kind.STATIC, system.static), (Kind.EMBODIED, system.embodied)):
            if arm is not None and arm in arms and arms[arm].kind is not kind:
                yield ("comparisons", "overview", title, str(kind)), f"is {arm}, which is not an arm of kind {kind}; name one"
    roles = [entry.role for entry in comparisons.controls.values() if entry.role]
    for name, entry in comparisons.controls.items():
        if roles.count(entry.role) > 1:
            yield ("comparisons", "controls", name, "role"), f"is {entry.role}, which is that of another entry, too; rename one"
    tested = {(pair.arm, pair.baseline) for pair in comparisons.pairs.values()}
    for lower, upper in pairwise(comparisons.rungs):
        if (upper, lower) not in tested:
            says = f"follows {lower}, but no entry of comparisons.pairs tests {upper} against {lower}; add it"
            yield ("comparisons", "rungs", upper), says
    for section, pairs in (("pairs", comparisons.pairs), ("pairings", comparisons.pairings)):
        for title, pair in pairs.items():
            place = ("comparisons", section, title)
            here = [arms[name] for name in (pair.arm, pair.baseline) if name in arms]
            if len({arm.kind for arm in here}) > 1:
                yield place, f"compares {pair.arm} with {pair.baseline}, of which one is static and one embodied"
            if section == "pairings" and any(arm.kind is Kind.EMBODIED for arm in here):
                yield place, "has an embodied arm; pairings are of static arms, write it under comparisons.pairs"
            if pair.arm in arms and arms[pair.arm].expected:
                yield place, f"tests {pair.arm}, a stochastic pick; no exact test does, name it as the baseline"


def _another_game(arm: Arm) -> bool:
    """Return whether an arm is given more or less than an agent is, or has several runs."""
    return arm.reads_sightings or arm.reads_labels or arm.runs > 1 or arm.withheld is not None


Lengths = Annotated[tuple[Metres, ...], Listed, Field(min_length=1)]
Pixels = Annotated[tuple[Some, ...], Listed, Field(min_length=1)]

THRESHOLDS: Mapping[str, str] = {
    "drift_tolerance_m": "admissibility.drift_tolerance_m",
    "tau_m": "admissibility.tau_m",
    "delta_min_m": "candidates.delta_min_m",
    "min_mask_px": "admissibility.min_mask_px",
    "motion_m": "admissibility.motion_m",
    "validity_radius_m": "admissibility.validity_radius_m",
    "spawn_clearance_m": "candidates.spawn_clearance_m",
    "visible_px": "success.visible_px",
}
"""The constant of config.yaml that each list of section `sensitivity` has values of: all that a verdict reads."""


class Sensitivity(Section):
    """Under which settings of its thresholds admissibility is re-derived: every combination of one value of each list."""

    combinations: Count = Field(description="how many settings that makes; refused where the lists make another number")
    drift_tolerance_m: Lengths = Field(description="metres")
    tau_m: Lengths = Field(description="metres, tau of Eq. 1 and of the bystanders; the agent's stays")
    delta_min_m: Lengths = Field(description="metres, Delta_min of the predicates and of the applied displacement")
    min_mask_px: Pixels = Field(description="pixels from which an instance is recorded")
    motion_m: Lengths = Field(description="metres between recorded positions from which on they are motion")
    validity_radius_m: Lengths = Field(description="metres from the answer to a navigable cell")
    spawn_clearance_m: Lengths = Field(description="metres from the spawn to the change")
    visible_px: Pixels = Field(description="pixels of the target from the nearest navigable cell")

    @field_validator(*THRESHOLDS)
    @classmethod
    def _distinct(cls, values: tuple[float, ...]) -> tuple[float, ...]:
        if len(set(values)) < len(values):
            raise ValueError("a value is there twice")
        return values

    @model_validator(mode="after")
    def _counted(self) -> Self:
        if (made := math.prod(len(getattr(self, name)) for name in THRESHOLDS)) != self.combinations:
            raise ValueError(f"combinations is {self.combinations}, but the lists make {made}; change one of them")
        return self

    def settings(self) -> Iterator[dict[str, float]]:
        """Yield every setting: values of the thresholds by the names of their lists; the last list varies fastest."""
        for values in product(*(getattr(self, name) for name in THRESHOLDS)):
            yield dict(zip(THRESHOLDS, values, strict=True))


class GateSweep(Section):
    """Under which association gates the static arm of `comparisons.memory` answers again (Fig. diag)."""

    gates_m: Lengths = Field(description="metres, values of gamma")

    @field_validator("gates_m")
    @classmethod
    def _rising(cls, gates_m: tuple[float, ...]) -> tuple[float, ...]:
        if list(gates_m) != sorted(set(gates_m)):
            raise ValueError("the gates do not rise")
        return gates_m


def sensitivity_contradictions(sensitivity: Sensitivity, measurement: Measurement) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield values that trials were not measured for, or that make Eq. 1 contradict itself: the place, and what is to be said."""
    for name, bound in (("min_mask_px", measurement.min_mask_px), ("visible_px", measurement.visible_px)):
        if (least := min(getattr(sensitivity, name))) < bound:
            yield ("sensitivity", name), f"has {least}, but measurement.{name} is {bound}, below which nothing is measured"
    if (most := max(sensitivity.validity_radius_m)) > measurement.answer_to_navigable_m:
        limit = measurement.answer_to_navigable_m
        yield ("sensitivity", "validity_radius_m"), f"has {most}, but measurement.answer_to_navigable_m is {limit}"
    if (tau_m := max(sensitivity.tau_m)) >= (delta_m := min(sensitivity.delta_min_m)):
        says = f"has {tau_m}, but delta_min_m has {delta_m}: an instance would be stable and moved at once"
        yield ("sensitivity", "tau_m"), says

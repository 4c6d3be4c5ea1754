"""What is reported: comparisons of arms, rows of the paper, and sweeps of thresholds (config/report.yaml)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Annotated, Self

from pydantic import Field, field_validator, model_validator

from ovman.section import Count, Distinct, Metres, Named, Section, Some


class Pair(Section):
    """Two arms over the same episodes. A win is an episode on which `arm` succeeds and `baseline` does not."""

    name: str = Field(description="the key of its entry: the title of the comparison in the tables")
    arm: str = Field(description="the arm that is tested")
    baseline: str = Field(description="the arm that it is tested against")
    every_split: bool = Field(False, description="whether it is tested on the other splits, too, where both arms are asked")


Pairs = Annotated[dict[str, Pair], Named]
"""By title, in the order of the tables."""
ByArm = Annotated[dict[str, str], Named]
"""By the name of an arm, in the order of the tables."""


class Memory(Section):
    """Two static arms that answer from the maps of both visits and from that of the second, with the same perception."""

    arm: str = Field(description="the arm that keeps both visits")
    baseline: str = Field(description="the arm that has the second alone")


class Control(Section):
    """An arm of the table of controls: a control, or an agent for comparison."""

    name: str = Field(description="the key of its entry: an arm")
    title: str = Field("", description="what the figure calls it; the arm's system if not given")
    role: Annotated[str, Field(pattern=r"^[a-z_]*$")] = Field("", description='its name in statements, "controls.role"')
    means: str = Field("", description="what it is, and what its success says, on the page of results; nothing for an agent")


Controls = Annotated[dict[str, Control], Named]
"""By the name of an arm, in the order of the tables."""


class System(Section):
    """A row of the overview: the arms of one system."""

    name: str = Field(description="the key of its entry: the title of the row")
    static: str | None = Field(None, description="its arm on the static gate")
    embodied: str | None = Field(None, description="its arm that drives")


Systems = Annotated[dict[str, System], Named]
"""By title, in the order of the table."""


class Comparisons(Section):
    """The arms that are tested against each other, and the arms of single tables.

    Arms that are named here need not be there: what needs them is left out.
    """

    agent: str = Field(description="static arm whose failures are told apart, and that held-out sentences are put to")
    memory: Memory = Field(description="arms whose margin is re-derived under other thresholds and gates")
    rungs: ByArm = Field(description="rungs of the error budget from the lowest: static arms, each with its title")
    pairs: Pairs = Field(description="pairs of arms with one answer an episode and seed, by title")
    pairings: Pairs = Field(description="pairs of static arms of which at least one has several runs, by title")
    readings: ByArm = Field(description="static arms of the table of readings, each with its map; a map's first is its baseline")
    difficulty: ByArm = Field(description="static arms that the table of difficulty shows on a page, each with its title")
    shortcuts: ByArm = Field(description="arms that ignore the relation, each with its words in the table of chance")
    ranks: ByArm = Field(description="pairs of splits whose ranks of systems are compared")
    overview: Systems = Field(description="rows of the table of who reaches what on which split, by title")
    controls: Controls = Field(description="arms of the table of controls: agents and controls")


class PaperRows(Section):
    """The arms that are compared with rows of the paper's tables. Of several arms of a row the first stands for it."""

    static: ByArm = Field(description='row of the paper\'s table "static" by static arm')
    embodied: ByArm = Field(description='row of the paper\'s table "embodied" by embodied arm')


Lengths = Annotated[tuple[Metres, ...], Field(min_length=1), Distinct]
Pixels = Annotated[tuple[Some, ...], Field(min_length=1), Distinct]

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
    """Under which settings of its thresholds admissibility is re-derived: every combination of one value of each list.

    Section `sensitivity` has wide lists, section `tolerances` lists within what is measured of the precision of each threshold.
    """

    combinations: Count = Field(description="how many settings that makes; refused where the lists make another number")
    drift_tolerance_m: Lengths = Field(description="metres")
    tau_m: Lengths = Field(description="metres, tau of Eq. 1 and of the bystanders; the agent's stays")
    delta_min_m: Lengths = Field(description="metres, Delta_min of the predicates and of the applied displacement")
    min_mask_px: Pixels = Field(description="pixels from which an instance is recorded")
    motion_m: Lengths = Field(description="metres between recorded positions from which on they are motion")
    validity_radius_m: Lengths = Field(description="metres from the answer to a navigable cell")
    spawn_clearance_m: Lengths = Field(description="metres from the spawn to the change")
    visible_px: Pixels = Field(description="pixels of the target from the nearest navigable cell")

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

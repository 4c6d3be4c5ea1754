"""The plug-ins of this package: the released CoW and the released DualMap, each with a section of the settings.

Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from ovman.section import Section, Some, Whole
from ovman.settings.plugins import Plugin

COW, DUALMAP = "released_cow", "released_dualmap"
_RULES = Path(__file__).parent / "workflow" / "rules"


class Clone(Section):
    """Released code, run from the user's clone."""

    root: str = Field(description="folder of the clone")
    commit: Annotated[str, Field(pattern=r"^[0-9a-f]{40}$")] = Field(description="Git commit that the clone must be at")
    python: str = Field(description="Python interpreter of the clone's own environment")
    device: Literal["cpu", "cuda"] = Field(description="where its networks run")


class ReleasedCow(Clone):
    """Section `released_cow`: CoW's released code."""

    threshold: Annotated[float, Field(gt=0, lt=1)] = Field(description="relevance from which it takes a detection, as released")
    budget: Some = Field(description="actions, as released")
    processes: Some = Field(description="runners side by side, each with an agent of its own for a share of the episodes")


class ReleasedDualmap(Clone):
    """Section `released_dualmap`: DualMap's released code."""

    guard: Literal["first_only", "every_frame"] = Field(description="frames without a detection that are kept from breaking it")
    maintained: Literal["concatenated_local", "concatenated_global", "preloaded_global"] = Field(
        description="the map that is maintained through two visits; the maps of single visits are of its kind"
    )
    side_px: Annotated[Whole, Field(ge=480, le=4096)] = Field(description="pixels, side of a frame of the dense walks")
    time_limit_s: Annotated[float, Field(gt=0)] = Field(description="seconds after which one run is ended")


PLUGINS = (
    Plugin(COW, ReleasedCow, _RULES / "released_cow.smk"),
    Plugin(DUALMAP, ReleasedDualmap, _RULES / "released_dualmap.smk"),
)

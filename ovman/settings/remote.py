"""Limits of an agent that has its own process."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Section, Some

Seconds = Annotated[float, Field(gt=0)]


class Remote(Section):
    """How long an agent in a process of its own may take, and how much of this machine."""

    connect_s: Seconds = Field(description="seconds until an agent's server answers, its start included")
    tour_s: Seconds = Field(description="seconds for each of begin, familiarise, revisit and ask")
    act_s: Seconds = Field(description="seconds for an action")
    run_s: Seconds = Field(description="seconds for all that an agent does in a run")
    memory_gb: Annotated[float, Field(gt=0)] = Field(description="GB of memory of an agent's processes on this machine, together")
    processes: Some = Field(description="number of an agent's processes on this machine")
    disk_gb: Annotated[float, Field(gt=0)] = Field(description="GB of all files in an agent's own folders")
    file_gb: Annotated[float, Field(gt=0)] = Field(description="GB of the largest file that it may write, its log included")

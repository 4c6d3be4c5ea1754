"""The arms of the evaluation."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from ovman.models.settings.values import Listed, Section, Some


def _function(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", value):
        raise ValueError(f'{value!r} names no function; write "package.module:function"')
    return value


class ArmEntry(Section):
    """One arm of the evaluation."""

    kind: Literal["static", "embodied"] = Field(description="judged by the point that it predicts, or by where it stops")
    agent: Annotated[str, AfterValidator(_function)] = Field(
        description='"module:function", docs/agents.md says what the function is given and gives back'
    )
    system: str = Field(min_length=1, description='title of its row; an embodied arm\'s "agent"')
    memory: str = Field(min_length=1, description="what it keeps of the two visits, in the tables")
    grounding: Literal["own", "handed"] = Field("own", description="whether it finds out itself what the noun means")
    positions: Literal["own", "handed"] = Field("own", description="whether it finds out itself where things are")
    answer: Literal["own", "handed"] = Field("own", description="handed to the oracle only")
    needs: Annotated[tuple[Literal["tours", "maps", "networks", "dualmap"], ...], Listed] = Field(
        (), description="what it is given beside query and observations"
    )
    constants: Annotated[tuple[str, ...], Listed] = Field(
        (), description='settings that it reads, "section.name" or "section.*"; a change of one reruns it'
    )
    executes: str | None = Field(None, description="the static arm whose predictions an embodied arm drives to")
    expected: bool = Field(False, description="its static success is the expectation over a stochastic pick")
    runs: Some = Field(1, description="runs of a static arm over all episodes; its rates are their means")
    embodiment: Literal["default", "locobot"] = Field("default", description="body and camera of an embodied arm")
    released: Literal["cow", "dualmap"] | None = Field(
        None, description="the released system that it is; the arm is left out while section released names no clone of it"
    )
    any_instance: bool = Field(False, description="its own task is to reach any instance; it is judged on that, too")
    budget: Some | None = Field(None, description="actions; primitives.action_budget if not given")
    cut_from: str | None = Field(None, description="the embodied arm whose runs, ended after `budget` actions, are its own")


def _there(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    for name in value:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", str(name)):
            raise ValueError(f"{name!r} cannot name an arm, whose files are called after it; write small letters, digits and _")
    return {name: entry for name, entry in value.items() if entry is not None}


Arms = Annotated[dict[str, ArmEntry], BeforeValidator(_there)]
"""By name, in the order of the tables; an entry that is null is left out."""

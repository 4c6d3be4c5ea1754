"""The one parameter of a stage's rule: canonical text of the constants that the stage owns, and back to typed settings.

Snakemake compares parameters as a set of values without names: two constants that swap their values would pass unnoticed. One
text with names in it does not have that defect.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import PrivateAttr

from ovman.settings import Arm, Settings
from ovman.settings.arms import WORDS, ArmJob
from ovman.settings.plugins import with_sections
from ovman.settings.settings import matching
from ovman.workflow.stages import ENTRIES, STAGES


def canonical(settings: Settings, stage: str, arm: str | None = None) -> str:
    """The parameter of a stage's rule: JSON of its constants by name, and of the digest of the code that it runs.

    arm: the name of the arm that a job is of. Its text has the arm's entry without the words of the tables, the constants that
    the entry names, and the digest of the agent's code; and the same of the arm that it executes.
    """
    from ovman.workflow.provenance import module_digest  # a job only parses, and starts without the parser of sources

    values = settings.constants()
    patterns, code = _stage(settings, stage)
    record: dict[str, Any] = {"stage": stage, "code": code}
    of_stage = patterns
    if arm is not None:
        entry = settings.arms[arm]
        involved = [entry] if entry.executes is None else [entry, settings.arms[entry.executes]]
        patterns = (*patterns, *(pattern for one in involved for pattern in own_constants(one)))
        record["arm"] = _job_of(settings, arm)
        if entry.executes is not None:
            record["arm"]["executed"] = _job_of(settings, entry.executes)
        record["agent"] = [module_digest(one.agent.partition(":")[0]) for one in involved]
        record["of_agent"] = sorted(set(matching(patterns, values)) - set(matching(of_stage, values)))
    record["constants"] = {name: values[name] for name in matching(patterns, values)}
    for name, fields in ENTRIES.get(stage, {}).items():
        for key in [one for one in record["constants"] if one.startswith(f"{name}.") and one.split(".")[2] not in fields]:
            del record["constants"][key]
    sections = {name.partition(".")[0] for name in record["constants"]}
    if plugins := {name: module for name, module in settings.plugins.items() if name in sections}:
        record["plugins"] = plugins
    return json.dumps(record, separators=(",", ":"))


def _stage(settings: Settings, stage: str) -> tuple[tuple[str, ...], str]:
    """Return patterns of the constants that a stage owns; KeyError for no stage."""
    return STAGES[stage], ""


def own_constants(arm: Arm) -> tuple[str, ...]:
    """Patterns of the constants that an arm reads beside those of its stage."""
    return (*arm.constants, *(("perception.*",) if "networks" in arm.needs else ()))


def _job_of(settings: Settings, name: str) -> dict[str, Any]:
    marks = sorted(other.budget for other in settings.arms.values() if other.cut_from == name and other.budget is not None)
    return {**{key: value for key, value in settings.arms[name] if key not in WORDS}, "marks": marks}


class StageSettings(Settings):
    """The settings of one stage: typed as all settings are, holding only the constants that the stage owns.

    Reading another constant raises AttributeError that names the stage and the constant. `stage`: name of the stage. `canonical`:
    the text that the settings were parsed from, which also has the digest of the stage's code; it keys what a stage keeps.
    """

    _canonical: str = PrivateAttr("")
    _stage: str = PrivateAttr("")
    _arm: ArmJob | None = PrivateAttr(None)

    @classmethod
    def parse(cls, canonical: str) -> StageSettings:
        """The settings of a rule's parameter."""
        record = json.loads(canonical)
        made = with_sections(cls, record.get("plugins", {})).partial(record["constants"], f"stage {record['stage']!r}")
        made._stage = record["stage"]
        made._canonical = canonical
        if "arm" in record:
            made._arm = ArmJob.model_validate(record["arm"])
        return made

    @property
    def stage(self) -> str:
        """Name of the stage."""
        return self._stage

    @property
    def canonical(self) -> str:
        """The text that the settings were parsed from."""
        return self._canonical

    def with_values(self, values: Mapping[str, Any]) -> StageSettings:
        """The same with other values of some constants, by dotted name. AttributeError for one that the stage does not own."""
        record = json.loads(self._canonical)
        for name in values:
            if name not in record["constants"]:
                raise AttributeError(f"stage {self._stage!r} does not own the constant {name!r} and cannot change it")
        record["constants"] |= values
        return StageSettings.parse(json.dumps(record, separators=(",", ":")))

    @property
    def arm(self) -> ArmJob:
        """The arm that the job is of. AttributeError for a stage whose jobs are of no arm."""
        if self._arm is None:
            raise AttributeError(f"stage {self._stage!r} has no arm: its jobs are of no one arm")
        return self._arm


def stage_settings(settings: Settings, stage: str, arm: str | None = None) -> StageSettings:
    """The settings that a stage is given, for a job of an arm if one is named: only the constants that it owns."""
    return StageSettings.parse(canonical(settings, stage, arm))


def constants_of(stage: StageSettings) -> Mapping[str, Any]:
    """The constants of a stage by their dotted names, as its parameter has them."""
    values: Mapping[str, Any] = json.loads(stage.canonical)["constants"]
    return values

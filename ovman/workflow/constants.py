"""What a stage is given of config.yaml: the constants that it owns, and nothing else."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from ovman.task import TaskConstants


class Section:
    """A frozen view of a section: attributes are values or sections. What the stage does not own raises AttributeError."""

    __slots__ = ("_members", "_path", "_stage")

    def __init__(self, stage: str, path: str, members: Mapping[str, Any]) -> None:
        for name, value in (("_stage", stage), ("_path", path), ("_members", members)):
            object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self._members[name]
        except KeyError:
            where = f"{self._path}.{name}" if self._path else name
            raise AttributeError(
                f"stage {self._stage!r} does not own the constant {where!r}; STAGES in ovman/workflow/stages.py lists the owners"
            ) from None

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise AttributeError(f"constants are frozen: {name}")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._path!r}, {dict(self._members)!r})"


class StageConstants(Section):
    """The constants of one stage, e.g. constants.camera.width_px, and the canonical text that they were read from.

    `stage`: name of the stage. `arm`: the entry of the arm that the job is of, with its name; of a stage that has no arm there is
    none. `canonical`: the text, which also has the digest of the stage's code; who keeps results beside
    it knows whether they are what the stage would make now.
    """

    __slots__ = ("canonical", "stage")

    def __init__(self, canonical: str) -> None:
        record = json.loads(canonical)
        tree: dict[str, Any] = {}
        for key, value in record["constants"].items():
            *sections, name = key.split(".")
            here = tree
            for section in sections:
                here = here.setdefault(section, {})
            here[name] = tuple(value) if isinstance(value, list) else value
        members = _sections(record["stage"], "", tree)
        super().__init__(record["stage"], "", {**members, "arm": record["arm"]} if "arm" in record else members)
        object.__setattr__(self, "canonical", canonical)
        object.__setattr__(self, "stage", record["stage"])


def _sections(stage: str, path: str, tree: Mapping[str, Any]) -> Mapping[str, Any]:
    return {
        name: Section(stage, where, _sections(stage, where, value)) if isinstance(value, dict) else value
        for name, value in tree.items()
        for where in [f"{path}.{name}" if path else name]
    }


TASK_CONSTANTS: Mapping[str, str] = {
    "delta_min_m": "candidates.delta_min_m",
    "tau_m": "admissibility.tau_m",
    "motion_m": "admissibility.motion_m",
    "radius_m": "success.radius_m",
    "visible_px": "success.visible_px",
    "sweep_deg": "success.sweep_deg",
}
"""Where config.yaml has what `ovman.task` needs."""


class _Task:
    """The constants of the task as far as a stage owns them; another raises as on the stage's own view."""

    def __init__(self, constants: Any) -> None:
        self._constants = constants

    def __getattr__(self, name: str) -> Any:
        if name not in TASK_CONSTANTS:
            raise AttributeError(f"{name!r} is not a constant of the task; there are {', '.join(TASK_CONSTANTS)}")
        section, key = TASK_CONSTANTS[name].split(".")
        return getattr(getattr(self._constants, section), key)


def task_constants(constants: Any) -> TaskConstants:
    """The `TaskConstants` of a stage's view of config.yaml. A constant that the stage does not own raises when it is used."""
    return _Task(constants)  # type: ignore[return-value]

"""config.yaml: its settings with their types and ranges, who owns which constant, and the canonical parameter of a stage.

`load` refuses what is not a setting, or not a value, in one line that says what to write instead. `canonical` is the text that a
stage's rule has as its one parameter: Snakemake compares parameters as a set of nameless values, so two constants that swap their
values would pass unnoticed; one text with names in it does not. Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, field_validator

from ovman.constants import StageConstants, task_constants
from ovman.provenance import code_digest

__all__ = [
    "STAGES",
    "Config",
    "ConfigError",
    "StageConstants",
    "canonical",
    "constants",
    "load",
    "owned",
    "settings",
    "task_constants",
]


class ConfigError(ValueError):
    """config.yaml cannot be used; one line: the file, the setting and the remedy."""


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _sequence(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


Whole = Annotated[int, BeforeValidator(_whole)]
"""2.0 is 2."""
Count = Annotated[Whole, Field(ge=0)]
Some = Annotated[Whole, Field(ge=1)]
Metres = Annotated[float, Field(gt=0)]
Probability = Annotated[float, Field(ge=0, lt=1)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class PerRelation(_Section):
    """A count for each relation."""

    moved: Count = Field(description="MOVED")
    former: Count = Field(description="FORMER")
    moving: Count = Field(description="MOVING")
    stable: Count = Field(description="STABLE")
    appeared: Count = Field(description="APPEARED")
    removed: Count = Field(description="REMOVED")


FLOOR_PLANS = tuple(f"FloorPlan{n}" for first in (1, 201, 301, 401) for n in range(first, first + 30))


class Benchmark(_Section):
    """What is released."""

    seed: Count = Field(description="root of every random number")
    backend: Literal["embedded", "thor"] = Field(description="simulator: the engine of this project, or AI2-THOR's Unity build")
    scenes: Annotated[tuple[str, ...], BeforeValidator(_sequence), Field(min_length=1)] = Field(description="iTHOR floor plans")
    split: PerRelation = Field(description="episodes released per relation")

    @field_validator("scenes")
    @classmethod
    def _floor_plans(cls, scenes: tuple[str, ...]) -> tuple[str, ...]:
        for scene in scenes:
            if scene not in FLOOR_PLANS:
                raise ValueError(f"{scene} is not a floor plan; there are FloorPlan1-30, 201-230, 301-330 and 401-430")
            if scenes.count(scene) > 1:
                raise ValueError(f"{scene} is there twice")
        return scenes


class Camera(_Section):
    """The agent's camera."""

    width_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    height_px: Annotated[Whole, Field(ge=16, le=4096)] = Field(description="pixels")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(description="degrees, vertical")


class Tour(_Section):
    """A visit's tour."""

    waypoints: Some = Field(description="W, farthest-point waypoints")
    headings: Annotated[Whole, Field(ge=1, le=360)] = Field(description="views per waypoint")


class Primitives(_Section):
    """What the agent does, and until when."""

    step_m: Metres = Field(description="metres, one MoveAhead and the spacing of the grid")
    turn_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees, one RotateLeft or RotateRight")
    heading_tolerance_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="degrees")
    action_budget: Some = Field(description="actions")
    stop_within_m: Metres = Field(description="metres")
    blocked_edge_expiry: Some = Field(description="actions")
    stall_after: Some = Field(description="actions")


class Mover(_Section):
    """What moves on its own in MOVING episodes."""

    step_m: Metres = Field(description="metres per agent action")
    lane_min_m: Metres = Field(description="metres, shortest lane")
    pause_probability: Probability = Field(description="probability per agent action")
    turn_probability: Probability = Field(description="probability per agent action")


class Candidates(_Section):
    """What is drawn."""

    draws: PerRelation = Field(description="candidates per relation and scene")
    delta_min_m: Metres = Field(description="metres, Delta_min")
    spawn_clearance_m: Annotated[float, Field(ge=0)] = Field(description="metres")


class Measurement(_Section):
    """The loosest settings that a verdict may be re-derived for."""

    mask_px: Some = Field(description="pixels")
    answer_to_navigable_m: Metres = Field(description="metres")
    visible_px: Some = Field(description="pixels")


class Admissibility(_Section):
    """What makes a trial admissible and certified."""

    tau_m: Metres = Field(description="metres, tau")
    minimum_mask_px: Some = Field(description="pixels")
    validity_radius_m: Metres = Field(description="metres")
    drift_tolerance_m: Annotated[float, Field(ge=0)] = Field(description="metres")
    motion_m: Annotated[float, Field(ge=0)] = Field(description="metres")
    runs: Some = Field(description="certification runs")


class Success(_Section):
    """The success test (Eq. 4)."""

    radius_m: Metres = Field(description="metres, R")
    visible_px: Some = Field(description="pixels")
    sweep_deg: Annotated[tuple[Annotated[Whole, Field(ge=-30, le=60)], ...], BeforeValidator(_sequence), Field(min_length=1)] = (
        Field(description="degrees down")
    )


class Association(_Section):
    """The reference agent's association of two visits."""

    gate_m: Metres = Field(description="metres, gamma")
    feature_scale_m: Annotated[float, Field(ge=0)] = Field(description="metres, lambda")
    track_spread_m: Annotated[float, Field(ge=0)] = Field(description="metres, tau_trk")


class SingleVisit(_Section):
    """The single-visit baseline."""

    samples: Some = Field(description="Monte Carlo draws")


class Evaluation(_Section):
    """How arms are run and reported."""

    seeds: Annotated[tuple[Count, ...], BeforeValidator(_sequence), Field(min_length=1)] = Field(
        description="embodied runs per arm"
    )
    confidence: Annotated[float, Field(gt=0, lt=1)] = Field(description="level of the intervals")

    @field_validator("seeds")
    @classmethod
    def _distinct(cls, seeds: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(seeds)) < len(seeds):
            raise ValueError("a seed is there twice")
        return seeds


class Config(_Section):
    """All settings."""

    benchmark: Benchmark
    camera: Camera
    tour: Tour
    primitives: Primitives
    mover: Mover
    candidates: Candidates
    measurement: Measurement
    admissibility: Admissibility
    success: Success
    association: Association
    single_visit: SingleVisit
    evaluation: Evaluation


# Who owns which constant: "a.b" is one, "a.*" is all of a section. A change reruns the stages that own it and what follows them.
# benchmark.scenes and evaluation.seeds say which files there are; who owns them as well puts them into its records.
_SIMULATOR = ("benchmark.backend", "camera.*", "primitives.step_m", "primitives.turn_deg")
_RUNNING = ("benchmark.seed", "benchmark.backend", "camera.*", "primitives.*", "success.sweep_deg") + (
    _GAIT := ("mover.step_m", "mover.pause_probability", "mover.turn_probability")
)
STAGES: Mapping[str, tuple[str, ...]] = {
    "scenes": (*_SIMULATOR, "tour.waypoints"),
    "candidates": (
        "benchmark.seed",
        "candidates.*",
        "tour.headings",
        "mover.lane_min_m",
        "primitives.step_m",
    ),
    "trials": (*_SIMULATOR, *_GAIT, "benchmark.seed", "tour.headings", "measurement.*", "success.sweep_deg"),
    "admissible": (
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
        "admissibility.tau_m",
        "admissibility.minimum_mask_px",
        "admissibility.validity_radius_m",
        "admissibility.drift_tolerance_m",
        "admissibility.motion_m",
        "success.visible_px",
    ),
    "certified": (*_RUNNING, "admissibility.runs"),
    "episodes": (
        "benchmark.seed",
        "benchmark.backend",
        "benchmark.scenes",
        "benchmark.split.*",
        "success.*",
    ),
    "predictions": ("association.*", "admissibility.tau_m", "admissibility.minimum_mask_px"),
    "executions": (*_RUNNING, "association.*", "admissibility.tau_m", "admissibility.minimum_mask_px"),
    "runs": ("success.*",),
    "metrics": ("benchmark.seed", "success.radius_m", "single_visit.samples", "evaluation.confidence"),
    "figures": ("camera.*", "admissibility.minimum_mask_px"),
    "tables": (
        "tour.*",
        "success.*",
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
        "association.*",
        "admissibility.*",
        "primitives.*",
        "mover.*",
        "single_visit.samples",
        "evaluation.confidence",
    ),
}

# What is measured must serve the verdict in force: (verdict, bound, how the bound must compare).
_BOUNDS = (
    ("admissibility.minimum_mask_px", "measurement.mask_px", "at most"),
    ("success.visible_px", "measurement.visible_px", "at most"),
    ("admissibility.validity_radius_m", "measurement.answer_to_navigable_m", "at least"),
)


def settings(config: Config) -> dict[str, Any]:
    """Every constant by its dotted name, in the order of config.yaml. Sequences are tuples."""

    def walk(path: str, section: BaseModel) -> Iterator[tuple[str, Any]]:
        for name in type(section).model_fields:
            value = getattr(section, name)
            where = f"{path}{name}"
            if isinstance(value, BaseModel):
                yield from walk(f"{where}.", value)
            else:
                yield where, value

    return dict(walk("", config))


def owned(stage: str, names: Sequence[str]) -> tuple[str, ...]:
    """Those of `names` (dotted) that a stage owns, sorted. Raises KeyError for a stage that is not in STAGES."""
    whole = {pattern for pattern in STAGES[stage] if not pattern.endswith(".*")}
    beginnings = tuple(pattern.removesuffix("*") for pattern in STAGES[stage] if pattern.endswith(".*"))
    return tuple(sorted(name for name in names if name in whole or name.startswith(beginnings)))


def canonical(config: Config, stage: str) -> str:
    """The one parameter of a stage's rule: JSON of its constants by name, and of the digest of the code that it runs."""
    values = settings(config)
    record = {
        "stage": stage,
        "constants": {name: values[name] for name in owned(stage, list(values))},
        "code": code_digest(stage),
    }
    return json.dumps(record, sort_keys=True, separators=(",", ":"))


def constants(config: Config, stage: str) -> StageConstants:
    """The view of `config` that a stage is given: only what it owns."""
    return StageConstants(canonical(config, stage))


def load(source: str | Path | Mapping[str, Any], files: Sequence[str | Path] = ()) -> Config:
    """The settings of a YAML file or of a mapping. Sections that begin with "x-" are the user's own and are ignored.

    `files` are those that a mapping was merged from, later ones winning; an error names the one that has the wrong setting.
    Raises ConfigError in one line.
    """
    if isinstance(source, Mapping):
        tree, files = source, [Path(f) for f in files]
    else:
        tree, files = _read(Path(source)), [Path(source)]
    if not isinstance(tree, Mapping):
        raise ConfigError(f"{_file(files, ())}: holds {_shown(tree)}; it must hold sections (benchmark:, camera:, ...)")
    try:
        config = Config.model_validate({k: v for k, v in tree.items() if not str(k).startswith("x-")})
    except ValidationError as error:
        raise ConfigError(_line(error, files)) from None
    values = settings(config)
    for verdict, bound, needed in _BOUNDS:
        if values[bound] > values[verdict] if needed == "at most" else values[bound] < values[verdict]:
            where = _file(files, tuple(verdict.split(".")))
            needs = f"{bound} must be {needed} that and is {values[bound]}"
            raise ConfigError(f"{where}: {verdict} is {values[verdict]}, but {needs}; change one of the two")
    return config


class _Loader(yaml.SafeLoader):
    """YAML as Snakemake reads it, but a key that is there twice is an error."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(problem=f"{key} is there twice", problem_mark=node.start_mark)
        return super().construct_mapping(node, deep)


def _read(path: Path) -> Any:
    try:
        return yaml.load(path.read_text(encoding="utf-8"), _Loader)  # noqa: S506 (a SafeLoader)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}; give the path of a config.yaml") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not UTF-8 text") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        raise ConfigError(f"{path}:{mark.line + 1 if mark else 1}: {error.problem}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: {' '.join(str(error).split())}") from None


def _file(files: Sequence[str | Path], location: Sequence[Any]) -> str:
    """Name of the last file that has the setting at `location`; config.yaml where none is known."""
    for path in reversed([Path(f) for f in files]):
        here: Any = _read(path) if len(files) > 1 else {}
        for name in location:
            here = here.get(name, _ABSENT) if isinstance(here, Mapping) else _ABSENT
        if here is not _ABSENT and here != {}:
            return path.name
    return Path(files[0]).name if files else "config.yaml"


_ABSENT = object()


def _line(error: ValidationError, files: Sequence[str | Path]) -> str:
    """The first thing that is wrong: where, what, and what to do."""
    # A name that is not a setting explains a setting that is missing.
    first = min(error.errors(), key=lambda e: {"extra_forbidden": 0, "missing": 2}.get(e["type"], 1))
    location = tuple(first["loc"])
    path = [str(name) for name in location if not isinstance(name, int)]
    name = ".".join(path)
    where = _file(files, [p for p in location if not isinstance(p, int)])
    if first["type"] == "extra_forbidden":
        return f"{where}: {name} is not a setting; {_nearest(path)}"
    field = _field(path)
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if first["type"] == "missing":
        return f"{where}: {name}{meaning} is missing; add it, the repository's config.yaml has its value"
    value, says = first["input"], re.sub(r"^(Input should|Value should|Value error,|Tuple should) ", "", first["msg"])
    says = re.sub(r" after validation, not \d+$", "", says).replace("tuple", "list")
    if first["type"] == "value_error":
        return f"{where}: {name}: {says}"
    if first["type"] in ("model_type", "model_attributes_type"):
        return f"{where}: {name} is {_shown(value)}; it must be a section with settings of its own"
    hint = (
        "; write numbers without quotes, and give changes as a file (--configfile)"
        if isinstance(value, str) and "valid" in says
        else ""
    )
    return f"{where}: {name} is {_shown(value)}; it must {says}{meaning}{hint}"


def _shown(value: Any) -> str:
    text = json.dumps(value, default=str) if not isinstance(value, float) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _models(path: Sequence[str]) -> type[BaseModel] | None:
    model: Any = Config
    for name in path:
        field = model.model_fields.get(name)
        model = field.annotation if field is not None else None
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            return None
    return model


def _field(path: Sequence[str]) -> Any:
    model = _models(path[:-1])
    return None if model is None or not path else model.model_fields.get(path[-1])


def _nearest(path: Sequence[str]) -> str:
    """The nearest setting to a wrong name: in its own section first, then anywhere."""
    model, wrong = _models(path[:-1]), path[-1]
    here = list(model.model_fields) if model is not None else []
    everywhere = {n.rsplit(".", 1)[-1]: n for n in _names()}
    for cutoff, elsewhere in ((0.9, True), (0.5, False), (0.7, True)):
        near = difflib.get_close_matches(wrong, here, n=1, cutoff=cutoff)
        if near:
            return f"did you mean {near[0]}?"
        near = difflib.get_close_matches(wrong, list(everywhere), n=1, cutoff=cutoff) if elsewhere else []
        if near:
            return f"did you mean {everywhere[near[0]]}?"
    return f"{'.'.join(path[:-1]) or 'config.yaml'} has {', '.join(here)}"


def _names(model: type[BaseModel] = Config, path: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _names(kind, f"{path}{name}.")
        else:
            yield f"{path}{name}"

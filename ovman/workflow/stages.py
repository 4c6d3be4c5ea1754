"""Which stage owns which constant, and the canonical text that a stage's rule has as its one parameter.

Snakemake compares parameters as a set of nameless values, so two constants that swap their values would pass unnoticed; one text
with names in it does not.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from ovman.models.settings.sections import ArmEntry, Config
from ovman.workflow.constants import StageConstants
from ovman.workflow.provenance import code_digest, module_digest

# Who owns which constant: "a.b" is one, "a.*" is all of a section. A change reruns the stages that own it and what follows them.
# benchmark.scenes and evaluation.seeds say which files there are; who owns them as well puts them into its records.
_SIMULATOR = ("benchmark.backend", "camera.*", "primitives.step_m", "primitives.turn_deg")
_RUNNING = ("benchmark.seed", "benchmark.backend", "camera.*", "primitives.*", "success.sweep_deg") + (
    _GAIT := ("mover.step_m", "mover.pause_probability", "mover.turn_probability")
)
_DETECTING = tuple(f"perception.detector.{name}" for name in ("architecture", "side_px", "confidence", "minimum_mask_px"))
_PREDICTING = ("benchmark.seed", "camera.field_of_view_deg", "admissibility.minimum_mask_px", "success.radius_m")
_METRICS = (
    "arms",
    "benchmark.seed",
    "success.radius_m",
    "single_visit.samples",
    "evaluation.confidence",
    "evaluation.near_miss_m",
)
STAGES: Mapping[str, tuple[str, ...]] = {
    "simulator": ("benchmark.backend",),
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
    "pictures": (
        "benchmark.backend",
        "camera.*",
        "primitives.step_m",
        "primitives.turn_deg",
        "training.seed",
        "training.views",
        "training.held_out_views",
        "benchmark.scenes",
    ),
    "crops": ("perception.encoder.crop_padding", "training.encoder.crop_px"),
    "detector": (
        "training.seed",
        "training.detector.*",
        *_DETECTING,
    ),
    "detected": (
        *_DETECTING,
        "perception.encoder.crop_padding",
        "training.encoder.crop_px",
        "training.encoder.detected_one_in",
    ),
    "encoder": ("training.seed", "training.encoder.*"),
    "models": ("training.*", "benchmark.scenes"),
    "detections": ("camera.field_of_view_deg", "perception.*"),
    "maps": ("maps.*",),
    "nouns": ("perception.device", "perception.trust_pickles", "perception.encoder.*"),
    "walks": (
        *_SIMULATOR,
        *_GAIT,
        "benchmark.seed",
        "perception.*",
        "dualmap.runs",
        "dualmap.walk.*",
        "dualmap.observation.*",
    ),
    "dualmap": ("benchmark.seed", "dualmap.runs", "dualmap.maintained", "dualmap.local_map.*", "dualmap.global_map.*"),
    "dualmap_objects": (),
    # And of each arm the constants that its entry in section `arms` names.
    "predictions": _PREDICTING,
    "executions": (*_RUNNING, "admissibility.minimum_mask_px"),
    "released_cow": (*_RUNNING, "released.cow.*"),
    "released_dualmap_setup": tuple(f"released.dualmap.{name}" for name in ("root", "commit", "python", "device")),
    "released_dualmap": (
        *_SIMULATOR,
        *_GAIT,
        "benchmark.seed",
        "dualmap.runs",
        "dualmap.walk.turn_deg",
        "released.dualmap.*",
    ),
    "released_dualmap_predictions": _PREDICTING,
    "runs": ("success.*",),
    "metrics": _METRICS,
    "static": _METRICS,
    "language": (
        "benchmark.seed",
        "grounding.*",
        "association.*",
        "admissibility.tau_m",
        "success.radius_m",
        "evaluation.confidence",
    ),
    "perception": ("perception.detector.minimum_mask_px",),
    "backprojection": ("camera.field_of_view_deg", "perception.detector.minimum_mask_px"),
    "figures": ("camera.*", "admissibility.minimum_mask_px"),
    "findings": (
        "benchmark.backend",
        "perception.detector.architecture",
        "perception.detector.weights",
        "perception.encoder.model",
        "perception.encoder.weights",
        "evaluation.confidence",
    ),
    "tables": (
        "arms",
        "tour.*",
        "success.*",
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
        "association.*",
        "grounding.*",
        "maps.*",
        "admissibility.*",
        "primitives.*",
        "mover.*",
        "single_visit.samples",
        "evaluation.confidence",
        "evaluation.near_miss_m",
        "perception.detector.confidence",
        "perception.detector.minimum_mask_px",
    ),
}


def settings(config: Config) -> dict[str, Any]:
    """Every constant by its dotted name, in the order of config.yaml. Sequences are tuples.

    Section `arms` is one value, a list of entries with their names: their order is that of the tables.
    """

    def walk(path: str, section: BaseModel) -> Iterator[tuple[str, Any]]:
        for name in type(section).model_fields:
            value = getattr(section, name)
            where = f"{path}{name}"
            if isinstance(value, BaseModel):
                yield from walk(f"{where}.", value)
            elif where == "arms":
                yield where, [{"name": name, **dict(entry)} for name, entry in value.items()]
            else:
                yield where, value

    return dict(walk("", config))


def owned(stage: str, names: Iterable[str]) -> tuple[str, ...]:
    """Those of `names` (dotted) that a stage owns, sorted. Raises KeyError for a stage that is not in STAGES."""
    return matching(STAGES[stage], names)


def matching(patterns: Iterable[str], names: Iterable[str]) -> tuple[str, ...]:
    """Those of `names` (dotted) that are among the patterns, "a.b" or "a.*"; sorted."""
    patterns = tuple(patterns)
    beginnings = tuple(pattern.removesuffix("*") for pattern in patterns if pattern.endswith(".*"))
    return tuple(sorted(name for name in names if name in patterns or name.startswith(beginnings)))


def canonical(config: Config, stage: str, arm: str | None = None) -> str:
    """The one parameter of a stage's rule: JSON of its constants by name, and of the digest of the code that it runs.

    arm: the name of the arm that a job is of. Its text has the arm's entry without the words of the tables, what the entry names
    among the constants, and the digest of the agent's code; and the same of the arm that it executes.
    """
    values = settings(config)
    record: dict[str, Any] = {"stage": stage, "code": code_digest(stage)}
    patterns = STAGES[stage]
    if arm is not None:
        entry = config.arms[arm]
        involved = [entry] if entry.executes is None else [entry, config.arms[entry.executes]]
        patterns = (*patterns, *(pattern for one in involved for pattern in own_constants(one)))
        record["arm"] = _in_a_job(config, arm)
        if entry.executes is not None:
            record["arm"]["executed"] = _in_a_job(config, entry.executes)
        record["agent"] = [module_digest(one.agent.partition(":")[0]) for one in involved]
        record["of_agent"] = sorted(set(matching(patterns, values)) - set(owned(stage, values)))
    record["constants"] = {name: values[name] for name in matching(patterns, values)}
    return json.dumps(record, sort_keys=True, separators=(",", ":"))


def own_constants(entry: ArmEntry) -> tuple[str, ...]:
    """Patterns of the constants that an arm reads beside those of its stage."""
    return (*entry.constants, *(("perception.*",) if "networks" in entry.needs else ()))


_WORDS = {"system", "memory"}


def _in_a_job(config: Config, name: str) -> dict[str, Any]:
    marks = sorted(other.budget for other in config.arms.values() if other.cut_from == name and other.budget is not None)
    return {"name": name, **{key: value for key, value in config.arms[name] if key not in _WORDS}, "marks": marks}


def constants(config: Config, stage: str, arm: str | None = None) -> StageConstants:
    """The view of `config` that a stage is given, for a job of an arm if one is named: only what it owns."""
    return StageConstants(canonical(config, stage, arm))

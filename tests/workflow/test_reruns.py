"""A change reruns the stages that own what changed and those that follow them, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest
import yaml

from ovman.settings import Arm, Kind
from ovman.settings.config import load
from ovman.settings.settings import matching
from ovman.settings.settings_files import read_merged, with_parts
from ovman.workflow.parameter import own_constants
from ovman.workflow.stages import STAGES, owned
from tests.workflow.conftest import ROOT, TINY

# Sentences are asked of the reference agent: after a colon is whose predictions do not lead to them.
DUALMAP = ("dualmap", "predictions:dualmap")
FRAGMENTS = ("fragments", "readmitted", "readmitted_maps")
RELEASED = ("episodes", "split_episodes")
CHECKPOINTS = (*RELEASED, "readmitted")
"""In the order in which `with_episodes` (common.smk) asks for them."""
AS = {
    "episodes": "split_episodes",
    "scores": "split_scores",
    "split_metrics": "split_embodied_metrics",
    "controls": "paper_controls",
    "split_tables": "all_tables",
}
"""Rules that take the constants of another's stage."""
FOLLOWS: Mapping[str, tuple[str, ...]] = {
    "scenes": (
        "backprojection",
        "candidates",
        "cues",
        "fragments",
        "labels",
        "perception",
        "predictions",
        "trials",
        "walks",
    ),
    "candidates": ("trials",),
    "trials": (
        "admissible",
        "backprojection",
        "certified",
        "cues",
        "detections",
        *RELEASED,
        "labels",
        "predictions:tours",
        "rollouts",
        "perception",
        "segments",
        "walks",
        *FRAGMENTS,
    ),
    "admissible": ("certified", *RELEASED),
    "certified": RELEASED,
    "episodes": (
        "appearance",
        "detections",
        "rollouts",
        "language",
        "maintained",
        "metrics",
        "perception",
        "predictions",
        "scores",
        "segments",
        "tables",
        "walks",
        *DUALMAP,
        "fragments",
        "probes",
        "readmitted",
    ),
    "split_episodes": (
        "all_tables",
        "appearance",
        "detections",
        "maintained",
        "perception",
        "predictions",
        "rollouts",
        "segments",
        "split_embodied_metrics",
        "split_metrics",
        "split_scores",
        "tables",
    ),
    "detections": (
        "rollouts",
        "predictions:tours",
        "backprojection",
        "cues",
        "fragments",
        "labels",
        "maintained",
        "maps",
        "perception",
        "readmitted_maps",
        "segments",
    ),
    "segments": ("predictions:tours", "rollouts"),
    "labels": ("predictions:handed",),
    "cues": ("appearance",),
    "appearance": ("tables",),
    "maintained": ("predictions:handed",),
    "predictions:handed": ("appearance", "metrics"),
    "maps": ("appearance", "fragments", "rollouts", "language", "predictions", "probes"),
    "readmitted": ("readmitted_maps", "readmitted_predictions", "sensitivity"),
    "readmitted_maps": ("readmitted_predictions",),
    "readmitted_predictions": ("sensitivity",),
    "sensitivity": ("tables",),
    "probes": ("tables",),
    "fragments": ("tables",),
    "walks": ("dualmap", "predictions:dualmap"),
    "dualmap": ("dualmap_objects", "predictions:dualmap"),
    "predictions:dualmap": ("metrics",),
    "predictions:tours": ("metrics", "split_metrics"),
    "predictions:executed": ("metrics", "rollouts", "split_metrics"),
    "dualmap_objects": ("tables",),
    "nouns": (
        "rollouts",
        "language",
        "perception",
        "predictions",
        "predictions:dualmap",
        "predictions:handed",
        "probes",
        "readmitted_predictions",
    ),
    "predictions": ("appearance", "fragments", "language", "metrics", "rollouts", "split_metrics"),
    "rollouts": ("scores", "split_scores"),
    "rollouts:main": ("scores:main",),
    "scores": ("metrics",),
    "scores:main": ("metrics",),
    "split_scores": ("split_embodied_metrics",),
    "metrics": ("controls", "paper_controls", "tables"),
    "split_metrics": ("all_tables", "controls", "paper_controls", "tables"),
    "split_embodied_metrics": ("all_tables", "controls", "paper_controls", "tables"),
    "controls": ("all_tables",),
    "paper_controls": ("tables",),
    "language": ("tables",),
    "perception": ("tables",),
    "backprojection": ("tables",),
    "tables": ("all_tables",),
    "all_tables": (),
}


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    return dict(base) | {
        key: merged(base[key], value) if isinstance(value, Mapping) and key in base else value for key, value in over.items()
    }


TREE = merged(read_merged(with_parts(ROOT / "config.yaml")), yaml.safe_load(TINY.read_text()))
CONFIG = load(TREE)
VALUES = CONFIG.constants()
IN_SPLITS = {arm for name, split in CONFIG.splits.items() if split.in_main_job and name != "main" for arm in split.arms}
OF_ARMS = {"static": "predictions", "embodied": "rollouts"}
ASKED_AGAIN = {CONFIG.comparisons.agent, CONFIG.comparisons.memory.baseline, CONFIG.appearance.agent}
"""Static arms whose agents other stages ask as well."""
EXECUTED = {arm.executes for arm in CONFIG.arms.values() if arm.executes and CONFIG.arms[arm.executes].answers_once}
"""Static arms whose answers rollouts read."""
ANOTHER = {"drift_tolerance_m": 0.4, "tau_m": 0.9, "delta_min_m": 1.9, "motion_m": 0.03, "validity_radius_m": 1.1} | {
    "spawn_clearance_m": 1.9,
    "min_mask_px": 500,
    "visible_px": 150,
}
OTHER = {
    "arms": {"two_visits": {"system": "another"}},
    "benchmark.backend": "thor",
    "benchmark.allow_short_split": True,
    "primitives.turn_deg": 20.0,
    "success.sweep_deg": [0, 30],
    "perception.device": "cuda",
    "perception.trust_pickles": True,
    "perception.detector.architecture": "yolov8s-seg",
    "perception.detector.weights": "models/another.safetensors",
    "perception.detector.sha256": "0" * 64,
    "perception.detector.side_px": 352,
    "perception.encoder.model": "models/another.json",
    "perception.encoder.weights": "models/another.safetensors",
    "perception.encoder.sha256": "0" * 64,
    "training.encoder.crop_px": 96,
    "dualmap.maintained": "preloaded_global",
    "splits": {"multi": {"tries": 3}},
    "comparisons.agent": "single_visit",
    "comparisons.memory.arm": "single_visit",
    "comparisons.memory.baseline": "two_visits",
    **{f"sensitivity.{name}": [getattr(CONFIG.sensitivity, name)[0], another] for name, another in ANOTHER.items()},
    "appearance.agent": "two_visits",
    "appearance.equal_scales": False,
    "gate_sweep.gates_m": [1.0, 2.0],
    "comparisons.rungs": {"two_visits": "another"},
    "comparisons.pairs": {"two visits against one": {"arm": "grounding_two_visits"}},
    "comparisons.pairings": {"reference agent against DualMap read as two visits": {"arm": "grounding_two_visits"}},
    "comparisons.readings": {"single_visit": "another"},
    "comparisons.difficulty": {"single_visit": "another"},
    "comparisons.shortcuts": {"category_only": "another"},
    "comparisons.overview": {"CoW": {"embodied": "oracle_check"}},
    "comparisons.controls": {"two_visits": {"means": "another"}},
    "paper.static": {"single_visit": "two"},
    "paper.embodied": {"cow": "one"},
    "cow.centre_only": False,
}


def other(name: str) -> Any:
    """Another value for a constant, which makes sense beside all others."""
    value = VALUES[name]
    return OTHER[name] if name in OTHER else value + 1 if isinstance(value, int) else value * 1.01


def overlay(values: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *path, last = name.split(".")
        section = tree
        for key in path:
            section = section.setdefault(key, {})
        section[last] = value
    return tree


def made(arm: Arm) -> str:
    """The stage that makes an arm's records. Of an arm that no other stage asks only metrics are made."""
    if arm.kind is Kind.EMBODIED:
        return OF_ARMS[arm.kind] + ("" if arm.name in IN_SPLITS else ":main")
    return OF_ARMS[arm.kind] + ("" if arm.name in ASKED_AGAIN else ":executed" if arm.name in EXECUTED else ":tours")


def owners(*names: str) -> set[str]:
    """Those of the stages that lead to the tables that own one of `names`, or one of whose arms reads it."""
    arms = {made(entry) for entry in CONFIG.arms.values() if matching(own_constants(entry), names)}
    memory = CONFIG.comparisons.memory
    arms |= {"readmitted_predictions" for _, arm in memory if matching(own_constants(CONFIG.arms[arm]), names)}
    arms |= {"probes" for arm in (memory.arm,) if matching(own_constants(CONFIG.arms[arm]), names)}
    found = arms | {stage for stage in STAGES if stage in FOLLOWS | AS and owned(stage, names)}
    return (found | {AS[stage] for stage in found & AS.keys()}) & FOLLOWS.keys()


def and_what_follows(stages: set[str]) -> set[str]:
    reached = set(stages)
    while True:
        more = {after for stage in reached for after in FOLLOWS[stage]} | reached
        if more == reached:
            return {stage.partition(":")[0] for stage in reached}
        reached = more


def planned_for(stages: set[str]) -> set[str]:
    """Name the rules that a dry run plans when `stages` rerun: up to the first checkpoint, and the tables that wait for it."""
    found = and_what_follows(stages)
    for checkpoint in CHECKPOINTS:
        if checkpoint in found:
            return {stage for stage in found if checkpoint in and_what_follows({stage})} | {"tables", "all_tables"}
    return found


def kinds() -> list[list[str]]:
    """Constants that rerun the same stages, together; without those that say which files there are or count others."""
    found: dict[frozenset[str], list[str]] = {}
    for name in VALUES:
        if name not in ("evaluation.seeds", "evaluation.scenes_per_job", "sensitivity.combinations"):
            found.setdefault(frozenset(and_what_follows(owners(name))), []).append(name)
    return list(found.values())


def test_finished_is_finished(world):
    assert world.planned() == {}


TRIED = [names[0] for names in kinds()[::5]]
"""A dry run is slow, and a stage's parameter is compared for every constant elsewhere."""


@pytest.mark.parametrize(
    "name",
    TRIED + [pytest.param(name, marks=pytest.mark.soak) for names in kinds() for name in names if name not in TRIED],
)
def test_a_constant_reruns_its_owners_and_what_follows(world, name):
    # The Unity build is looked for before anything: a job that the embedded engine needs not.
    assert set(world.planned(overlay({name: other(name)}))) - {"simulator"} == planned_for(owners(name))


def test_constants_that_swap_their_values_rerun_their_owners(world):
    swapped = {
        "association.gate_m": VALUES["association.feature_scale_m"],
        "association.feature_scale_m": VALUES["association.gate_m"],
    }
    assert set(world.planned(overlay(swapped))) == and_what_follows(owners(*swapped))


def test_number_form_key_order_and_the_users_own_sections_rerun_nothing(world):
    numbers = {"tour.headings": 4.0, "association.feature_scale_m": 2, "success.sweep_deg": [0.0, 30, 60]}
    turned = {section: dict(reversed(TREE[section].items())) for section in reversed(TREE)}
    assert world.planned(merged(turned, overlay(numbers)) | {"x-notes": {"mine": 1}}) == {}


def test_a_further_seed_reruns_the_rollouts_and_what_follows(world):
    assert set(world.planned({"evaluation": {"seeds": [0, 1]}})) == and_what_follows({"rollouts"})


def test_a_further_scene_runs_its_own_stages_once_and_what_gathers_all(world):
    planned = world.planned({"splits": {"main": {"scenes": ["FloorPlan227", "FloorPlan230"]}}})
    assert planned == dict.fromkeys(planned_for({"scenes"}), 1)


def test_the_rules_that_lead_to_the_tables_are_the_stages_in_their_order(world):
    said = world.snakemake("--rulegraph")
    assert said.returncode == 0
    names = dict(re.findall(r'(\d+)\[label ?= ?"(\w+)"', said.stdout))
    arrows = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", said.stdout)}
    stage = {name: name.partition(":")[0] for name in FOLLOWS}
    assert arrows == {(stage[before], stage[after]) for before, all_after in FOLLOWS.items() for after in all_after}
    assert set(names.values()) == set(stage.values()) < {*STAGES, *AS.values()}

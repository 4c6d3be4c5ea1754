"""A change reruns the rules that depend on it and those that follow, and nothing else."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from ovman.settings.config import load_files
from tests.workflow.conftest import ROOT, TINY, World

SETTINGS = load_files([ROOT / "config.yaml", TINY])


def test_what_is_finished_stays_finished(world: World) -> None:
    assert world.planned() == {}


@pytest.mark.parametrize(
    ("overlay", "first", "untouched"),
    [
        ({"association": {"gate_m": 0.9}}, {"predictions"}, {"maps", "detections", "trials"}),
        ({"maps": {"cluster_radius_m": 0.3}}, {"maps", "maintained", "readmitted_maps"}, {"detections", "segments"}),
        ({"candidates": {"delta_min_m": 1.6}}, {"candidates", "admissible"}, {"scenes"}),
        ({"splits": {"multi": {"arms": ["two_visits"]}}}, {"metrics"}, {"candidates", "trials", "predictions"}),
        ({"arms": {"two_visits": {"system": "Another title"}}}, {"tables", "metrics"}, {"predictions", "rollouts"}),
    ],
    ids=["gate", "maps", "displacement", "arms of a split", "title"],
)
def test_a_changed_constant_reruns_what_depends_on_it(
    world: World, overlay: dict[str, Any], first: set[str], untouched: set[str]
) -> None:
    planned = world.planned(overlay)
    assert planned.keys() >= first
    assert not planned.keys() & untouched


def test_constants_that_swap_their_values_rerun_their_rule(world: World) -> None:
    camera = SETTINGS.primitives
    swapped = {"primitives": {"blocked_edge_expiry": camera.stall_after, "stall_after": camera.blocked_edge_expiry}}
    assert "certified" in world.planned(swapped)


def test_a_further_seed_reruns_the_rollouts(world: World) -> None:
    planned = world.planned({"evaluation": {"seeds": [0, 1]}})
    assert "rollouts" in planned and "predictions" not in planned


def test_form_of_numbers_and_sections_of_the_user_rerun_nothing(world: World) -> None:
    assert world.planned({"tour": {"waypoints": 2.0}, "x-mine": {"a": 1}}) == {}


def test_equal_episodes_rerun_nothing_that_follows_them(world: World, tmp_path: Path) -> None:
    again, overlay = world.copy(tmp_path / "again"), {"admissibility": {"drift_tolerance_m": 0.24}}
    tours = {path: path.stat().st_mtime_ns for path in (again.directory / "results" / "visits").rglob("*")}
    said = again.snakemake(overlay=overlay)
    assert said.returncode == 0, said.stdout
    assert {path: path.stat().st_mtime_ns for path in tours} == tours
    assert "rule predictions" not in said.stdout and "rule rollouts" not in said.stdout
    before, after = world.results(), again.results()
    changed = {name for name in before if before[name] != after.get(name)}
    assert {name.split("/")[0] for name in changed} <= {"tables", "readmitted", "metrics"}
    assert any(name.startswith("tables/constants") for name in changed)
    assert again.planned(overlay) == {}


def test_restored_results_rerun_only_what_a_changed_threshold_judges(world: World, tmp_path: Path) -> None:
    restored = World(tmp_path / "restored")
    left_out = shutil.ignore_patterns("visits", "cache", ".snakemake*")
    shutil.copytree(world.directory / "results", restored.directory / "results", ignore=left_out)
    said = restored.snakemake("--touch", "--forceall")
    assert said.returncode == 0, said.stdout
    assert restored.planned() == {}
    planned = restored.planned({"admissibility": {"drift_tolerance_m": 0.15}})
    assert planned == dict.fromkeys(("admissible", "certified", "episodes"), 3) | dict.fromkeys(("tables", "all_tables"), 1)


def test_the_profile_of_a_cluster_plans_what_follows_the_episodes(world: World) -> None:
    profile = str(ROOT / "profiles" / "slurm")
    said = world.snakemake("--dry-run", "--profile", profile, overlay={"association": {"gate_m": 0.9}})
    assert said.returncode == 0 and "predictions" in said.stdout, said.stdout

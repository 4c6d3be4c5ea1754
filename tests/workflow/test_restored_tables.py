"""From what was restored come the tables of the whole world under changed thresholds, and no simulator is started."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.workflow.conftest import World
from tests.workflow.releases import FROM_MAPS, Released, restored

JUDGED = {"admissibility": {"drift_tolerance_m": 0.26}, "evaluation": {"near_miss_m": 1.6}}
"""Thresholds that change no episode of the tiny world."""
DRIVING = {"scenes", "trials", "rollouts", "walks", "ablated_tours"}
"""Rules that start a simulator, but for `certified`, which starts none where its journal has every run."""


def tables(results: Mapping[str, bytes]) -> dict[str, bytes]:
    return {
        name: content
        for name, content in results.items()
        if name.startswith(("results/tables/", "results/all/", "results/metrics/"))
    }


def from_measured(of: Released, directory: Path) -> World:
    """Restore without what networks saw, and make the tables under `JUDGED` by the user's one command."""
    again = restored(of, directory, perceived=False)
    before = again.units()
    said = again.snakemake(overlay=JUDGED)
    assert said.returncode == 0, said.stdout
    ran = {*re.findall(r"^(?:local)?(?:rule|checkpoint) (\w+):", said.stdout, re.MULTILINE)}
    assert {"admissible", "sensitivity", "metrics", "tables"} <= ran and not ran & DRIVING
    # What a simulator does is kept in a journal, and there is nothing new in any.
    assert again.units() == before and before
    assert not (directory / "results" / "visits").exists()
    return again


def test_a_changed_threshold_gives_other_tables_without_a_simulator(world, released, tmp_path):
    again, before = tables(from_measured(released, tmp_path / "again").results()), tables(world.results())
    assert again.keys() == before.keys() and again != before


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_a_changed_threshold_gives_the_tables_of_a_run_from_scratch(released, tmp_path):
    again = from_measured(released, tmp_path / "again")
    (tmp_path / "scratch").mkdir()
    scratch = World(tmp_path / "scratch")
    assert scratch.snakemake(overlay=JUDGED).returncode == 0
    assert tables(again.results()) == tables(scratch.results())


@pytest.mark.soak
def test_an_agents_threshold_gives_the_static_tables_from_maps_alone(world, released, tmp_path):
    overlay = FROM_MAPS | {"association": {"gate_m": 0.6}}
    target = "results/static_tables"
    again = restored(released, tmp_path / "again")
    assert {*again.planned(overlay, target)} == {"predictions", "static_tables"}
    whole = World(shutil.copytree(world.directory, tmp_path / "whole"))
    for one in (again, whole):
        assert one.snakemake(overlay=overlay, target=target).returncode == 0
    files = [{p.name: p.read_bytes() for p in (one.directory / target).iterdir() if p.suffix} for one in (again, whole)]
    assert files[0] == files[1] and files[0]

"""A threshold that only judges is changed without a simulator where no episode changes."""

from __future__ import annotations

import shutil

import pytest

from tests.workflow.conftest import World


@pytest.mark.parametrize(
    "overlay",
    [
        {"admissibility": {"drift_tolerance_m": 0.26}},
        {"success": {"radius_m": 1.01}},
    ],
    ids=["drift tolerance", "success radius"],
)
def test_new_tables_without_a_simulator(world, tmp_path, overlay):
    again = World(shutil.copytree(world.directory, tmp_path / "world"))
    said = again.snakemake(overlay=overlay)
    assert said.returncode == 0, said.stdout
    # What a simulator does is kept in a journal, and there is nothing new in any.
    assert again.units() == world.units()
    before, after = world.results(), again.results()
    assert before["results/episodes/main.jsonl"] == after["results/episodes/main.jsonl"]
    assert before["results/tables/constants.csv"] != after["results/tables/constants.csv"]

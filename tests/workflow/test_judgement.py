"""A threshold that only judges is changed without a simulator where no episode changes."""

from __future__ import annotations

import shutil

from tests.workflow.conftest import World

# Both at once: a journal's unit that knew of either would be a new one.
JUDGING = {"admissibility": {"drift_tolerance_m": 0.26}, "success": {"radius_m": 1.01}}


def test_new_tables_without_a_simulator(world, tmp_path):
    again = World(shutil.copytree(world.directory, tmp_path / "world"))
    said = again.snakemake(overlay=JUDGING)
    assert said.returncode == 0, said.stdout
    # What a simulator does is kept in a journal, and there is nothing new in any.
    assert again.units() == world.units()
    before, after = world.results(), again.results()
    assert before["results/episodes/main.jsonl"] == after["results/episodes/main.jsonl"]
    shown = "results/tables/constants.csv"
    changed = set(after[shown].splitlines()) - set(before[shown].splitlines())
    assert len(changed) == 2, changed

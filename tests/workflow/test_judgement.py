"""A threshold that only judges is changed without a simulator where no episode changes."""

from __future__ import annotations

import json
import shutil

import pytest

from ovman.models.episode import Episode
from tests.workflow.conftest import World


def unjudged(results: dict[str, bytes]) -> list[dict]:
    """The episodes without the constants that judge them."""
    records = [json.loads(line) for line in results["results/episodes/main.jsonl"].decode().splitlines()]
    for record in records:
        del record["protocol"]["success"]["radius_m"], record["provenance"]["trial"]
    return records


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
    judged_by = overlay.get("success", {})
    for file in (before, after):
        episodes = [Episode.parse(line) for line in file["results/episodes/main.jsonl"].decode().splitlines()]
        assert episodes and all(
            getattr(episode.protocol.success, name) == value for name, value in judged_by.items() for episode in episodes
        ) == (file is after or not judged_by)
    # An episode differs in the constants that judge it alone; a rollout in nothing.
    assert unjudged(before) == unjudged(after)
    rollouts = [name for name in before if name.startswith("results/rollouts/")]
    assert rollouts and all(before[name] == after[name] for name in rollouts)
    assert before["results/tables/constants.csv"] != after["results/tables/constants.csv"]

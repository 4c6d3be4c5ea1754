"""A threshold that only judges is changed without a simulator where no episode changes."""

from __future__ import annotations

import json
import shutil

from ovman.records.episode import Episode
from tests.workflow.conftest import World
from tests.workflow.test_reruns import CONFIG


def unjudged(results: dict[str, bytes]) -> list[dict]:
    """The episodes without the constants that judge them."""
    records = [json.loads(line) for line in results["results/episodes/main.jsonl"].decode().splitlines()]
    for record in records:
        del record["protocol"]["success"]["radius_m"], record["provenance"]["trial"]
    return records


def test_new_tables_without_a_simulator(world, tmp_path):
    again = World(shutil.copytree(world.directory, tmp_path / "world"))
    overlay = {"admissibility": {"drift_tolerance_m": 0.26}, "success": {"radius_m": 1.01}}
    before = world.results()
    simulated = [name for name in before if name.startswith(("results/rollouts/", "results/walks/"))]
    said = again.snakemake(overlay=overlay, target=simulated)
    assert said.returncode == 0, said.stdout
    # What a simulator does is kept in a journal, and there is nothing new in any. What remains starts no simulator.
    assert again.units() == world.units()
    planned = again.planned(overlay, target="results/metrics/controls.csv")
    assert {"scores", "predictions", "metrics", "controls"} <= planned.keys()
    assert not planned.keys() & {path.name for path in (again.directory / "results" / "journal").iterdir()}
    after = again.results()
    for file, radius_m in ((before, CONFIG.success.radius_m), (after, 1.01)):
        episodes = [Episode.parse(line) for line in file["results/episodes/main.jsonl"].decode().splitlines()]
        assert episodes and {episode.protocol.success.radius_m for episode in episodes} == {radius_m}
    # An episode differs in the constants that judge it alone; what a simulator shows, in nothing.
    assert unjudged(before) == unjudged(after)
    assert simulated and all(before[name] == after[name] for name in simulated)

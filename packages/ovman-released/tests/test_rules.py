"""Rules of released systems: there for those whose overlay is given, and on the GPU where their networks are."""

from __future__ import annotations

import re
from typing import Any

import pytest
import yaml
from settings_of import PACKAGE, merged

from tests.workflow.conftest import World


def planned(world: World, *systems: str) -> dict[str, list[tuple[str, str]]]:
    """The rules of a dry run with the overlays of these systems: text and resources of each job."""
    overlay: dict[str, Any] = {}
    for system in systems:
        overlay = merged(overlay, yaml.safe_load((PACKAGE / f"{system}.yaml").read_text()))
    # The tables wait for the episodes, so that a dry run in an empty folder plans nothing that only they need.
    predictions = [f"results/predictions/main/{name}.jsonl" for name, arm in overlay["arms"].items() if arm["kind"] == "static"]
    said = world.snakemake("--dry-run", overlay=overlay, target=["results/notes/released_cow.json", *predictions])
    assert said.returncode == 0, said.stdout
    found: dict[str, list[tuple[str, str]]] = {}
    for name, text, resources in re.findall(r"^rule (\w+):(.*?)^    resources: (.*?)$", said.stdout, re.MULTILINE | re.DOTALL):
        found.setdefault(name, []).append((text, resources))
    return found


@pytest.mark.soak
def test_both_systems_have_their_jobs_and_cow_has_a_gpu(tmp_path):
    """CoW has one job for all episodes and seeds, DualMap one for its parts, for each scene and for each arm."""
    rules = planned(World(tmp_path), "cow", "dualmap")
    counts = {name: len(jobs) for name, jobs in rules.items() if name.startswith("released")}
    expected = {"released_cow": 1, "released_dualmap_setup": 1, "released_dualmap": 1, "released_dualmap_predictions": 4}
    assert counts == expected
    assert re.search(r"\bgpu=1$", rules["released_cow"][0][1])
    assert not any("released" in text for name in ("rollouts", "predictions") for text, _ in rules.get(name, []))

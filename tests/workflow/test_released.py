"""Rules of released systems: there for those of which a clone is named, and on the GPU where their networks are."""

from __future__ import annotations

import re

from tests.workflow.conftest import World


def test_a_clone_that_is_named_is_run_once_for_all_episodes_and_seeds(tmp_path):
    overlay = {"released": {"cow": {"root": "nowhere"}}}
    said = World(tmp_path).snakemake("--dry-run", overlay=overlay)
    assert said.returncode == 0, said.stdout
    rules = re.findall(r"^rule (\w+):(.*?)^    resources: (.*?)$", said.stdout, re.MULTILINE | re.DOTALL)
    released = {name: (text, resources) for name, text, resources in rules if name.startswith("released")}
    assert set(released) == {"released_cow"} and len([name for name, *_ in rules if name == "released_cow"]) == 1
    assert re.search(r"\bgpu=1$", released["released_cow"][1])
    (tables,) = (text for name, text, _ in rules if name == "tables")
    assert "results/released/cow.json" in tables and "results/released/dualmap.json" not in tables

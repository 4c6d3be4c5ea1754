"""The page about agents: its own example as an arm, and what an arm that is added, changed or wrong does to the workflow."""

from __future__ import annotations

import csv
import re
import shutil

import pytest
import yaml

from tests.workflow.conftest import ROOT, World

PAGE = (ROOT / "docs" / "agents.md").read_text()
(CODE, ENTRY, STATIC) = (re.search(rf"```{kind}\n(.*?)```", PAGE[at:], re.DOTALL)[1] for kind, at in (
    ("python", 0), ("yaml", 0), ("python", PAGE.index("## A static arm"))
))  # fmt: skip
EXAMPLE = yaml.safe_load(ENTRY)
SEEN = {"arms": EXAMPLE["arms"] | {"latest": {"kind": "static", "system": "latest", "memory": "second visit",
                                              "agent": "latest:latest", "needs": ["maps"]}}}  # fmt: skip
TABULATING = ("metrics", "controls", "paper_controls", "tables", "all_tables")


def beside(world: World) -> None:
    """The files of the page's agents, beside the overlay."""
    (world.directory / "frame_difference.py").write_text(CODE)
    (world.directory / "latest.py").write_text(STATIC)


def test_the_agents_of_the_page_are_arms_whose_jobs_alone_run(world, tmp_path):
    again = World(shutil.copytree(world.directory, tmp_path / "world"))
    beside(again)
    planned = again.planned(SEEN)
    assert planned == dict.fromkeys(("predictions", "rollouts", "scores", *TABULATING), 1)
    said = again.snakemake(overlay=SEEN)
    assert said.returncode == 0, said.stdout
    before, after = world.results(), again.results()
    others = [name for name in before if not name.startswith(("results/metrics/", "results/tables/"))]
    assert {name: after[name] for name in others} == {name: before[name] for name in others}
    with (again.directory / "results" / "tables" / "embodied.csv").open() as file:
        rows = {row["agent"]: row for row in csv.DictReader(file)}
    # It sees what was put there and what is gone, on the tiny world's clear views.
    assert float(rows["frame difference"]["sr"]) >= 0.5
    # Controls stand below all systems, also those of a user.
    assert list(rows)[-3:] == ["frame difference", "depth difference", "pixel difference"]
    assert "latest" in (again.directory / "results" / "tables" / "static.csv").read_text()
    assert again.planned(SEEN) == {}

    (again.directory / "frame_difference.py").write_text("# Another comment.\n" + CODE)
    assert again.planned(SEEN) == {}
    (again.directory / "frame_difference.py").write_text(CODE.replace("CHANGED_M = 0.2", "CHANGED_M = 0.25"))
    assert again.planned(SEEN) == dict.fromkeys(("rollouts", "scores", *TABULATING), 1)


@pytest.mark.parametrize(
    ("agent", "line"),
    [
        ("nowhere.mine:agent", "and there is no module nowhere.mine; install it, or put it beside the overlay"),
        ("frame_difference:Depth", "and frame_difference has no function Depth; name one that it has"),
        ("broken:agent", "and broken.py, line 1, is not Python: "),
    ],
)
def test_an_agent_that_is_not_there_stops_the_workflow_with_one_line(tmp_path, agent, line):
    world = World(tmp_path)
    beside(world)
    (tmp_path / "broken.py").write_text("def agent(:\n")
    arms = {"frame_difference": EXAMPLE["arms"]["frame_difference"] | {"agent": agent}}
    said = world.snakemake(overlay={"arms": arms})
    assert said.returncode != 0
    lines = [text for text in said.stdout.splitlines() if not text.startswith(("Using workflow specific profile", "Config file"))]
    assert len(lines) == 1 and lines[0].startswith(f"overlay.yaml: arms.frame_difference.agent is '{agent}', {line}")
    assert not (tmp_path / "results").exists()

"""The notebook of the tutorial runs, and its agent is judged."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from ovman.entry.manifest import read_runs, runs_path

NOTEBOOK = Path(__file__).parents[1] / "docs" / "tutorial.ipynb"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder that the notebook ran in."""
    folder = tmp_path_factory.mktemp("tutorial")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    for cell in notebook.cells:
        cell.source = cell.source.replace("!ovman ", f"!{sys.executable} -m ovman.cli ")
    client = NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(folder)}})
    client.execute(env=os.environ | {"XDG_CACHE_HOME": str(folder / "cache")})
    return folder


def test_its_agent_runs_on_every_question_of_its_home(folder):
    runs = [run for _, run in read_runs(runs_path(folder / "mine"))]
    episodes = (folder / "home" / "episodes.jsonl").read_text().splitlines()
    assert len(runs) == 3 * len(episodes) and any(run.actions for run in runs)


def test_it_ends_with_an_entry(folder):
    (entry,) = (folder / "leaderboard").glob("my-agent/*/manifest.json")
    assert entry.is_file()


def test_it_is_small():
    assert NOTEBOOK.stat().st_size < 100_000

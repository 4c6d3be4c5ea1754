"""What is wrong stops the workflow with one line, before anything is touched."""

from __future__ import annotations

import ctypes.util
import os
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.sim import unity_build
from tests.workflow.conftest import ROOT, World

FROM_SNAKEMAKE = ("Using workflow specific profile", "Config file", "Using profile")
"""Beginnings of the lines that Snakemake prints before it reads a Snakefile."""
ARM = {"kind": "embodied", "system": "mine", "memory": "none", "agent": "mine:agent"}


def lines(output: str) -> list[str]:
    return [text for text in output.splitlines() if not text.startswith(FROM_SNAKEMAKE)]


@pytest.mark.parametrize(
    ("overlay", "line"),
    [
        ({"association": {"gama_m": 1.0}}, "overlay.yaml: association.gama_m is not a setting; did you mean gate_m?"),
        ({"arms": {"mine": ARM}}, "overlay.yaml: arms.mine.agent is 'mine:agent': there is no module mine"),
        (
            {"arms": {"mine": ARM | {"agent": "broken:agent"}}},
            "overlay.yaml: arms.mine.agent is 'broken:agent': broken.py, line 1",
        ),
    ],
    ids=["unknown setting", "no module", "not Python"],
)
def test_a_wrong_setting_is_one_line(tmp_path: Path, overlay: dict[str, Any], line: str) -> None:
    (tmp_path / "broken.py").write_text("def agent(:\n")
    said = World(tmp_path).snakemake(overlay=overlay)
    assert said.returncode != 0
    assert len(lines(said.stdout)) == 1 and lines(said.stdout)[0].startswith(line)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"tour:\n\twaypoints: 3\n", ":2:1: found character that cannot start any token; indent with spaces"),
        (None, ": No such file or directory; give the path of a file of settings (.yaml)"),
    ],
    ids=["tab", "missing"],
)
def test_an_overlay_that_snakemake_cannot_read_is_one_line(tmp_path: Path, content: bytes | None, line: str) -> None:
    overlay = tmp_path / "mine.yaml"
    if content is not None:
        overlay.write_bytes(content)
    said = World(tmp_path).snakemake("--configfile", str(ROOT / "overlays" / "tiny.yaml"), str(overlay))
    assert said.returncode != 0 and lines(said.stdout) == [f"{overlay}{line}"]


AGENT = """
import os
import signal
import sys


def agent(context):
    return Agent()


class Agent:
    def familiarise(self, visit):
        pass

    def revisit(self, visit):
        pass

    def ask(self, query):
        {end}

    def act(self, observation):
        raise NotImplementedError
"""


@pytest.mark.parametrize(
    ("end", "line"),
    [
        ("sys.exit(0)", "arms.mine.agent is 'mine:agent': FloorPlan227/"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "logs/rollouts/main/mine.log"),
    ],
    ids=["exception", "killed"],
)
def test_an_agent_that_fails_is_named_and_leaves_no_output(world: World, tmp_path: Path, end: str, line: str) -> None:
    again = world.copy(tmp_path / "world")
    (again.directory / "mine.py").write_text(AGENT.format(end=end))
    target = "results/rollouts/main/mine.jsonl"
    said = again.snakemake("--latency-wait", "0", overlay={"arms": {"mine": ARM}}, target=target)
    assert said.returncode != 0 and not (again.directory / target).exists()
    assert line in said.stdout
    log = (again.directory / "logs" / "rollouts" / "main" / "mine.log").read_text()
    assert "FloorPlan227/" in log


def test_a_machine_without_vulkan_is_told_once_in_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unity_build.library(tmp_path / "programs", present=False)
    monkeypatch.setenv("PATH", f"{tmp_path / 'programs'}:{os.environ['PATH']}")
    if ctypes.util.find_library("vulkan") is not None:
        pytest.skip("this machine has Vulkan")
    world = World(tmp_path)
    said = world.snakemake(overlay={"benchmark": {"backend": "thor"}}, target="results/scenes/main.jsonl")
    assert said.returncode != 0 and "Traceback" not in said.stdout
    line = "benchmark.backend is thor, but Vulkan's library is not installed; sudo apt install libvulkan1"
    assert said.stdout.count(line) == 1
    assert not (tmp_path / "results" / "scenes").exists() and not (tmp_path / "results" / "simulator.txt").exists()


def test_jobs_with_a_gpu_run_one_at_a_time(world: World) -> None:
    thor = yaml.safe_load((ROOT / "overlays" / "thor.yaml").read_text())
    said = world.snakemake("--dry-run", "--forcerun", "scenes", "trials", "certified", overlay=thor)
    assert said.returncode == 0, said.stdout
    jobs = said.stdout.split("\nrule ")[1:]
    for rule in ("scenes", "trials", "certified"):
        of_rule = [job for job in jobs if job.startswith(f"{rule}:")]
        assert of_rule and all("gpu=1" in job for job in of_rule), rule
    profile = (ROOT / "profiles" / "default" / "config.yaml").read_text()
    assert 'resources: ["gpu=1"]' in profile

"""A wrong setting stops the workflow with one line, before anything is touched."""

from __future__ import annotations

import shutil

import pytest

from tests.workflow.conftest import ROOT, World

SNAKEMAKES = ("Using workflow specific profile", "Config file")
"""How the lines begin that Snakemake prints before it reads a Snakefile."""


@pytest.mark.parametrize(
    ("overlay", "line"),
    [
        ({"association": {"gama_m": 1.0}}, "overlay.yaml: association.gama_m is not a setting; did you mean gate_m?"),
        ({"tour": {"waypoints": "six"}}, 'overlay.yaml: tour.waypoints is "six"; it must be a valid integer (W, farthest-point'),
    ],
)
def test_a_wrong_setting_is_one_line(tmp_path, overlay, line):
    said = World(tmp_path).snakemake(overlay=overlay)
    assert said.returncode != 0
    lines = [text for text in said.stdout.splitlines() if not text.startswith(SNAKEMAKES)]
    assert len(lines) == 1 and lines[0].startswith(line)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"tour: {waypoints: 3} # caf\xe9\n", ":1:27: is not UTF-8 text (byte 0xe9); save it as UTF-8"),
        (b"tour:\n\twaypoints: 3\n", r":2:1: found character '\t' that cannot start any token; indent with spaces"),
        (b"tour: {waypoints: 3", ":1:20: expected ',' or '}', but got '<stream end>'; mend the YAML there"),
        (b"", ": is empty; it must hold sections (benchmark:, camera:, ...), or be left out"),
        (None, ": No such file or directory; give the path of a file of settings (.yaml)"),
    ],
    ids=["Latin-1", "tab", "syntax", "empty", "missing"],
)
def test_an_overlay_that_snakemake_cannot_read_is_one_line(tmp_path, content, line):
    overlay = tmp_path / "mine.yaml"
    if content is not None:
        overlay.write_bytes(content)
    said = World(tmp_path).snakemake("--configfile", str(ROOT / "overlays" / "tiny.yaml"), str(overlay))
    assert said.returncode != 0
    assert [text for text in said.stdout.splitlines() if not text.startswith(SNAKEMAKES)] == [f"{overlay}{line}"]
    assert not (tmp_path / "results").exists()


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
ARM = {"kind": "embodied", "system": "mine", "memory": "none", "agent": "mine:agent"}
WHERE = "arms.mine.agent is 'mine:agent': FloorPlan227/"


def run_agent(world: World, directory, end: str) -> str:
    """What Snakemake and the job say where an agent does `end` when it is asked."""
    again = World(shutil.copytree(world.directory, directory / "world"))
    (again.directory / "mine.py").write_text(AGENT.format(end=end))
    target = "results/rollouts/mine/seed0/FloorPlan227.jsonl"
    said = again.snakemake("--latency-wait", "0", overlay={"arms": {"mine": ARM}}, target=target)
    assert said.returncode != 0 and not (again.directory / target).exists()
    assert not list((again.directory / ".snakemake" / "ovman.at_work").iterdir())
    return said.stdout


@pytest.mark.parametrize("end", ["os._exit(0)", "os.kill(os.getpid(), signal.SIGKILL)"])
def test_a_job_whose_process_ends_names_arm_and_episode_in_one_line(world, tmp_path, end):
    said = run_agent(world, tmp_path, end)
    (line,) = [text for text in said.splitlines() if WHERE in text]
    assert line.startswith(f"rule rollouts: the process ended during {WHERE}")
    cause = "(killed, out of memory, or ended by the agent)"
    assert line.endswith(f", seed 0: ask {cause}; logs/rollouts/mine/FloorPlan227.log has what it printed")


def test_an_agent_that_fails_is_run_once_and_said_once(world, tmp_path):
    said = run_agent(world, tmp_path, "sys.exit(0)")
    (line,) = [text for text in said.splitlines() if WHERE in text]
    assert line.startswith(WHERE) and line.endswith(", seed 0: ask raised SystemExit in mine.py, line 19: 0; mend the agent")
    assert said.count("Error in rule rollouts") == 1

"""Jobs with a GPU run one at a time, whatever the user gives as resources."""

from __future__ import annotations

import ctypes.util
import json
import os
import re
from collections.abc import Mapping
from typing import Any

import pytest
import yaml

from ovman.workflow.provenance import modules, script
from ovman.workflow.stages import STAGES
from tests.sim import unity_build
from tests.workflow import forked
from tests.workflow.conftest import ROOT, World

SNAKEFILE = """
import sys

sys.path.insert(0, {root!r})
from ovman.workflow.snakemake_internals import limit_gpu

limit_gpu(workflow)


rule all:
    input:
        expand("{{n}}.done", n=range(4)),


rule work:
    output:
        "{{n}}.done",
    resources:
        gpu=1,
    shell:
        "echo in >> turns; sleep 0.2; echo out >> turns; touch {{output}}"
"""


@pytest.mark.parametrize("given", [(), ("--resources", "gpu=2")], ids=["nothing", "two"])
def test_one_job_at_a_time(tmp_path, given):
    (tmp_path / "Snakefile").write_text(SNAKEFILE.format(root=str(ROOT)))
    said = forked.snakemake(["--cores", "4", *given, "--", "all"], tmp_path, os.environ)
    assert said.returncode == 0, said.stdout
    assert (tmp_path / "turns").read_text().split() == ["in", "out"] * 4


SIMULATOR = {"simulator", "scenes", "trials", "certified", "rollouts", "walks"}
NETWORK = {"detections", "nouns", "readmitted_maps", "walks", "rollouts"}
"""Of the rollouts, those of arms with networks of their own."""
BEFORE_EPISODES = ("scenes", "trials", "certified")
AFTER_EPISODES = ("detections", "nouns", "readmitted_maps", "walks", "rollouts")
"""A dry run plans nothing after a checkpoint that reruns, so that both are asked for apart."""


@pytest.mark.parametrize(
    ("overlay", "hungry"),
    [
        (yaml.safe_load((ROOT / "overlays" / "thor.yaml").read_text()), SIMULATOR | NETWORK),
        ({"perception": {"device": "cuda"}}, NETWORK),
    ],
    ids=["the paper's set-up", "networks on a GPU"],
)
def test_the_stages_that_need_a_gpu_ask_for_it(world, overlay, hungry):
    asked = planned(world, overlay)
    assert {stage for stage, numbers in asked.items() if "1" in numbers} == hungry
    assert {stage for stage, numbers in asked.items() if numbers & {"0", "1"}} >= (SIMULATOR | NETWORK) - {"simulator"}
    assert asked.keys() >= {"candidates", "tables"} and ("simulator" in asked) is (hungry >= SIMULATOR)


def planned(world: World, overlay: Mapping[str, Any]) -> dict[str, set[str]]:
    """How many GPUs the jobs of each rule ask for; nothing where they do not say."""
    asked: dict[str, set[str]] = {}
    for rules in (BEFORE_EPISODES, AFTER_EPISODES):
        said = world.snakemake("--dry-run", "--rerun-triggers", "mtime", "--forcerun", *rules, overlay=overlay)
        assert said.returncode == 0, said.stdout
        for rule, number in re.findall(
            r"^rule (\w+):.*?^    resources: .*?(?:gpu=(\d))?$", said.stdout, re.MULTILINE | re.DOTALL
        ):
            asked.setdefault(rule, set()).add(number)
    return asked


def test_whatever_starts_the_simulator_or_loads_the_networks_asks_for_a_gpu():
    """By what the scripts import and the stages own, so that a new stage is not forgotten."""
    rules = "\n".join(path.read_text() for path in sorted((ROOT / "workflow" / "rules").glob("*.smk")))
    bodies = dict(re.findall(r"^rule (\w+):\n(.*?)(?=^\S|\Z)", rules, re.MULTILINE | re.DOTALL))
    scripts = {name: re.search(r"scripts/(\w+)\.py", body)[1] for name, body in bodies.items() if "scripts/" in body}
    for name, stage in scripts.items():
        imports, owned = modules(script(stage)).keys(), STAGES[stage]
        simulates = "ovman.sim.controller" in imports and "benchmark.backend" in owned
        looks = "ovman.perception.networks" in imports and {"perception.device", "perception.*"} & set(owned)
        wanted = {word for word, wants in (("GPU", simulates), ("NETWORK_GPU", looks)) if wants}
        asks = re.search(r"gpu=(.*?),\n", bodies[name])
        assert wanted <= set(re.findall(r"\b(?:NETWORK_)?GPU\b", asks[1] if asks else "")), name


def test_a_machine_without_vulkan_is_told_once_in_a_line(tmp_path, monkeypatch):
    unity_build.library(tmp_path / "programs", present=False)
    monkeypatch.setenv("PATH", f"{tmp_path / 'programs'}:{os.environ['PATH']}")
    if ctypes.util.find_library("vulkan") is not None:
        pytest.skip("this machine has Vulkan")
    world = World(tmp_path)
    said = world.snakemake(overlay={"benchmark": {"backend": "thor"}}, target="results/scenes/FloorPlan227.json")
    assert said.returncode != 0 and "Traceback" not in said.stdout
    line = "benchmark.backend is thor, but Vulkan's library is not installed; sudo apt install libvulkan1"
    assert said.stdout.count(line) == 1 and "Traceback" not in (tmp_path / "logs" / "simulator.log").read_text()
    assert not (tmp_path / "results" / "scenes").exists() and not (tmp_path / "results" / "simulator.txt").exists()


@pytest.mark.soak
def test_a_scene_is_surveyed_on_the_unity_build(tmp_path, monkeypatch):
    """The engine plays it; what it is asked goes all the way through Snakemake, the check and the client."""
    unity_build.machine(monkeypatch, tmp_path / "machine")
    world = World(tmp_path)
    said = world.snakemake(overlay={"benchmark": {"backend": "thor"}}, target="results/scenes/FloorPlan227.json")
    assert said.returncode == 0, said.stdout
    assert (tmp_path / "results" / "simulator.txt").read_text().count("ok ") == 3
    assert json.loads((tmp_path / "results" / "scenes" / "FloorPlan227.json").read_text())["objects"]

"""Jobs with a GPU run one at a time, whatever the user gives as resources."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.workflow.conftest import ROOT, World

SNAKEFILE = """
import sys

sys.path.insert(0, {root!r})
from ovman.workflow import limit_gpu

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


@pytest.mark.parametrize("given", [(), ("--resources", "gpu=2"), ("--resources", "mem_mb=1000")], ids=["nothing", "two", "other"])
def test_one_job_at_a_time(tmp_path, given):
    (tmp_path / "Snakefile").write_text(SNAKEFILE.format(root=str(ROOT)))
    said = subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "4", *given, "--", "all"], cwd=tmp_path, capture_output=True, text=True
    )
    assert said.returncode == 0, said.stderr
    assert (tmp_path / "turns").read_text().split() == ["in", "out"] * 4


SIMULATOR, NETWORK = {"scenes", "trials", "certified", "executions"}, {"detections", "nouns"}


@pytest.mark.parametrize(
    ("overlay", "hungry"),
    [
        ({}, set()),
        ({"benchmark": {"backend": "thor"}}, SIMULATOR),
        ({"perception": {"device": "cuda"}}, NETWORK),
    ],
    ids=["neither", "the Unity build", "networks on a GPU"],
)
def test_the_stages_that_need_a_gpu_ask_for_it(tmp_path, overlay, hungry):
    said = World(tmp_path).snakemake("--dry-run", overlay=overlay)
    asked = dict(re.findall(r"^rule (\w+):.*?^    resources: .*?(?:gpu=(\d))?$", said.stdout, re.MULTILINE | re.DOTALL))
    assert {stage for stage, n in asked.items() if n == "1"} == hungry
    assert {stage for stage, n in asked.items() if n} == SIMULATOR | NETWORK
    assert asked.keys() >= {"candidates", "tables"}

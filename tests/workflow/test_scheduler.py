"""Snakemake's own process does not get busier with every job that ends."""

from __future__ import annotations

import os

import pytest

from tests.workflow import forked
from tests.workflow.conftest import ROOT

SNAKEFILE = """
import os
import sys

sys.path.insert(0, {root!r})
from ovman.workflow.snakemake_internals import lift_rate_limit


onstart:
    {handler}


rule all:
    input:
        "threads",
        "waiting",


rule quick:
    output:
        "quick/{{n}}",
    shell:
        "touch {{output}}"


rule threads:
    input:
        expand("quick/{{n}}", n=range(12)),
    output:
        "threads",
    params:
        snakemake=os.getpid(),
    priority: 1
    shell:
        "sleep 1.5; ls /proc/{{params.snakemake}}/task | wc -l > {{output}}"


rule waiting:
    input:
        expand("quick/{{n}}", n=range(12)),
    output:
        "waiting",
    threads: 2
    shell:
        "touch {{output}}"
"""


@pytest.mark.parametrize(("handler", "lifted"), [("lift_rate_limit(workflow)", True), ("pass", False)], ids=["ours", "its own"])
def test_jobs_that_ended_leave_no_timers_while_others_wait(tmp_path, handler, lifted):
    """Each timer is a thread. That the same counts them without the handler says when it is no longer needed."""
    (tmp_path / "Snakefile").write_text(SNAKEFILE.format(root=str(ROOT), handler=handler))
    said = forked.snakemake(["--cores", "2", "--", "all"], tmp_path, os.environ)
    assert said.returncode == 0, said.stdout
    assert (int((tmp_path / "threads").read_text()) < 8) is lifted

"""Stage `executions`: an embodied arm runs the episodes of a scene, once for each seed."""

from typing import Any

from ovman.agents import executions
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    seeds = [int(name.removeprefix("seed")) for name in snakemake.output.keys()]
    outputs = {seed: work.output(f"seed{seed}") for seed in seeds}
    executions.run(work.arm, work.scene, work.input("episodes"), work.input("trials"), work.constants, outputs, work.journal())

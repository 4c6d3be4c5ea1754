"""Stage `executions`: an embodied arm runs the episodes of a scene, once for each seed."""

from ovman.agents import executions
from ovman.job import job

with job(snakemake) as work:
    outputs = {int(name.removeprefix("seed")): work.output(name) for name, _ in snakemake.output.items()}
    executions.run(work.arm, work.scene, work.input("episodes"), work.input("trials"), work.constants, outputs, work.journal())

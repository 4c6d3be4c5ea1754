"""Stage `executions`: an embodied arm runs the episodes of a scene, once for each seed."""

from pathlib import Path

from ovman.evaluation import rollouts as executions
from ovman.workflow.job import job

with job(snakemake) as work:
    executions.run(
        work.constants.arm,
        work.scene,
        work.input("episodes"),
        work.input("trials"),
        work.constants,
        {int(name.removeprefix("seed")): work.output(name) for name, _ in snakemake.output.items()},
        work.journal(),
        Path("results", "visits"),
        {name: work.inputs(name) for name in ("maps", "dualmap", "nouns")},
    )

"""Stage `executions`: an embodied arm runs the episodes of a scene, once for each seed."""

from pathlib import Path

from ovman.agents import executions
from ovman.agents.arms import Arm
from ovman.job import job

with job(snakemake) as work:
    executions.run(
        Arm.of(work.constants.arm),
        work.scene,
        work.input("episodes"),
        work.input("trials"),
        work.constants,
        {int(name.removeprefix("seed")): work.output(name) for name, _ in snakemake.output.items()},
        work.journal(),
        Path("results", "visits"),
        {name: work.inputs(name) for name in ("maps", "dualmap", "nouns")},
    )

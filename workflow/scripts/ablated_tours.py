"""Stage `ablated_tours`: the tours of all variants of a scene's episodes."""

from pathlib import Path

from ovman.evaluation import ablated_tours
from ovman.workflow.job import job

with job(snakemake) as work:
    ablated_tours.run(
        work.scene,
        work.inputs("episodes"),
        work.constants,
        Path("results", "ablation", work.split, "visits", work.scene),
        work.output("visits"),
    )

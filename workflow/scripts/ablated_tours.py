"""Stage `ablated_tours`: the tours of all variants of a scene's episodes."""

from pathlib import Path

from ovman.evaluation import ablation
from ovman.workflow.job import job

with job(snakemake) as work:
    visits = Path("results", "ablation", work.split, "visits")
    line = ablation.record_scene(work.constants, work.inputs("episodes"), visits, work.constants.canonical, work.scene)
    work.output("visits").write_text(line)

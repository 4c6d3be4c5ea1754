"""Stage `episodes`: a released split, and the audit of what was rejected."""

from ovman.generation import release
from ovman.settings import MAIN
from ovman.workflow.job import job

with job(snakemake) as work:
    release.run(
        work.inputs("trials"),
        work.inputs("admissible"),
        work.inputs("certified"),
        work.constants,
        work.output("episodes"),
        work.output("sightings"),
        work.output("rejections"),
        snakemake.wildcards.get("split", MAIN),
    )

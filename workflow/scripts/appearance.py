"""Stage `appearance`: what cues of appearance are worth in the association, fitted on one split and tested on the others."""

from ovman.analysis import appearance
from ovman.workflow.job import job

with job(snakemake) as work:
    appearance.write_appearance(
        work.inputs("episodes"),
        work.inputs("predictions"),
        work.inputs("maps"),
        work.inputs("cues"),
        work.constants,
        work.output("appearance"),
    )

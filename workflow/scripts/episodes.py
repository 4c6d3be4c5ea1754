"""Stage `episodes`: the released splits, and of each the audit of what was rejected."""

from ovman.generation import release
from ovman.models.settings import splits_of
from ovman.workflow.job import job

with job(snakemake) as work:
    for split, *outputs in zip(
        splits_of(work.constants.splits),
        work.outputs("episodes"),
        work.outputs("sightings"),
        work.outputs("rejections"),
        strict=True,
    ):
        release.run(
            work.inputs("scenes"),
            work.inputs("trials"),
            work.inputs("admissible"),
            work.inputs("certified"),
            work.constants,
            *outputs,
            split,
        )

"""Stage `maintained`: one map of both tours of every episode."""

from ovman.perception import maintained
from ovman.workflow.job import job

with job(snakemake) as work:
    maintained.run(work.inputs("detections"), work.inputs("episodes"), work.constants, work.outputs("maintained"))

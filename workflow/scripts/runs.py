"""Stage `runs`: judges what an embodied arm did."""

from ovman.analysis import runs
from ovman.job import job

with job(snakemake) as work:
    runs.run(work.inputs("executions"), work.input("episodes"), work.constants, work.outputs("runs"))

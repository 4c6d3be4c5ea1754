"""Stage `probes`: what the two-visit agent answers under other association gates, and to REMOVED read as FORMER."""

from ovman.analysis import probes
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    probes.run(work.constants.arm, work.input("episodes"), work.inputs("maps"), work.input("nouns"), work.constants, directory)

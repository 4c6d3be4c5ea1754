"""Stage `probes`: what the two-visit agent answers under other association gates, and to REMOVED read as FORMER."""

from ovman.analysis import probes
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    maps = work.inputs("maps")[0].parent
    probes.write_probes(work.constants.arm, work.input("episodes"), maps, work.input("nouns"), work.constants, directory)

"""Stage `runs`: judges what an embodied arm did."""

from typing import Any

from ovman.analysis import runs
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    runs.run(work.inputs("executions"), work.input("episodes"), work.constants, work.outputs("runs"))

"""Stage `released_dualmap_setup`: whether DualMap's released code can be run, and in one line what is missing where it cannot."""

from ovman.workflow.job import job
from ovman_released import dualmap_setup
from ovman_released.status import Status

with job(snakemake) as work:
    wrong = dualmap_setup.lacks(work.constants.released.dualmap)
    if wrong is not None:
        print(f"{dualmap_setup.SYSTEM} is not run: {wrong}", flush=True)
    Status(dualmap_setup.SYSTEM, wrong or "").write(work.output("status"))

"""Stage `released_dualmap_setup`: whether DualMap's released code can run, and in one line what is missing where it cannot."""

from ovman.records.note import Note
from ovman.workflow.job import job

with job(snakemake) as work:
    # The package may lie beside an overlay, where only a job looks for modules.
    from ovman_released import dualmap_setup
    from ovman_released.settings import released_dualmap

    missing = dualmap_setup.lacks(released_dualmap(work.constants))
    if missing is not None:
        print(f"{dualmap_setup.SYSTEM} is not run: {missing}", flush=True)
    Note(system=dualmap_setup.SYSTEM, missing=missing or "").write(work.output("note"))

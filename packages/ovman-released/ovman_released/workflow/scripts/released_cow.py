"""Stage `released_cow`: CoW as its authors released it runs the episodes, or says what is missing for it."""

from pathlib import Path

from ovman.workflow.job import job

with job(snakemake) as work:
    # The package may lie beside an overlay, where only a job looks for modules.
    from ovman_released import cow

    places = [Path(place) for place in snakemake.output.rollouts]
    runs = [(int(place.parent.name.removeprefix("seed")), place.stem) for place in places]
    cow.run(
        work.input("episodes"),
        work.constants,
        dict(zip(runs, work.outputs("rollouts"), strict=True)),
        work.output("note"),
        work.journal(),
    )

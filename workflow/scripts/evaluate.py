"""The rules of evaluate.smk: what agents answer to the episodes, and where they drive.

Each function is called like its rule and imports what it calls: a job starts sooner without the modules of other rules.
"""

from pathlib import Path

from stage import Job, run

from ovman.settings.arms import ArmJob

PERCEIVED = ("maps", "maintained", "dualmap", "detections", "segments", "labels", "nouns")


def perceived(job: Job) -> dict[str, Path]:
    """Return the inputs of the job that networks made."""
    return {name: file for name in PERCEIVED if (file := job.file(name)) is not None}


def predictions(job: Job) -> None:
    from ovman.evaluation import predictions as static

    files = job.file("episodes"), Path(job.output.predictions), perceived(job)
    static.run(job.arm, job.settings, *files, job.file("sightings"), job.files("scenes"))


def rollouts(job: Job) -> None:
    from ovman.evaluation import rollouts as embodied

    embodied.run(
        job.arm,
        job.settings,
        job.file("episodes"),
        job.params.seeds,
        Path(job.output.rollouts),
        job.cache(),
        perceived(job),
        job.file("sightings"),
        job.file("predictions"),
        workers=job.workers,
    )


def scores(job: Job) -> None:
    from ovman.evaluation import scores as judging

    arms = map(ArmJob.model_validate, job.params.arms)
    judging.run(arms, job.file("episodes"), Path("results", "rollouts", job.wildcards.split), Path(job.output.scores))


def readmitted_predictions(job: Job) -> None:
    from ovman.evaluation import predictions as static

    static.run(job.arm, job.settings, job.file("episodes"), Path(job.output.predictions), perceived(job))


run(snakemake, globals())  # noqa: F821 (Snakemake defines it)

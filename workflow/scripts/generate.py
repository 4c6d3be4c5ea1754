"""The rules of generate.smk: from floor plans to certified episodes.

Each function is called like its rule and imports what it calls: a job starts sooner without the modules of other rules.
"""

from collections.abc import Mapping
from pathlib import Path

from stage import Job, run


def simulator(job: Job) -> None:
    from ovman.doctor import checks

    checks.check_simulator(Path(job.output.simulator))


def scenes(job: Job) -> None:
    from ovman.generation import scenes as survey
    from ovman.settings.splits import Homes
    from ovman.sim.scenes import name_house

    given = job.params.scenes
    homes = Homes.model_validate(given) if isinstance(given, Mapping) else None
    names = [name_house(name) for name in given] if homes is None else survey.draw_homes(homes, job.workers)
    survey.run(names, job.settings, Path(job.output.scenes), job.cache(), job.workers)


def candidates(job: Job) -> None:
    from ovman.generation import candidates as drawing

    drawing.run(job.wildcards.split, job.file("scenes"), job.settings, Path(job.output.candidates), job.workers)


def trials(job: Job) -> None:
    from ovman.generation import trials as measuring

    files = job.file("scenes"), job.file("candidates")
    measuring.run(*files, job.settings, Path(job.output.trials), job.cache(), job.workers)


def admissible(job: Job) -> None:
    from ovman.generation import verdict

    verdict.run(job.file("trials"), job.settings, Path(job.output.admissible))


def certified(job: Job) -> None:
    from ovman.generation import certification

    files = job.file("admissible"), job.file("trials")
    certification.run(*files, job.settings, Path(job.output.certified), job.cache(), job.workers)


def episodes(job: Job) -> None:
    from ovman.generation import release

    inputs = [job.file(name) for name in ("trials", "admissible", "certified")]
    outputs = [Path(made) for made in (job.output.episodes, job.output.sightings, job.output.rejections)]
    release.run(*inputs, job.settings, *outputs, job.wildcards.split)


def tours(job: Job) -> None:
    from ovman.evaluation import tours as recording

    recording.run(job.file("episodes"), job.settings, Path(job.output.visits), Path("results", "visits"), job.workers)


def readmitted(job: Job) -> None:
    from ovman.generation import readmission

    files = job.file("trials"), job.file("released")
    readmission.run(*files, job.settings, Path(job.output.episodes), Path(job.output.admissions))


run(snakemake, globals() | {"readmitted_tours": tours})  # noqa: F821 (Snakemake defines it)

"""The rules of train.smk: the networks of the default configuration. They need PyTorch."""

from pathlib import Path

from stage import Job, run

from training import crops as cropping
from training import detector as detecting
from training import encoder as encoding
from training import export
from training import models as release
from training import pictures as recording

CURVES = ("detector_first_curve", "detector_curve", "encoder_curve")


def pictures(job: Job) -> None:
    recording.run(job.wildcards.scene, job.params.held_out, job.settings, Path(job.output.pictures))


def crops(job: Job) -> None:
    cropping.run_true(job.file("pictures"), job.settings, Path(job.output.crops))


def detector(job: Job) -> None:
    folder = Path("results", "training", job.rule)
    outputs = Path(job.output.weights), Path(job.output.curve)
    detecting.run(job.files("taught"), job.files("held_out"), job.settings, job.file("start"), folder, *outputs)


def detected(job: Job) -> None:
    cropping.run_detected(job.files("pictures"), job.settings, [Path(one) for one in job.output.crops])


def texts(job: Job) -> None:
    export.write_texts(Path(job.output.texts))


def encoder(job: Job) -> None:
    held_out = {name: job.files(name) for name in ("floor_plans", "homes")}
    outputs = Path(job.output.weights), Path(job.output.graph), Path(job.output.curve)
    encoding.run(job.files("taught"), held_out, job.file("texts"), job.settings, *outputs)


def models(job: Job) -> None:
    curves = [job.file(name) for name in CURVES]
    files = *(job.file(name) for name in ("detector", "encoder", "texts")), curves, job.files("pictures"), job.files("crops")
    release.run(*files, job.params.scenes, job.settings, Path(job.output.models))


run(snakemake, globals() | {"detector_first": detector})  # noqa: F821 (Snakemake defines it)

"""What the scripts of all rules have in common: settings, log, cache, and an end with Snakemake."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ovman import kernels
from ovman.atomic import remove
from ovman.cache import Cache
from ovman.processes import end_with_parent
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.settings.plugins import settings_with


class Job:
    """A job of a rule, as its function in one of the scripts sees it.

    Attributes:
        input: Snakemake's input files, by name.
        output: Snakemake's output files, by name, where the job makes them.
        wildcards: Snakemake's wildcards, such as `split` and `arm`.
        params: The parameters of the rule: its constants, its code and, for a job of an arm, the arm.
        workers: Number of processes that the job may use.
        unfinished: Where the job makes each output, by the output's place.
        folder: Where the job makes its first output, for jobs with many files of one folder.
    """

    def __init__(self, snakemake: Any) -> None:
        self.input, self.wildcards = snakemake.input, snakemake.wildcards
        self.unfinished = _unfinished(snakemake.output)
        self.output = SimpleNamespace(
            **{
                name: self.unfinished[one] if isinstance(one, str) else [self.unfinished[each] for each in one]
                for name, one in snakemake.output.items()
            }
        )
        self.folder = Path(self.unfinished[snakemake.output[0]]).parent
        self.params, self.rule, self.workers = snakemake.params, snakemake.rule, snakemake.threads

    @cached_property
    def settings(self) -> Settings:
        """The constants that the rule names in its parameters."""
        return settings_with(dict(self.params.get("plugins", {}))).partial(self.params.constants)

    @cached_property
    def arm(self) -> ArmJob:
        """The arm of the job."""
        return ArmJob.model_validate(self.params.arm)

    def files(self, name: str) -> list[Path]:
        """Return an input of any number of files, in the order of the rule."""
        value = self.input.get(name, [])
        return [Path(value)] if isinstance(value, str) else [Path(one) for one in value]

    def file(self, name: str) -> Path | None:
        """Return an input of one file, None if the job does not need it."""
        return next(iter(self.files(name)), None)

    def cache(self, name: str = "", code: str = "") -> Cache:
        """Return the cache of the rule's work items, or of those of a name that several rules share."""
        folder = Path("results", "cache", name or self.rule)
        restored = folder / "restored"
        is_same_code = restored.is_dir() and (restored / "code.txt").read_text() == os.environ.get("OVMAN_CODE")
        return Cache(folder / (code or self.params.code), restored if is_same_code else None)


def _unfinished(outputs: Sequence[str]) -> dict[str, str]:
    """Return where a job makes each of its outputs: in a hidden folder of its own, from which they are renamed at its end.

    So a job that was killed leaves no output that looks finished. Snakemake notices unfinished ones only of jobs that it knows of
    when it starts, which those behind a checkpoint are not.
    """
    folder = f".{Path(outputs[0]).name}.unfinished"
    return {one: str(Path(one).parent / folder / Path(one).name) for one in outputs}


def run(snakemake: Any, functions: Mapping[str, Callable[[Job], None]]) -> None:
    """Run the function that is called like the rule.

    The rule's log gets all that the job and its processes print. An error that says all in its one line has no traceback.
    """
    # Snakemake gives OpenBLAS as many threads as the job has cores.
    kernels.hold()
    end_with_parent()
    sys.path.extend(filter(None, os.environ.get("OVMAN_AGENTS", "").split(os.pathsep)))
    if snakemake.log:
        log = os.open(str(snakemake.log), os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
        os.dup2(log, 1)
        os.dup2(log, 2)
    job = Job(snakemake)
    folders = {Path(made).parent for made in job.unfinished.values()}
    for folder in folders:
        remove(folder)
        folder.mkdir(parents=True)
    try:
        functions[job.rule](job)
        for output, made in job.unfinished.items():
            os.replace(made, output)
        for folder in folders:
            folder.rmdir()
    except Exception as error:
        if getattr(error, "says_all", False):
            raise SystemExit(str(error)) from None
        raise

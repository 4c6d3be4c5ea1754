"""Snakemake's command line in processes that begin with Snakemake imported: more than half of a dry run is imports."""

from __future__ import annotations

import gc
import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

LIBRARIES = ("snakemake.cli", "snakemake.report.html_reporter", "pandas", "pydantic", "smart_open", "yte")
"""Nothing of ovman: that is imported as the Snakefile has it imported."""


def snakemake(arguments: Sequence[str], directory: Path, environment: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
    """`snakemake`, run with these arguments in `directory` to its end; standard error is in stdout."""
    with tempfile.TemporaryDirectory() as place:
        said = Path(place, "said")
        status = _run(arguments, directory, environment, said)
        return subprocess.CompletedProcess(["snakemake", *arguments], status, said.read_text())


def _run(arguments: Sequence[str], directory: Path, environment: Mapping[str, str], said: Path) -> int:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LIBRARIES])
    process = context.Process(target=_become, args=([*arguments], directory, dict(environment), said))
    process.start()
    try:
        process.join()
    finally:
        process.kill()
    assert process.exitcode is not None
    return process.exitcode


def _become(arguments: list[str], directory: Path, environment: dict[str, str], said: Path) -> None:
    """Be the process that `python -m snakemake` would be."""
    from snakemake import cli

    gc.freeze()  # what was imported before stays; going through it takes a fifth of a dry run
    output = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
    for stream in (1, 2):
        os.dup2(output, stream)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(directory)
    sys.path[:0] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    sys.argv = ["snakemake", *arguments]
    cli.main()

"""Snakemake's command line in processes that begin with Snakemake imported: more than half of a dry run is imports."""

from __future__ import annotations

import gc
import multiprocessing
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from multiprocessing import forkserver
from pathlib import Path
from unittest.mock import patch

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / ".pytest_cache" / "ovman.sources.json"
"""What is known of the files of the code, by their content: for the next session, and for Snakemakes that are no forks."""
LIBRARIES = (
    "argparse_dataclass",
    "nbformat",
    "pandas",
    "pydantic",
    "smart_open",
    "snakemake.benchmark",
    "snakemake.cli",
    "snakemake.profiles",
    "snakemake.report.html_reporter",
    "snakemake.storage",
    "yte",
)


@cache
def _ours() -> tuple[str, ...]:
    """What the rules import of this checkout. None of it looks at its directory or environment before the Snakefile calls it."""
    rules = sorted((ROOT / "workflow" / "rules").glob("*.smk"))
    return tuple(name for file in rules for name in re.findall(r"^from (ovman\.[\w.]+) import", file.read_text(), re.MULTILINE))


def snakemake(arguments: Sequence[str], directory: Path, environment: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
    """`snakemake`, run with these arguments in `directory` to its end; standard error is in stdout."""
    with tempfile.TemporaryDirectory() as place:
        said = Path(place, "said")
        status = _run(arguments, directory, environment, said)
        return subprocess.CompletedProcess(["snakemake", *arguments], status, said.read_text())


def _run(arguments: Sequence[str], directory: Path, environment: Mapping[str, str], said: Path) -> int:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LIBRARIES, *_ours(), "tests.workflow.warm"])
    # A module of the tests is found from any directory. A forked process has the variables that it is given, not these.
    with patch.dict(os.environ, PYTHONPATH=os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])):
        forkserver.ensure_running()
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
    sys.argv = ["snakemake", *arguments]
    cli.main()

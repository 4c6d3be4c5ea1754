"""What the workflow uses of Snakemake beyond its documentation, in one place, with the reason for each.

`USED` lists the attributes; a test compares it with the Snakemake that is installed. Imports nothing heavy.
"""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

from ovman.workflow.fork_server import Fork
from ovman.workflow.locks import flock

USED: Mapping[str, str] = {
    "Workflow.register_resource": "a limit of one GPU job, which a user's --resources cannot raise; a profile's limit it can",
    "Workflow.overwrite_configfiles": "the overlays of --configfile, beside which agents lie and which messages name",
    "Workflow.is_main_process": "what is done once and not in every job",
    "Workflow.dryrun": "a dry run writes no results",
    "Workflow.ruleorder": "the Snakefile's own `ruleorder` takes no names that are worked out",
    "Workflow.group_settings": "the group that a profile gives to a rule is that of the rules in its place",
    "ResourceSettings._parsed_overwrite_resources": "the same of time and memory",
    "Workflow.local_exec": "jobs that are processes of this machine",
    "JobScheduler.job_rate_limiter": "no option switches the limit off, and its timers take half a core while jobs wait",
    "Persistence: .snakemake/locks": "--unlock is a command of its own, and a killed Snakemake leaves its locks",
    "PythonScript.execute_script": "a script's process is a fork of one with its imports; no option starts it otherwise",
    "benchmarked": "what a `benchmark` file says of a process, for one that Snakemake has not started itself",
    "FilePersistence._read_record": "the release says under which parameter each output was made (snakemake_records)",
    "FilePersistence._write_record": "what is restored is done, and a changed constant reruns it (snakemake_records)",
    "MetadataRecord.params": "in it the one parameter of a rule",
    "MetadataRecord.input_checksums": "an input that was made again with the same bytes reruns nothing",
}
"""Attributes and files, and why each is used."""
TEMPORARY = ("TMPDIR", "TMP", "TEMPDIR", "TEMP")
"""Variables that Snakemake sets to the resource `tmpdir` for a script."""
LOCKS = Path(".snakemake", "locks")
ALIVE = Path(".snakemake", "ovman.alive")
"""Every Snakemake that works in a directory shares a lock on this file; the kernel releases it when the process ends."""
_open_files: list[TextIO] = []


def limit_gpu(workflow: Any) -> None:
    """At most one job of those that ask for `gpu` at a time. A user's --resources replaces a profile's limit, but not this."""
    workflow.register_resource("gpu", 1)


def lift_rate_limit(workflow: Any) -> None:
    """As many jobs a second as there are cores for, where jobs are processes of this machine; when the jobs start.

    For its limit, Snakemake looks for work again a second after every look. While jobs wait for a core, every job that ends adds
    one look a second; some hundred of them take half a core.
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


def fork_scripts(workflow: Any, run: Callable[[str, Mapping[str, str]], Fork]) -> None:
    """Have the scripts of rules run by `run`, where jobs are processes of this machine.

    A script of several threads, or of an environment or a container of its own, gets a process as Snakemake starts it.
    """
    from snakemake.benchmark import benchmarked
    from snakemake.script import PythonScript

    started = PythonScript.execute_script

    def execute_script(self: Any, fname: str, edit: bool = False) -> None:
        own = (self.conda_env, self.container_img, self.env_modules, self.resources.get("shell_exec"))
        if edit or not workflow.local_exec or self.threads != 1 or any(one is not None for one in own):
            started(self, fname, edit)
            return
        environment = os.environ | dict.fromkeys(TEMPORARY, str(self.resources.get("tmpdir", tempfile.gettempdir())))
        fork = run(fname, environment)
        with benchmarked(fork.pid if self.bench_record is not None else False, self.bench_record):
            status = fork.wait()
        if self.bench_record is not None and self.bench_record.data_collected:  # Snakemake looks every half minute
            self.bench_record.cpu_time = fork.processor_s
        if status:
            raise subprocess.CalledProcessError(status, [sys.executable, fname])

    PythonScript.execute_script = execute_script


def go_before(workflow: Any, names: Sequence[str], rule: str) -> None:
    """Rules that make some files of `rule` in its place. What a profile gives to `rule`, time and memory, it gives to them, too.

    names: of rules that are not defined yet.
    """
    if names:
        workflow.ruleorder(*names, rule)
    asked = workflow.resource_settings._parsed_overwrite_resources
    asked.update({name: asked[rule] for name in names if rule in asked})


def group_like(workflow: Any, rule: str) -> Callable[[object], str | None]:
    """The `group` of a rule that is in the group of `rule`, which a profile names after the rules are read."""

    def group(wildcards: object) -> str | None:
        found: str | None = workflow.group_settings.overwrite_groups.get(rule)
        return found

    return group


def overlays(workflow: Any) -> list[Path]:
    """The absolute paths of the files of --configfile, in their order."""
    return [Path(path).absolute() for path in workflow.overwrite_configfiles]


def alone(directory: Path) -> bool:
    """Say from now on that this process works in `directory`; whether no other living Snakemake does.

    Removes Snakemake's locks on the directory where no other does: a killed Snakemake leaves them, and the next one would refuse
    to start. NoLocksError.
    """
    path = directory / ALIVE
    path.parent.mkdir(parents=True, exist_ok=True)
    file = path.open("a")
    _open_files.append(file)
    try:
        flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        found = False
    else:
        found = True
        for lock in (directory / LOCKS).glob("*.lock"):
            lock.unlink(missing_ok=True)
    flock(file, fcntl.LOCK_SH)
    return found

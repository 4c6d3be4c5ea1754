"""The command `ovman eval`: from its options to an evaluation."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from ovman.entry.entrant import entrant, stays
from ovman.entry.evaluation import LOG, Evaluation, asked, evaluate
from ovman.entry.manifest import Where
from ovman.entry.release import CONFIG, DATA, EntryError, Release
from ovman.entry.summary import as_text
from ovman.evaluation.supervision import AgentError, function
from ovman.models.settings import Settings
from ovman.models.settings.arms import ArmJob
from ovman.perception.libraries import cache as user_cache
from ovman.remote.agent import Remotes
from ovman.remote.process import AgentProcess
from ovman.workflow.config import load
from ovman.workflow.parameter import stage_settings
from ovman.workflow.provenance import lacking


def run(options: argparse.Namespace, say: Callable[[str], None]) -> str:
    """Evaluate as the options say, and return the summary as text. say: told of progress, a line a time.

    The working directory is on Python's path from then on where an --agent is named. EntryError, ConfigError, RecordError,
    AgentError or SimulatorError, in one line.
    """
    if options.agent is not None and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    settings, name = entrant(load(Path(options.config or CONFIG)), options.agent, options.arm, options.name, options.needs)
    release = Release(Path(options.release or DATA), settings)
    episodes_file = None if options.episodes is None else Path(options.episodes)
    shard = shard_of(options.shard)
    what = asked(release, options.split, episodes_file, options.scenes, shard, options.seeds or settings.evaluation.seeds)
    cache = user_cache() if options.cache is None else Path(options.cache)
    of_arm = stage_settings(settings, "rollouts", name)
    where = place(options, of_arm.arm)
    out = Path(options.out)
    with ExitStack() as open_until_done:
        if where is not Where.SERVER:
            _refuse_absent(name, of_arm.arm, where)
        remotes = None if where is Where.EVALUATOR else _remotes(options, where, settings, out, open_until_done)
        doing = Evaluation(of_arm, what, where, remotes, options.failures == "abstain")
        manifest, summary = evaluate(doing, release, out, cache.absolute(), say)
    return f"\n{as_text(summary, markdown=False)}"


def place(options: argparse.Namespace, arm: ArmJob) -> Where:
    """Where it runs. An agent of the user's has a process of its own unless it is trusted; an arm of ours where it must."""
    if options.server is not None:
        if options.in_process or options.agent is not None:
            raise EntryError("--server: its agent is where it is; leave out --agent and --in-process")
        return Where.SERVER
    if options.in_process and not stays(arm):
        raise EntryError(f"--in-process: {arm.name} needs more than tours; leave it out")
    return Where.EVALUATOR if options.in_process or (options.arm is not None and stays(arm)) else Where.PROCESS


def _remotes(options: argparse.Namespace, where: Where, settings: Settings, out: Path, until: ExitStack) -> Remotes:
    if where is Where.SERVER:
        return until.enter_context(Remotes(lambda: str(options.server), settings.remote))
    arguments = ["--arm", options.arm] if options.arm is not None else ["--agent", options.agent, "--path", str(Path.cwd())]
    if options.name is not None:
        arguments += ["--name", options.name]
    if options.needs is not None:
        arguments += ["--needs", *options.needs]
    if options.config is not None:
        arguments += ["--config", str(Path(options.config).absolute())]
    process = AgentProcess(["-m", "ovman.entry.serve", *arguments], settings.remote, out / LOG)
    return until.enter_context(Remotes(until.enter_context(process).address, settings.remote))


def _refuse_absent(name: str, arm: ArmJob, where: Where) -> None:
    """AgentError where the agent is not there, in the working directory or elsewhere on Python's path.

    What is to run in a process of its own is looked for and not imported.
    """
    if where is Where.EVALUATOR:
        function(name, arm.agent)
    elif (wrong := lacking(*arm.agent.split(":", 1))) is not None:
        raise AgentError(f"arms.{name}.agent is {arm.agent!r}, and {wrong}")


def shard_of(text: str) -> tuple[int, int]:
    """(k, m) of "k/m", 1 <= k <= m. EntryError for another text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise EntryError(f"--shard: {text!r} is no part; write k/m, k from 1 to m, such as 2/8")
    return int(found[1]), int(found[2])

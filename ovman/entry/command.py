"""The commands `ovman eval`, `ovman verify` and `ovman merge`: from their options to what is made of them."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from pathlib import Path

from ovman.entry.defaults import CONFIG, DATA
from ovman.entry.entrant import entrant, stays
from ovman.entry.errors import EntryError
from ovman.entry.evaluation import LOG, Evaluation, asked, evaluate
from ovman.entry.manifest import Where
from ovman.entry.merging import merge
from ovman.entry.release import Release
from ovman.entry.source_cache import remembered
from ovman.entry.summary import as_text
from ovman.entry.verification import Verification, as_lines, verify
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.perception.libraries import cache as user_cache
from ovman.remote.elsewhere import Elsewhere, OwnProcess, Server
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.settings.config import load
from ovman.workflow.parameter import stage_settings
from ovman.workflow.provenance import lacking
from ovman_client.server import lacking as methods_lacking


def run(options: argparse.Namespace, say: Callable[[str], None]) -> str:
    """Evaluate as the options say, and return the summary as text. say: told of progress, a line a time.

    The working directory is on Python's path from then on where an --agent is named. EntryError, ConfigError, RecordError,
    AgentError or SimulatorError, in one line.
    """
    remembered()
    if options.agent is not None and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    settings, name = entrant(load(Path(options.config or CONFIG)), options.agent, options.arm, options.name, options.needs)
    release = Release(Path(options.release or DATA), settings)
    episodes_file = None if options.episodes is None else Path(options.episodes)
    shard = shard_of(options.shard)
    what = asked(release, options.split, episodes_file, options.scenes, shard, options.seeds or settings.evaluation.seeds)
    cache = user_cache() if options.cache is None else Path(options.cache)
    if options.agent is not None:
        module, _, attribute = options.agent.partition(":")
        if (wrong := lacking(module, attribute, "into this folder")) is not None:
            raise AgentError(f"--agent {options.agent}: {wrong}")
    try:
        of_arm = stage_settings(settings, "rollouts", name)
    except SyntaxError as error:  # of a module that the agent's imports
        raise AgentError(f"{error.filename}, line {error.lineno}, is not Python: {error.msg}; mend it") from None
    where = place(options, of_arm.arm)
    if where is Where.EVALUATOR and (absent := methods_lacking(load_agent(name, of_arm.arm.agent))) is not None:
        raise AgentError(f"{of_arm.arm.agent} has no method {absent}; write it (docs/agents.md)")
    out = Path(options.out)
    doing = Evaluation(of_arm, what, _elsewhere(options, where, settings, out), options.failures == "abstain")
    _, summary = evaluate(doing, release, out, cache.absolute(), say, checked_workers(options.workers))
    return f"\n{as_text(summary, markdown=False)}"


def verified(options: argparse.Namespace, say: Callable[[str], None]) -> Verification:
    """Verify as the options say, and say what comes of it. EntryError, ConfigError, RecordError, SimulatorError, in one line."""
    remembered()
    release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
    episodes_file = None if options.episodes is None else Path(options.episodes)
    found = verify(Path(options.directory), release, episodes_file, say, checked_workers(options.workers))
    for line in as_lines(found):
        say(line)
    return found


def merged(options: argparse.Namespace) -> str:
    """Merge as the options say, and return the summary as text. EntryError, ConfigError or RecordError, in one line."""
    release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
    episodes_file = None if options.episodes is None else Path(options.episodes)
    _, summary = merge(Path(options.out), [Path(one) for one in options.directories], release, episodes_file)
    return as_text(summary, markdown=False)


def place(options: argparse.Namespace, arm: ArmJob) -> Where:
    """Where it runs. An agent of the user's has a process of its own unless it is trusted; an arm of ours where it must."""
    if options.server is not None:
        if options.in_process or options.agent is not None:
            raise EntryError("--server: its agent is where it is; leave out --agent and --in-process")
        return Where.SERVER
    if options.in_process and not stays(arm):
        raise EntryError(f"--in-process: {arm.name} needs more than tours; leave it out")
    return Where.EVALUATOR if options.in_process or (options.arm is not None and stays(arm)) else Where.PROCESS


def _elsewhere(options: argparse.Namespace, where: Where, settings: Settings, out: Path) -> Elsewhere | None:
    """Where the agent is in another process."""
    if where is Where.EVALUATOR:
        return None
    if where is Where.SERVER:
        return Server(options.server, settings.remote)
    arguments = ["--arm", options.arm] if options.arm is not None else ["--agent", options.agent, "--path", str(Path.cwd())]
    if options.name is not None:
        arguments += ["--name", options.name]
    if options.needs is not None:
        arguments += ["--needs", *options.needs]
    if options.config is not None:
        arguments += ["--config", str(Path(options.config).absolute())]
    return OwnProcess(("-m", "ovman.entry.serve", *arguments), settings.remote, out / LOG)


def checked_workers(number: int) -> int:
    """The number of workers. EntryError for fewer than one."""
    if number < 1:
        raise EntryError(f"--workers: {number} make nothing; write 1 or more")
    return number


def shard_of(text: str) -> tuple[int, int]:
    """(k, m) of "k/m", 1 <= k <= m. EntryError for another text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise EntryError(f"--shard: {text!r} is no part; write k/m, k from 1 to m, such as 2/8")
    return int(found[1]), int(found[2])

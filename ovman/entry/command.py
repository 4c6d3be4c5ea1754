"""The commands `ovman eval`, `ovman verify` and `ovman merge`, from their options."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from pathlib import Path

from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.entrant import check_entry_point, runs_in_process, select_arm
from ovman.entry.evaluation import LOG, Evaluation, digest_run_code, evaluate, select_episodes
from ovman.entry.manifest import Where
from ovman.entry.merging import merge
from ovman.entry.release import Release
from ovman.entry.summary import as_text
from ovman.entry.verification import Verification, as_lines, verify
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.remote.agent import AgentEndpoint
from ovman.settings.arms import ArmJob
from ovman.settings.benchmark import Remote
from ovman.settings.config import load
from ovman.settings.jobs import arm_job, settings_of_arm
from ovman.shipped import user_cache
from ovman_client.server import lacking

Say = Callable[[str], None]


def run_eval(options: argparse.Namespace, say: Say) -> str:
    """Evaluate as the options say, and return the summary as text. say: Told of progress, line by line.

    If an --agent is named, the working directory is on Python's path from then on.

    Raises:
        EntryError, ConfigError, RecordError, AgentError, SimulatorError: In one line.
    """
    if options.agent is not None and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    config = load(Path(options.config or CONFIG))
    settings, name = select_arm(config, options.agent, options.arm, options.name, options.needs)
    release = Release(Path(options.release or DATA), settings)
    seeds = options.seeds or settings.evaluation.seeds
    shard = parse_shard(options.shard)
    selection = select_episodes(release, options.split, _episodes(options), options.scenes, shard, seeds)
    cache = user_cache() if options.cache is None else Path(options.cache)
    if options.agent is not None:
        check_entry_point(options.agent)
    arm = arm_job(settings, name)
    try:
        code = digest_run_code(arm)
    except SyntaxError as error:  # in a module that the agent's imports
        raise AgentError(f"{error.filename}, line {error.lineno}, is not Python: {error.msg}; mend it") from None
    where = choose_place(options, arm)
    if where is Where.EVALUATOR and (absent := lacking(load_agent(name, arm.agent))) is not None:
        raise AgentError(f"{arm.agent} has no method {absent}; write it (docs/agents.md)")
    out, workers = Path(options.out), check_workers(options.workers)
    endpoint = _endpoint(options, where, settings.remote, out)
    abstains = options.failures == "abstain"
    doing = Evaluation(arm, settings_of_arm(settings, name), seeds, endpoint, abstains, out, cache.absolute(), code)
    _, summary = evaluate(doing, selection, release, say, workers)
    return f"\n{as_text(summary, markdown=False)}"


def run_verify(options: argparse.Namespace, say: Say) -> Verification:
    """Verify as the options say, and say the result. Errors as for `verify`."""
    found = verify(Path(options.directory), _release(options), _episodes(options), say, check_workers(options.workers))
    for line in as_lines(found):
        say(line)
    return found


def run_merge(options: argparse.Namespace) -> str:
    """Merge as the options say, and return the summary as text. Errors as for `merge`."""
    _, summary = merge(Path(options.out), [Path(one) for one in options.directories], _release(options), _episodes(options))
    return as_text(summary, markdown=False)


def choose_place(options: argparse.Namespace, arm: ArmJob) -> Where:
    """Return where the agent runs: a user's agent in a process of its own unless it is trusted, an arm of ours if it must."""
    if options.server is not None:
        if options.in_process or options.agent is not None:
            raise EntryError("--server: its agent is where it is; leave out --agent and --in-process")
        return Where.SERVER
    if options.in_process and not runs_in_process(arm):
        raise EntryError(f"--in-process: {arm.name} needs more than tours; leave it out")
    return Where.EVALUATOR if options.in_process or (options.arm is not None and runs_in_process(arm)) else Where.PROCESS


def check_workers(number: int) -> int:
    """Return the number of workers. EntryError for fewer than one."""
    if number < 1:
        raise EntryError(f"--workers: {number} make nothing; write 1 or more")
    return number


def parse_shard(text: str) -> tuple[int, int]:
    """Return (k, m) of "k/m", 1 <= k <= m. EntryError for another text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise EntryError(f"--shard: {text!r} is no part; write k/m, k from 1 to m, such as 2/8")
    return int(found[1]), int(found[2])


def _release(options: argparse.Namespace) -> Release:
    return Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))


def _episodes(options: argparse.Namespace) -> Path | None:
    return None if options.episodes is None else Path(options.episodes)


def _endpoint(options: argparse.Namespace, where: Where, limits: Remote, out: Path) -> AgentEndpoint | None:
    if where is Where.EVALUATOR:
        return None
    if where is Where.SERVER:
        return AgentEndpoint(limits, options.server)
    arguments = ["--arm", options.arm] if options.arm is not None else ["--agent", options.agent, "--path", str(Path.cwd())]
    if options.name is not None:
        arguments += ["--name", options.name]
    if options.needs is not None:
        arguments += ["--needs", *options.needs]
    if options.config is not None:
        arguments += ["--config", str(Path(options.config).absolute())]
    return AgentEndpoint(limits, arguments=("-m", "ovman.entry.serve", *arguments), log=out / LOG)

"""The commands `ovman eval` and `ovman verify`, from their options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from ovman.entry import EntryError
from ovman.entry.entrant import runs_in_process, select_arm
from ovman.entry.evaluation import Evaluation, digest_run_code, evaluate, select_episodes
from ovman.entry.manifest import LOG, Where
from ovman.entry.release import Release
from ovman.entry.summary import Summary
from ovman.entry.verification import Verification, verify
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.remote.agent import AgentEndpoint
from ovman.settings.arms import ArmJob
from ovman.settings.benchmark import Remote
from ovman.settings.config import load
from ovman.settings.settings import arm_job, settings_of_arm
from ovman.shipped import user_cache

Say = Callable[[str], None]


def run_eval(options: argparse.Namespace, say: Say) -> Summary:
    """Evaluate as the options say, and return the summary. say: Told of progress, line by line.

    If an --agent is named, the working directory is on Python's path from then on.

    Raises:
        EntryError, ConfigError, RecordError, AgentError, SimulatorError: In one line.
    """
    if options.agent is not None and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    config = load(options.config)
    settings, name = select_arm(config, options.agent, options.arm, options.name, options.needs)
    release = Release(options.release, settings)
    seeds = options.seeds or settings.evaluation.seeds
    selection = select_episodes(release, options.split, options.episodes, options.scenes, seeds)
    cache = options.cache or user_cache()
    arm = arm_job(settings, name)
    try:
        code = digest_run_code(arm)
    except ModuleNotFoundError as error:
        raise AgentError(f"{arm.agent}: {error}; install it, or put it into this folder") from None
    except SyntaxError as error:
        raise AgentError(f"{error.filename}, line {error.lineno}, is not Python: {error.msg}; mend it") from None
    where = choose_place(options, arm)
    if where is Where.EVALUATOR:
        load_agent(name, arm.agent)  # an agent that cannot be loaded is told of before a tour is recorded
    out, abstains = options.out, options.failures == "abstain"
    endpoint = _endpoint(options, where, settings.remote, out)
    doing = Evaluation(arm, settings_of_arm(settings, name), seeds, where, endpoint, abstains, out, cache.absolute(), code)
    return evaluate(doing, selection, release, say, options.workers)


def run_verify(options: argparse.Namespace, say: Say) -> Verification:
    """Verify as the options say. Errors as for `verify`."""
    return verify(options.directory, Release(options.release, load(options.config)), options.episodes, say, options.workers)


def choose_place(options: argparse.Namespace, arm: ArmJob) -> Where:
    """Return where the agent runs: a user's agent in a process of its own unless it is trusted, an arm of ours if it must."""
    if options.server is not None:
        if options.in_process or options.agent is not None:
            raise EntryError("--server: its agent is where it is; leave out --agent and --in-process")
        return Where.SERVER
    if options.in_process and not runs_in_process(arm):
        raise EntryError(f"--in-process: {arm.name} needs more than tours; leave it out")
    return Where.EVALUATOR if options.in_process or (options.arm is not None and runs_in_process(arm)) else Where.PROCESS


def _endpoint(options: argparse.Namespace, where: Where, limits: Remote, out: Path) -> AgentEndpoint | None:
    if where is Where.EVALUATOR:
        return None
    if where is Where.SERVER:
        return AgentEndpoint(limits, options.server)
    arguments = ["--arm", options.arm] if options.arm is not None else ["--agent", options.agent, "--path", str(Path.cwd())]
    arguments += ["--config", str(options.config.absolute())]
    if options.name is not None:
        arguments += ["--name", options.name]
    if options.needs is not None:
        arguments += ["--needs", *options.needs]
    return AgentEndpoint(limits, arguments=("-m", "ovman.cli", "serve", *arguments), log=out / LOG)

"""The commands `ovman eval` and `ovman verify`, from their options."""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from ovman.entry import DATA, LEADERBOARD, EntryError
from ovman.entry.entrant import runs_in_process, select_arm
from ovman.entry.evaluation import Evaluation, digest_run_code, evaluate, select_episodes
from ovman.entry.manifest import LOG, Where
from ovman.entry.release import Release
from ovman.entry.summary import Summary
from ovman.entry.verification import Verification, verify
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.evaluation.tours import TOURS
from ovman.perception.weights import files_of
from ovman.remote.agent import AgentEndpoint
from ovman.remote.isolation import choose_isolation, find_packages
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.settings.benchmark import HOUSES
from ovman.settings.config import load
from ovman.settings.settings import arm_job, settings_of_arm
from ovman.shipped import user_cache

Say = Callable[[str], None]


def run_eval(options: argparse.Namespace, say: Say) -> Summary:
    """Evaluate as the options say, and return the summary. say: Told of progress, line by line.

    If an --agent runs in this process, the working directory is on Python's path from then on.

    Raises:
        EntryError, ConfigError, RecordError, AgentError, SimulatorError: In one line.
    """
    if options.in_process and options.agent is not None and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    config = load(options.config)
    settings, name = select_arm(config, options.agent, options.arm, options.name, options.needs, options.track)
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
    hidden = [out, cache / TOURS, release.directory, *filter(None, [options.episodes])]
    endpoint = _endpoint(options, where, settings, arm, hidden)
    nonce = options.nonce
    if nonce is None and (options.arm is None or where is Where.SERVER):  # an arm of config.yaml is there to be run again
        nonce = secrets.token_hex(16)
    of_arm = settings_of_arm(settings, name)
    doing = Evaluation(arm, of_arm, seeds, where, endpoint, abstains, out, cache.absolute(), code, nonce or None)
    return evaluate(doing, selection, release, say, options.workers)


def run_verify(options: argparse.Namespace, say: Say) -> Verification:
    """Verify an evaluation as the options say. Errors as for `verify`."""
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


def _endpoint(
    options: argparse.Namespace, where: Where, settings: Settings, arm: ArmJob, answers: Sequence[Path]
) -> AgentEndpoint | None:
    """Return the place of the agent. answers: Files and folders that an isolated agent may not read. EntryError, in one line."""
    if where is not Where.PROCESS and (options.isolation != "auto" or options.readable):
        raise EntryError("--isolation and --readable are for agents that `ovman eval` starts in a process; leave them out")
    if where is Where.EVALUATOR:
        return None
    limits, out = settings.remote, answers[0]
    if where is Where.SERVER:
        return AgentEndpoint(limits, options.server)
    module = arm.agent.partition(":")[0]
    arguments = ["--arm", options.arm] if options.arm is not None else ["--agent", options.agent]
    if options.name is not None:
        arguments += ["--name", options.name]
    if options.needs is not None:
        arguments += ["--needs", *options.needs]
    try:
        isolation = choose_isolation(options.isolation)
    except ValueError as error:
        raise EntryError(str(error)) from None
    hidden = tuple(path.absolute() for path in (*answers, user_cache() / TOURS, DATA, LEADERBOARD, HOUSES))
    wanted = tuple(path.absolute() for path in options.readable)
    for path in wanted:
        if not path.exists():
            raise EntryError(f"--readable: {path} does not exist; name a file or a folder")
        if near := [place for place in hidden if path.is_relative_to(place) or place.is_relative_to(path)]:
            raise EntryError(f"--readable: {path} and {near[0]}, which the agent may not read, overlap; name less")
    return AgentEndpoint(
        limits,
        arguments=("-m", "ovman.cli", "serve", *arguments),
        log=out / LOG,
        isolation=isolation,
        module=module,
        config=options.config.absolute(),
        readable=(*wanted, *files_of(settings.perception), *find_packages([module, *settings.plugins.values()])),
        hidden=hidden,
    )

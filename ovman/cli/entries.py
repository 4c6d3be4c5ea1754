"""Commands for anybody's agents: score, eval, serve, verify, merge, enter, leaderboard."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ovman.cli.failures import guard


def add(commands: Any) -> None:
    """Add the commands to those of `ovman`."""
    _add_score(commands)
    _add_eval(commands)
    commands.add_parser("serve", add_help=False, help="serve an agent for ovman eval --server")
    _add_verify(commands)
    _add_merge(commands)
    _add_enter(commands)
    _add_leaderboard(commands)


def _say(line: str) -> None:
    from ovman.faults import printable

    print(printable(line), flush=True)


def _add_release(command: Any) -> None:
    command.add_argument("--release", metavar="DIR", help="the released files; default: those of the checkout")
    command.add_argument("--config", metavar="FILE", help="default: that of the checkout")


def _add_workers(command: Any) -> None:
    command.add_argument("--workers", type=int, default=1, metavar="N", help="processes, one floor plan each; default: 1")


def _add_score(commands: Any) -> None:
    score = commands.add_parser("score", help="score a file of predicted points, next to the released arms")
    score.add_argument("predictions", metavar="FILE", help="JSON lines with `episode`, and `x` and `z` in metres, or `abstain`")
    asked = score.add_mutually_exclusive_group()
    asked.add_argument("--split", metavar="NAME", help="a split of config.yaml; default: main")
    asked.add_argument("--episodes", metavar="FILE", help="a file of episodes instead")
    score.add_argument("--partial", action="store_true", help="print rates although episodes are missing; they are not a score")
    score.add_argument("--json", action="store_true", help="the same as JSON")
    _add_release(score)
    score.set_defaults(run=guard("score", _score))


def _score(options: argparse.Namespace) -> int:
    from ovman.entry import CONFIG, DATA, score
    from ovman.entry.release import Release
    from ovman.settings import MAIN
    from ovman.settings.config import load

    settings = load(Path(options.config or CONFIG))
    released = Release(Path(options.release or DATA), settings)
    own = None if options.episodes is None else Path(options.episodes)
    found = score.score_file(Path(options.predictions), released, options.split or MAIN, own, options.partial)
    if found.is_whole or options.partial:
        print(score.as_json(found) if options.json else score.as_text(found), end="", flush=True)
    if found.is_whole:
        return 0
    print(f"ovman score: {score.complaint(found)}", file=sys.stderr)
    return 1


def _add_eval(commands: Any) -> None:
    found = commands.add_parser("eval", help="run an embodied agent on released episodes, outside the workflow")
    who = found.add_mutually_exclusive_group()
    who.add_argument("--agent", metavar="MODULE:FUNCTION", help="the factory of an agent (docs/agents.md), in its own process")
    who.add_argument("--arm", metavar="NAME", help="an embodied arm of config.yaml")
    found.add_argument("--server", metavar="URL", help="the address that the agent's server printed: ws://host:port/?token=...")
    found.add_argument("--in-process", action="store_true", help="trust the agent: run it in this process, which has the truth")
    found.add_argument("--failures", choices=("stop", "abstain"), default="stop", help="effect of a failing agent; default: stop")
    asked = found.add_mutually_exclusive_group(required=True)
    asked.add_argument("--split", metavar="NAME", help="a split of config.yaml")
    asked.add_argument("--episodes", metavar="FILE", help="a file of episodes instead")
    found.add_argument(
        "--out", required=True, metavar="DIR", help="folder of runs.jsonl, summary.md, summary.json, manifest.json"
    )
    found.add_argument("--name", metavar="NAME", help="name of the agent in its records; default: its module's last name")
    found.add_argument("--needs", nargs="*", metavar="NEED", help="inputs of an agent: tours (the default), more, or none")
    found.add_argument("--scenes", nargs="+", default=[], metavar="SCENE", help="episodes of these floor plans alone")
    found.add_argument("--seeds", nargs="+", type=int, metavar="N", help="added to those of DIR; default: evaluation.seeds")
    found.add_argument("--shard", default="1/1", metavar="K/M", help="the k-th of m parts of the episodes")
    _add_workers(found)
    found.add_argument("--cache", metavar="DIR", help="folder of recorded tours; default: the user's cache")
    _add_release(found)
    found.set_defaults(run=guard("eval", _eval, "interrupted; the same command goes on in {out}"))


def _eval(options: argparse.Namespace) -> int:
    from ovman.entry import command

    if options.agent is None and options.arm is None and options.server is None:
        print("ovman eval: name the agent: --agent MODULE:FUNCTION, --arm NAME or --server URL", file=sys.stderr)
        return 2
    print(command.run_eval(options, _say), end="", flush=True)
    return 0


def _add_verify(commands: Any) -> None:
    found = commands.add_parser("verify", help="replay the recorded actions of an evaluation and judge them again")
    found.add_argument("directory", metavar="DIR", help="output of `ovman eval`: manifest.json and runs.jsonl")
    found.add_argument("--episodes", metavar="FILE", help="the file of episodes, if they are not a released split")
    _add_workers(found)
    _add_release(found)
    found.set_defaults(run=guard("verify", _verify))


def _verify(options: argparse.Namespace) -> int:
    from ovman.entry import command

    return 0 if command.run_verify(options, _say).agrees else 1


def _add_merge(commands: Any) -> None:
    found = commands.add_parser("merge", help="merge shards of one evaluation")
    found.add_argument("out", metavar="OUT", help="the new folder")
    found.add_argument("directories", nargs="+", metavar="DIR", help="outputs of `ovman eval`, such as with --shard")
    found.add_argument("--episodes", metavar="FILE", help="the file of episodes, if they are not a released split")
    _add_release(found)
    found.set_defaults(run=guard("merge", _merge))


def _merge(options: argparse.Namespace) -> int:
    from ovman.entry import command

    print(command.run_merge(options), end="", flush=True)
    return 0


def _add_enter(commands: Any) -> None:
    found = commands.add_parser("enter", help="make an entry of the leaderboard from an evaluation or a file of points")
    found.add_argument("source", metavar="SOURCE", help="output of `ovman eval`, or the file that `ovman score` judges")
    found.add_argument("name", metavar="NAME", help="name of the entry's folder: small letters, digits, - and _")
    found.add_argument("--split", metavar="SPLIT", help="the split of a file of points")
    found.add_argument("--system", help="title in the table; with --author and --about for a new entry")
    found.add_argument("--author", action="append", default=[], help="one of its authors; again for each")
    found.add_argument("--about", help="a description in one line")
    found.add_argument("--code", metavar="URL", help="address of its code")
    found.add_argument("--role", choices=("system", "control", "diagnostic"), help="default: system")
    found.add_argument("--leaderboard", default="leaderboard", metavar="DIR", help="default: leaderboard")
    _add_release(found)
    found.set_defaults(run=guard("enter", _enter))


def _enter(options: argparse.Namespace) -> int:
    from ovman.entry import CONFIG
    from ovman.leaderboard import command
    from ovman.settings.config import load

    directory = command.enter(options)
    print(directory, flush=True)
    tested = [name for name, split in load(Path(options.config or CONFIG)).splits.items() if split.in_main_job]
    if directory.name not in tested:
        says = f"is a split for tuning. Its table on the leaderboard is separate from those of {', '.join(tested)}."
        print(f"{directory.name} {says}", file=sys.stderr)
    print(
        f"Next: commit {directory.parent} and open a pull request on the repository of OVMAN (docs/leaderboard.md)."
        " The repository has no public address yet; CITATION.cff will name it.",
        file=sys.stderr,
    )
    return 0


def _add_leaderboard(commands: Any) -> None:
    found = commands.add_parser("leaderboard", help="verify or judge all entries again, and write the tables of those that agree")
    found.add_argument("directory", nargs="?", default="leaderboard", metavar="DIR", help="default: leaderboard")
    found.add_argument("--cache", metavar="DIR", help="keep measured runs and do not run them again; the pages then say so")
    _add_workers(found)
    _add_release(found)
    found.set_defaults(run=guard("leaderboard", _leaderboard))


def _leaderboard(options: argparse.Namespace) -> int:
    from ovman.leaderboard import command

    return 0 if command.render_leaderboard(options, _say) else 1

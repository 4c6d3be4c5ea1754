"""The commands of `ovman` with their options. A command imports what it needs, of which some may not be installed."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ovman.entry import CONFIG, DATA

LEVELS = ("auto", "bubblewrap", "landlock", "none")


class Parser(argparse.ArgumentParser):
    """A parser that takes no abbreviated options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)


def add_commands(parser: Parser) -> Mapping[str, Parser]:
    """Add the commands to the parser of `ovman`, and return their parsers by name."""
    commands = parser.add_subparsers(metavar="command", parser_class=Parser)
    release, workers = Parser(add_help=False), Parser(add_help=False)
    release.add_argument("--release", default=DATA, type=Path, metavar="DIR", help="default: the released files of the checkout")
    release.add_argument("--config", default=CONFIG, type=Path, metavar="FILE", help="default: that of the checkout")
    workers.add_argument("--workers", type=int, default=1, metavar="N", help="processes, one scene each; default: 1")

    def add(
        name: str, run: Callable[[argparse.Namespace], int], says: str, *shared: Parser, interrupted: str = "interrupted"
    ) -> Parser:
        command = commands.add_parser(name, help=says, parents=shared)
        command.set_defaults(run=run, interrupted=interrupted)
        return command

    score = add("score", _score, "score a file of predicted points, next to the released arms", release)
    score.add_argument("predictions", metavar="FILE", help="JSON lines with `episode`, and `x` and `z` in metres, or `abstain`")
    asked = score.add_mutually_exclusive_group()
    asked.add_argument("--split", default="main", metavar="NAME", help="a split of config.yaml; default: main")
    asked.add_argument("--episodes", metavar="PATH", help="a file of episodes, or the folder of a draw, instead")
    score.add_argument("--partial", action="store_true", help="print rates although episodes are missing; they are not a score")
    score.add_argument("--json", action="store_true", help="the same as JSON")

    go_on = "interrupted; the same command goes on in {out}"
    says = "run an embodied agent on released episodes, outside the workflow"
    run = add("eval", _eval, says, workers, release, interrupted=go_on)
    who = run.add_mutually_exclusive_group()
    who.add_argument("--agent", metavar="MODULE:FUNCTION", help="the factory of an agent (docs/agents.md), in its own process")
    who.add_argument("--arm", metavar="NAME", help="an embodied arm of config.yaml")
    run.add_argument("--server", metavar="URL", help="the address that the agent's server printed: ws://host:port/?token=...")
    run.add_argument("--in-process", action="store_true", help="trust the agent: run it in this process, which has the truth")
    run.add_argument(
        "--isolation", choices=LEVELS, default="auto", help="of the agent's process; default: the strongest one here"
    )
    run.add_argument("--readable", nargs="+", default=[], metavar="PATH", help="what an isolated agent may read, such as weights")
    run.add_argument("--failures", choices=("stop", "abstain"), default="stop", help="effect of a failing agent; default: stop")
    asked = run.add_mutually_exclusive_group(required=True)
    asked.add_argument("--split", metavar="NAME", help="a split of config.yaml")
    asked.add_argument("--episodes", metavar="PATH", help="a file of episodes, or the folder of a draw, instead")
    run.add_argument("--out", required=True, metavar="DIR", help="folder of runs.jsonl, summary.md, summary.json, manifest.json")
    run.add_argument("--name", metavar="NAME", help="name of the agent in its records; default: its module's last name")
    run.add_argument("--needs", nargs="*", metavar="NEED", help="inputs of an agent: tours (the default), more, or none")
    run.add_argument("--scenes", nargs="+", default=[], metavar="SCENE", help="episodes of these scenes alone")
    run.add_argument("--seeds", nargs="+", type=int, metavar="N", help="added to those of DIR; default: evaluation.seeds")
    run.add_argument("--cache", metavar="DIR", help="folder of recorded tours; default: the user's cache")
    run.add_argument("--nonce", metavar="TEXT", help="that of an evaluation to repeat, or empty for none; default: drawn")

    commands.add_parser("serve", add_help=False, help="serve an agent for ovman eval --server")

    says = "replay the recorded actions of an evaluation and judge them again, or draw a draw again"
    verify = add("verify", _verify, says, workers, release)
    verify.add_argument("directory", type=Path, metavar="DIR", help="output of `ovman eval` or of `ovman draw`")
    verify.add_argument(
        "--episodes", metavar="PATH", help="the file of episodes, or their draw, if they are not a released split"
    )

    says = "draw fresh homes and certified episodes of a split from a seed"
    draw = add("draw", _draw, says, workers, interrupted=go_on)
    seed = draw.add_mutually_exclusive_group(required=True)
    seed.add_argument("--seed", metavar="TEXT", help="any text; other seeds give other homes")
    seed.add_argument("--beacon", type=Path, metavar="FILE", help="the seed is a value of drand: its answer for a round, as JSON")
    seed.add_argument("--reveal", type=Path, metavar="FILE", help="the seed was committed: secret.json of `ovman commit`")
    draw.add_argument("--split", metavar="NAME", help="a split of config.yaml that has homes; a commitment names it already")
    draw.add_argument("--homes", type=int, metavar="N", help="number of homes; a commitment names it already")
    draw.add_argument("--out", required=True, type=Path, metavar="DIR", help="a new folder for episodes, scenes and manifest")
    draw.add_argument("--config", default=CONFIG, type=Path, metavar="FILE", help="default: that of the checkout")

    says = "commit to what is told later: the seed of a draw, or the code of an entry"
    commit = add("commit", _commit, says)
    commit.add_argument("entry", nargs="?", type=Path, metavar="ENTRY", help="folder of an entry of the leaderboard")
    commit.add_argument(
        "--files", nargs="+", default=[], type=Path, metavar="PATH", help="files of ENTRY's agent, such as weights"
    )
    commit.add_argument("--split", metavar="NAME", help="of a draw: a split of config.yaml that has homes")
    commit.add_argument("--homes", type=int, metavar="N", help="of a draw: number of homes")
    commit.add_argument("--closes", metavar="TIME", help="of a draw: entries may be committed until 2026-12-24T12:00:00Z")
    commit.add_argument("--seed", metavar="TEXT", help="of a draw; default: a random one")
    commit.add_argument("--out", type=Path, metavar="DIR", help="of a draw: a new folder for commitment.json and secret.json")
    commit.add_argument("--config", default=CONFIG, type=Path, metavar="FILE", help="default: that of the checkout")

    enter = add("enter", _enter, "make an entry of the leaderboard from an evaluation or a file of points", release)
    enter.add_argument("source", type=Path, metavar="SOURCE", help="output of `ovman eval`, or a file of points")
    enter.add_argument("name", metavar="NAME", help="name of the entry's folder: small letters, digits, - and _")
    enter.add_argument("--split", metavar="SPLIT", help="the split of a file of points")
    enter.add_argument("--system", help="title in the table; with --author and --about for a new entry")
    enter.add_argument(
        "--author", dest="authors", action="append", default=[], metavar="NAME", help="one of its authors; again for each"
    )
    enter.add_argument("--about", help="a description in one line")
    enter.add_argument("--code", metavar="URL", help="address of its code")
    enter.add_argument("--role", choices=("system", "control", "diagnostic"), default="system", help="default: system")
    enter.add_argument("--leaderboard", default="leaderboard", type=Path, metavar="DIR", help="default: leaderboard")

    says = "verify or judge all entries again, and write the tables of those that agree"
    board = add("leaderboard", _leaderboard, says, workers, release)
    board.add_argument("directory", nargs="?", default="leaderboard", type=Path, metavar="DIR", help="default: leaderboard")
    board.add_argument(
        "--draw",
        dest="draws",
        action="append",
        default=[],
        type=Path,
        metavar="DIR",
        help="a fresh draw that ranks; again for each",
    )
    board.add_argument("--cache", type=Path, metavar="DIR", help="keep replays and do not repeat them; the pages then say so")

    doctor = add("doctor", _doctor, "what works on this machine, and what to do about what does not")
    doctor.add_argument("--thor", action="store_true", help="look at Vulkan and AI2-THOR's Unity build, too")

    show = add("show", _show, "a page about an episode: both tours, the maps, every arm's answer and verdict, your own runs")
    show.add_argument("episodes", nargs="*", metavar="EPISODE", help="an id, or a pattern such as 'FloorPlan201/*'")
    show.add_argument("--all", action="store_true", help="every released episode")
    show.add_argument("--results", metavar="DIR", help="default: results, or where there are none the release")
    show.add_argument("--output", metavar="PATH", help="a file for one episode, a directory for many; default: DIR/pages")
    show.add_argument("--config", metavar="FILE", help="default: config.yaml, or where there is none the release's")
    show.add_argument("--runs", nargs="+", default=[], metavar="DIR", help="folders of ovman eval, whose runs are shown as well")

    kept = "interrupted; tours that are recorded are kept"
    says = "the release as a data set in Parquet, with its tours, card and Croissant"
    dataset = add("dataset", _dataset, says, release, interrupted=kept)
    dataset.add_argument("--out", required=True, type=Path, metavar="DIR", help="the folder of the data set")
    dataset.add_argument("--split", nargs="+", metavar="NAME", help="splits of config.yaml; default: all that the release has")
    dataset.add_argument("--without-tours", action="store_true", help="records alone, and no simulator is started")
    dataset.add_argument("--visits", metavar="DIR", help="recorded tours of the workflow, results/visits; others are recorded")
    dataset.add_argument("--cache", metavar="DIR", help="where tours are recorded; default: the user's cache")

    says = "draw homes from a seed, with a table of what is in them and a sheet of pictures"
    homes = add("homes", _homes, says)
    homes.add_argument("--seed", type=int, default=0, metavar="N", help="other seeds give other homes; default: 0")
    homes.add_argument("--count", type=int, default=1, metavar="N", help="number of homes; default: 1")
    homes.add_argument("--rooms", default="1", metavar="N,...", help="numbers of rooms in turn, such as 1,2; default: 1")
    homes.add_argument("--assets", choices=("train", "val", "test"), default="train", help="whose furniture; default: train")
    homes.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder of the homes, index.csv and homes.png")
    homes.add_argument("--without-pictures", action="store_true", help="write no homes.png")

    return commands.choices


def _say(line: str) -> None:
    from ovman.faults import printable

    print(printable(line), flush=True)


def _score(options: argparse.Namespace) -> int:
    from ovman.entry import score
    from ovman.entry.release import Release
    from ovman.settings.config import load

    released = Release(options.release, load(options.config))
    own = None if options.episodes is None else Path(options.episodes)
    found = score.score_file(Path(options.predictions), released, options.split, own, options.partial)
    if found.is_whole or options.partial:
        print(score.as_json(found) if options.json else score.as_text(found), end="", flush=True)
    if found.is_whole:
        return 0
    print(f"ovman score: {score.complaint(found)}", file=sys.stderr)
    return 1


def _homes(options: argparse.Namespace) -> int:
    from ovman.homes import command

    command.run(options.seed, options.count, options.rooms, options.assets, options.out, not options.without_pictures, _say)
    return 0


def _eval(options: argparse.Namespace) -> int:
    from ovman.entry import command

    if options.agent is None and options.arm is None and options.server is None:
        print("ovman eval: name the agent: --agent MODULE:FUNCTION, --arm NAME or --server URL", file=sys.stderr)
        return 2
    print(command.run_eval(options, _say), end="", flush=True)
    return 0


def _verify(options: argparse.Namespace) -> int:
    from ovman.draws.folder import holds_draw
    from ovman.entry import command

    if holds_draw(options.directory):
        from ovman.draws import making
        from ovman.settings.config import load

        differing = making.redraw(options.directory, load(options.config), _say, options.workers)
        _say("\n".join(differing) if differing else f"{options.directory}: the seed gives the same files here")
        return 1 if differing else 0
    return 0 if command.run_verify(options, _say).agrees else 1


def _draw(options: argparse.Namespace) -> int:
    from ovman.draws import making, origin
    from ovman.settings.config import load

    given, settings = options.split is not None and options.homes is not None, load(options.config)
    if options.reveal is not None:
        if options.split is not None or options.homes is not None:
            print("ovman draw: --reveal names split and homes; leave out --split and --homes", file=sys.stderr)
            return 2
        secret = origin.read_secret(options.reveal)
        making.make(settings, secret.split, str(secret.seed), secret.homes, options.out, _say, options.workers, commitment=secret)
        return 0
    if not given:
        print("ovman draw: say what to draw, with --split NAME and --homes N", file=sys.stderr)
        return 2
    beacon = None if options.beacon is None else origin.read_beacon(options.beacon)
    seed = options.seed if beacon is None else beacon.seed
    making.make(settings, options.split, seed, options.homes, options.out, _say, options.workers, beacon=beacon)
    return 0


def _commit(options: argparse.Namespace) -> int:
    terms = {f"--{name}": getattr(options, name) for name in ("split", "homes", "closes", "out")}
    if options.entry is not None:
        from ovman.leaderboard import commitment

        if given := [name for name, value in {**terms, "--seed": options.seed}.items() if value is not None]:
            print(f"ovman commit: {given[0]} is of a draw; leave it out, or leave out ENTRY", file=sys.stderr)
            return 2
        print(commitment.commit_entry(options.entry, options.files), flush=True)
        return 0
    if missing := [name for name, value in terms.items() if value is None]:
        print(f"ovman commit: name the folder of an entry, or give {', '.join(missing)} of a draw", file=sys.stderr)
        return 2
    from ovman.draws import making, origin
    from ovman.settings.config import load

    making.settings_of_draw(load(options.config), options.split, "", options.homes)  # refuses what cannot be drawn
    origin.commit(options.split, options.homes, options.closes, options.out, options.seed)
    print(f"{options.out / origin.PUBLIC}: publish it now", flush=True)
    print(f"{options.out / origin.SECRET}: keep it secret until {options.closes}", flush=True)
    return 0


def _enter(options: argparse.Namespace) -> int:
    from ovman.leaderboard import command
    from ovman.settings.config import load

    directory = command.enter(options)
    print(directory, flush=True)
    tested = [name for name, split in load(options.config).splits.items() if split.in_main_job]
    if directory.name not in tested:
        says = f"is a split for tuning. Its table on the leaderboard is separate from those of {', '.join(tested)}."
        print(f"{directory.name} {says}", file=sys.stderr)
    print(
        f"Next: commit {directory.parent} and open a pull request on the repository of OVMAN (docs/leaderboard.md)."
        " The repository has no public address yet; CITATION.cff will name it.",
        file=sys.stderr,
    )
    return 0


def _leaderboard(options: argparse.Namespace) -> int:
    from ovman.leaderboard import command

    return 0 if command.render_leaderboard(options, _say) else 1


def _doctor(options: argparse.Namespace) -> int:
    from ovman.doctor.checks import State, format_finding, run_checks

    well = True
    for found in run_checks(options.thor):
        print(format_finding(found), flush=True)
        well &= found.state is not State.ILL
    return 0 if well else 1


def _show(options: argparse.Namespace) -> int:
    from ovman.playback import show

    for path in show(options, lambda line: print(line, file=sys.stderr, flush=True)):
        print(path, flush=True)
    return 0


def _dataset(options: argparse.Namespace) -> int:
    from ovman.dataset import making

    making.run(options, lambda line: print(line, flush=True))
    return 0

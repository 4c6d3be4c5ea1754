"""The command `ovman`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ovman import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0 if all is well, 1 if something that was asked for is not, 2 for a wrong command."""
    parser = argparse.ArgumentParser(prog="ovman", description="Open-vocabulary motion-aware navigation.")
    parser.add_argument("--version", action="version", version=f"ovman {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    doctor = commands.add_parser("doctor", help="what works on this machine, and what to do about what does not")
    doctor.add_argument("--thor", action="store_true", help="look at Vulkan and AI2-THOR's Unity build, too")
    check = commands.add_parser("check", help="what in results/ is missing, torn or stale, and the command that makes it again")
    check.add_argument("results", nargs="?", default="results", metavar="DIR", help="default: results")
    check.add_argument("--config", default="config.yaml", metavar="FILE", help="default: config.yaml")
    check.add_argument("--configfile", nargs="+", default=[], metavar="OVERLAY", help="overlays that the results were made with")
    show = commands.add_parser("show", help="a page about an episode: both tours, the maps, every arm's answer and verdict")
    show.add_argument("episodes", nargs="*", metavar="EPISODE", help="an id, or a pattern such as 'FloorPlan201/*'")
    show.add_argument("--all", action="store_true", help="every released episode")
    show.add_argument("--results", default="results", metavar="DIR", help="default: results")
    show.add_argument("--output", metavar="PATH", help="a file for one episode, a directory for many; default: DIR/pages")
    show.add_argument("--config", default="config.yaml", metavar="FILE", help="default: config.yaml")
    record = commands.add_parser(
        "record", help="a piece of OVMAN's work on a floor plan, as a file of all that a simulator answered"
    )
    record.add_argument("scene", metavar="SCENE", help="a floor plan, such as FloorPlan201")
    record.add_argument("--thor", action="store_true", help="on AI2-THOR's Unity build; default: on the embedded engine")
    record.add_argument("--output", default="session.jsonl.gz", metavar="FILE", help="default: session.jsonl.gz")
    record.add_argument("--config", default="config.yaml", metavar="FILE", help="default: config.yaml")
    replay = commands.add_parser(
        "replay", help="a recording done again without a simulator, and asked again of the embedded engine"
    )
    replay.add_argument("recording", metavar="FILE", help="what `ovman record` wrote")
    replay.add_argument("--thor", action="store_true", help="asked of AI2-THOR's Unity build instead")
    _add_score(commands)
    _add_eval(commands)
    _add_dataset(commands)
    commands.add_parser("serve", add_help=False, help="the server of an agent, for ovman eval --server")
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["serve"]:  # its own parser says what is served: the module that has it loads the networks' side
        from ovman.entry.serve import main as serve

        return serve(given[1:])
    options = parser.parse_args(given)
    if options.command == "doctor":
        return _doctor(options.thor)
    if options.command == "score":
        return _score(options)
    if options.command == "eval":
        return _eval(options)
    if options.command == "dataset":
        return _dataset(options)
    if options.command == "check":
        return _check(options)
    return _show(options) if options.command == "show" else _session(options)


def _add_score(commands: Any) -> None:
    score = commands.add_parser("score", help="the static gate of a file of predicted points, beside the released arms")
    score.add_argument("predictions", metavar="FILE", help="JSON lines with `episode`, and `x` and `z` in metres, or `abstain`")
    asked = score.add_mutually_exclusive_group()
    asked.add_argument("--split", metavar="NAME", help="a split of config.yaml; default: the benchmark's own")
    asked.add_argument("--episodes", metavar="FILE", help="a file of episodes instead")
    score.add_argument("--partial", action="store_true", help="rates where episodes are missing, too; they are no score")
    score.add_argument("--json", action="store_true", help="the same as JSON")
    score.add_argument("--release", metavar="DIR", help="the released files; default: those of the checkout")
    score.add_argument("--config", metavar="FILE", help="default: that of the checkout")


def _score(options: argparse.Namespace) -> int:
    from ovman.entry import release, score, score_page
    from ovman.models.settings import MAIN
    from ovman.workflow.config import load

    try:
        settings = load(Path(options.config or release.CONFIG))
        released = release.Release(Path(options.release or release.DATA), settings)
        own = None if options.episodes is None else Path(options.episodes)
        found = score.score_file(Path(options.predictions), released, options.split or MAIN, own, options.partial)
    except (ValueError, OSError) as error:
        print(f"ovman score: {error}", file=sys.stderr)
        return 1
    if found.whole or options.partial:
        print(score_page.as_json(found) if options.json else score_page.as_text(found), end="", flush=True)
    if found.whole:
        return 0
    print(f"ovman score: {score_page.complaint(found)}", file=sys.stderr)
    return 1


def _add_eval(commands: Any) -> None:
    found = commands.add_parser("eval", help="an embodied agent on released episodes, outside the workflow")
    who = found.add_mutually_exclusive_group()
    who.add_argument(
        "--agent", metavar="MODULE:FUNCTION", help="what makes the agent (docs/agents.md); it has a process of its own"
    )
    who.add_argument("--arm", metavar="NAME", help="an embodied arm of config.yaml")
    found.add_argument("--server", metavar="URL", help="ws://host:port of a server that has the agent, or the arm")
    found.add_argument(
        "--in-process", action="store_true", help="the agent is trusted: it runs in this process, beside the truth"
    )
    found.add_argument(
        "--failures", choices=("stop", "abstain"), default="stop", help="what a run in which the agent fails does; default: stop"
    )
    asked = found.add_mutually_exclusive_group(required=True)
    asked.add_argument("--split", metavar="NAME", help="a split of config.yaml")
    asked.add_argument("--episodes", metavar="FILE", help="a file of episodes instead")
    found.add_argument(
        "--out", required=True, metavar="DIR", help="runs.jsonl, summary.md, summary.json and manifest.json go there"
    )
    found.add_argument("--name", metavar="NAME", help="what the agent is called in its records; default: its module's last name")
    found.add_argument("--needs", nargs="*", metavar="NEED", help="of an agent: tours (the default), more, or nothing")
    found.add_argument("--scenes", nargs="+", default=[], metavar="SCENE", help="episodes of these floor plans alone")
    found.add_argument("--seeds", nargs="+", type=int, metavar="N", help="default: evaluation.seeds of config.yaml")
    found.add_argument("--shard", default="1/1", metavar="K/M", help="the k-th of m parts of the episodes")
    found.add_argument("--cache", metavar="DIR", help="where recorded tours are kept; default: the user's cache")
    found.add_argument("--release", metavar="DIR", help="the released files; default: those of the checkout")
    found.add_argument("--config", metavar="FILE", help="default: that of the checkout")


def _eval(options: argparse.Namespace) -> int:
    if options.agent is None and options.arm is None and options.server is None:
        print("ovman eval: name who is evaluated: --agent MODULE:FUNCTION, --arm NAME or --server URL", file=sys.stderr)
        return 2
    try:
        from ovman.entry import command
        from ovman.evaluation.supervision import AgentError
        from ovman.sim.session import SimulatorDied, SimulatorError
    except ModuleNotFoundError as missing:
        print(f"ovman eval: {missing.name} is not installed; pip install 'ovman[benchmark]' brings it", file=sys.stderr)
        return 1
    try:
        print(command.run(options, lambda line: print(line, flush=True)), end="", flush=True)
    except (ValueError, OSError, AgentError, SimulatorDied, SimulatorError) as error:
        print(f"ovman eval: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"ovman eval: interrupted; the same command goes on in {options.out}", file=sys.stderr)
        return 130
    return 0


def _add_dataset(commands: Any) -> None:
    found = commands.add_parser(
        "dataset", help="the release as a data set in Parquet, with its tours, card, Croissant and Zenodo"
    )
    found.add_argument("--out", required=True, metavar="DIR", help="the folder of the data set")
    found.add_argument("--split", nargs="+", metavar="NAME", help="splits of config.yaml; default: all that the release has")
    found.add_argument("--without-tours", action="store_true", help="records alone, and no simulator is started")
    found.add_argument("--visits", metavar="DIR", help="recorded tours of the workflow, results/visits; others are recorded")
    found.add_argument("--cache", metavar="DIR", help="where tours are recorded; default: the user's cache")
    found.add_argument("--url", metavar="URL", help="the page that the data set is published at")
    found.add_argument("--date", metavar="YYYY-MM-DD", help="the day of its publication; default: that of CITATION.cff")
    found.add_argument("--verify", action="store_true", help="compare the files of DIR with its card and write nothing")
    found.add_argument("--release", metavar="DIR", help="the released files; default: those of the checkout")
    found.add_argument("--config", metavar="FILE", help="default: that of the checkout")


def _dataset(options: argparse.Namespace) -> int:
    try:
        from ovman.dataset import command
        from ovman.sim.session import SimulatorDied, SimulatorError
    except ModuleNotFoundError as missing:
        extra = "dataset" if missing.name == "pyarrow" else "benchmark"
        print(f"ovman dataset: {missing.name} is not installed; pip install 'ovman[{extra}]' brings it", file=sys.stderr)
        return 1
    try:
        wrong = command.run(options, lambda line: print(line, flush=True))
    except (ValueError, OSError, SimulatorDied, SimulatorError) as error:
        print(f"ovman dataset: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("ovman dataset: interrupted; tours that are recorded are kept", file=sys.stderr)
        return 130
    for line in wrong:
        print(f"ovman dataset: {line}", file=sys.stderr)
    return 1 if wrong else 0


def _doctor(thor: bool) -> int:
    from ovman.doctor.checks import State, findings, report

    well = True
    for found in findings(thor):
        print(report([found]), flush=True)
        well &= found.state is not State.ILL
    return 0 if well else 1


def _check(options: argparse.Namespace) -> int:
    from ovman.doctor.results import Results, check
    from ovman.workflow.config import ConfigError, load_files

    try:
        settings = load_files([options.config, *options.configfile])
    except ConfigError as error:
        print(f"ovman check: {error}", file=sys.stderr)
        return 1
    results = Path(options.results).absolute()
    if results.name != "results":
        print(f"ovman check: {options.results} is not called results; give the folder that the workflow wrote", file=sys.stderr)
        return 1
    faults = 0
    for line in check(Results(results.parent, settings)):
        print(line, flush=True)
        faults += 1
    print(f"{options.results}: {faults} faults" if faults else f"{options.results}: whole", flush=True)
    return 1 if faults else 0


def _show(options: argparse.Namespace) -> int:
    try:
        from ovman.report.show.command import show
    except ModuleNotFoundError as missing:
        print(f"ovman show: {missing.name} is not installed; pip install 'ovman[benchmark]' brings it", file=sys.stderr)
        return 1
    try:
        for path in show(options.episodes, options.all, options.results, options.output, options.config):
            print(path, flush=True)
    except (ValueError, OSError) as error:
        print(f"ovman show: {error}", file=sys.stderr)
        return 1
    return 0


def _session(options: argparse.Namespace) -> int:
    well = True
    try:
        from ovman.doctor import recording
        from ovman.sim.session import SimulatorDied, SimulatorError
    except ModuleNotFoundError as missing:
        print(
            f"ovman {options.command}: {missing.name} is not installed; pip install 'ovman[benchmark]' brings it", file=sys.stderr
        )
        return 1
    try:
        if options.command == "record":
            print(recording.record(options.scene, Path(options.output), options.thor, Path(options.config)))
        else:
            well, lines = recording.replay(Path(options.recording), options.thor)
            print("\n".join(lines))
    except (ValueError, OSError, SimulatorDied, SimulatorError) as error:
        print(f"ovman {options.command}: {error}", file=sys.stderr)
        return 1
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())

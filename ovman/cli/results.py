"""Commands on this machine and on results: doctor, show, dataset."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from typing import Any

from ovman.cli.failures import said


def add(commands: Any) -> None:
    """Add the commands to those of `ovman`."""
    doctor = commands.add_parser("doctor", help="what works on this machine, and what to do about what does not")
    doctor.add_argument("--thor", action="store_true", help="look at Vulkan and AI2-THOR's Unity build, too")
    doctor.set_defaults(run=_doctor)
    show = commands.add_parser(
        "show", help="a page about an episode: both tours, the maps, every arm's answer and verdict, your own runs"
    )
    show.add_argument("episodes", nargs="*", metavar="EPISODE", help="an id, or a pattern such as 'FloorPlan201/*'")
    show.add_argument("--all", action="store_true", help="every released episode")
    show.add_argument("--results", metavar="DIR", help="default: results, or where there are none the release")
    show.add_argument("--output", metavar="PATH", help="a file for one episode, a directory for many; default: DIR/pages")
    show.add_argument("--config", metavar="FILE", help="default: config.yaml, or where there is none the release's")
    show.add_argument(
        "--runs", nargs="+", default=[], metavar="DIR", help="folders of ovman eval, whose paths and verdicts are shown as well"
    )
    show.set_defaults(run=_show)
    dataset = commands.add_parser(
        "dataset", help="the release as a data set in Parquet, with its tours, card, Croissant and Zenodo"
    )
    dataset.add_argument("--out", required=True, metavar="DIR", help="the folder of the data set")
    dataset.add_argument("--split", nargs="+", metavar="NAME", help="splits of config.yaml; default: all that the release has")
    dataset.add_argument("--without-tours", action="store_true", help="records alone, and no simulator is started")
    dataset.add_argument("--visits", metavar="DIR", help="recorded tours of the workflow, results/visits; others are recorded")
    dataset.add_argument("--cache", metavar="DIR", help="where tours are recorded; default: the user's cache")
    dataset.add_argument("--url", metavar="URL", help="the page that the data set is published at")
    dataset.add_argument("--date", metavar="YYYY-MM-DD", help="the day of its publication; default: that of CITATION.cff")
    dataset.add_argument("--release", metavar="DIR", help="the released files; default: those of the checkout")
    dataset.add_argument("--config", metavar="FILE", help="default: that of the checkout")
    dataset.set_defaults(run=_dataset)


def _doctor(options: argparse.Namespace) -> int:
    from ovman.doctor.checks import State, format_findings, run_checks
    from ovman_engine import kernels

    with suppress(ImportError):  # numba may be missing; a check says so
        if not kernels.ready():
            print("compiling the engine's kernels: about one minute, once", flush=True)
    well = True
    for found in run_checks(options.thor):
        print(format_findings([found]), flush=True)
        well &= found.state is not State.ILL
    return 0 if well else 1


def _show(options: argparse.Namespace) -> int:
    def say(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    def work() -> int:
        from ovman.playback import show

        where = options.results, options.output, options.config, options.runs, say
        for path in show(options.episodes, options.all, *where):
            print(path, flush=True)
        return 0

    return said("show", work)


def _dataset(options: argparse.Namespace) -> int:
    def work() -> int:
        from ovman.dataset import making

        making.run(options, lambda line: print(line, flush=True))
        return 0

    return said("dataset", work, "interrupted; tours that are recorded are kept")

"""`ovman demo`: a home that nobody has seen, changes in it, and two agents that are asked about them."""

from __future__ import annotations

import os
import shutil
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ovman import playback
from ovman.draws import DrawError, making
from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.command import run_eval
from ovman.entry.manifest import read_runs, runs_path
from ovman.processes import Step, map_items
from ovman.records.draw import EPISODES
from ovman.records.episode import Episode
from ovman.settings import Settings
from ovman.settings.config import load

AGENTS = ("two_visits_embodied", "joint_embodied")
"""The reference agent and the joint agent."""
SPLIT, TRIES = "everyday", 5
QUICK = {f"splits.{SPLIT}.crossed.queries": (4, 6), "admissibility.runs": 1}
"""Constants of a draw that takes seconds: few queries, each certified by one run of the oracle."""
DRAW, PAGE = "draw", "page.html"
STEPS = 8
"""Six lines of a draw, the agents, and the page."""
Say = Callable[[str], None]


def run_demo(seed: int, is_new: bool, out: Path, say: Say) -> list[dict[str, Any]]:
    """Draw a home and its queries, run the agents, and write a page about a query into `out`; return one row per run.

    is_new: Whether the seed is so new that nobody can have seen the home. say: Told of each step.

    Raises:
        EntryError: `out` holds something, or no home of the seed has a certified episode.
        AgentError, SimulatorError: In one line.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise EntryError(f"--out: {out} holds something already; name a new folder")
    settings, rows = load(CONFIG), list[dict[str, Any]]()
    with TemporaryDirectory(prefix="ovman-demo-") as folder:
        temporary = Path(folder)
        draw_home(settings.with_values(QUICK), seed, out, say)
        say(Step(STEPS - 2, STEPS, "two agents tour the home twice, hear the questions and go"))
        map_items(partial(_run_agent, out, temporary / "tours"), AGENTS, len(AGENTS))
        runs = {arm: {run.episode: run for _, run in read_runs(runs_path(out / arm))} for arm in AGENTS}
        episodes = Episode.load(out / DRAW / EPISODES)
        for episode in episodes:
            for arm in AGENTS:
                run = runs[arm][episode.id]
                rows.append(
                    {
                        "question": episode.sentence,
                        "agent": settings.arms[arm].system,
                        "result": "success" if run.success else "failure",
                        "metres to the answer": "—" if run.answer_distance_m is None else run.answer_distance_m,
                        "metres walked": run.path_length_m,
                        "actions": run.actions,
                    }
                )
        # A question that one agent alone answers rightly shows most.
        shown = max(episodes, key=lambda one: len({runs[arm][one.id].success for arm in AGENTS}))
        says = f"ovman demo drew this home from seed {seed}"
        note = (
            f"Nobody has seen this home before: {says} just now." if is_new else f"{says}. No agent was trained or tuned in it."
        )
        say(Step(STEPS - 1, STEPS, "the page"))
        named: dict[str, Any] = {"config": CONFIG, "results": out / DRAW, "all": False, "output": out / PAGE}
        page = Namespace(episodes=[shown.id], runs=[str(out / arm) for arm in AGENTS], **named)
        pages = list(playback.show(page, _ignore, temporary / "tours", note))
    say(Step(STEPS, STEPS, str(pages[0])))
    return rows


def draw_home(settings: Settings, seed: int, out: Path, say: Say) -> None:
    """Draw a home like `ovman draw`, and others until one has certified episodes. EntryError if none has any."""
    for k in range(TRIES):
        with suppress(DrawError), _tell_stages(say) as tell:  # nothing in this home was certified
            making.make(settings, SPLIT, f"{seed}.{k}" if k else str(seed), 1, out / DRAW, tell)
            return
    shutil.rmtree(out)
    raise EntryError(f"--seed: none of {TRIES} homes has a certified episode; write another seed than {seed}")


def _run_agent(out: Path, cache: Path, arm: str) -> None:
    """Evaluate an agent on the draw like `ovman eval`."""
    names = ("agent", "server", "split", "name", "needs", "nonce", "in_process", "track")
    given = {"arm": arm, "episodes": out / DRAW, "out": out / arm, "cache": cache, "seeds": (0,), "scenes": (), "workers": 1}
    how: dict[str, Any] = {"isolation": "auto", "readable": (), "failures": "stop", "release": DATA, "config": CONFIG}
    run_eval(Namespace(**dict.fromkeys(names), **given, **how), _ignore)


@contextmanager
def _tell_stages(say: Say) -> Iterator[Say]:
    """Yield a function that tells the stages of a draw as steps; discard the lines that the stages print."""
    shown, steps = sys.stdout, count()

    def tell(line: str) -> None:
        with redirect_stdout(shown):
            say(Step(next(steps), STEPS, line))

    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        yield tell


def _ignore(line: str) -> None:
    """Say nothing."""

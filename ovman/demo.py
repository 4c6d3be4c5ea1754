"""`ovman demo`: a home that nobody has seen, a change in it, and two agents that look for the change."""

from __future__ import annotations

import os
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ovman import playback
from ovman.cache import Cache
from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.command import run_eval
from ovman.entry.manifest import read_runs, runs_path
from ovman.generation import candidates, certification, release, scenes, trials, verdict
from ovman.processes import Step, map_items
from ovman.records.episode import Episode
from ovman.settings import Settings
from ovman.settings.config import load
from ovman.settings.splits import Homes, Split

AGENTS = ("two_visits_embodied", "joint_embodied")
"""The reference agent and the joint agent."""
RELATIONS = ("moved", "removed", "former", "appeared")
"""Changes that a demo draws; the seed chooses the first that is tried."""
SPLIT, LIKE = "demo", "everyday"
PAGE = "page.html"
HOMES, DRAWS = 5, 2
STEPS = 5
Say = Callable[[str], None]


def run_demo(seed: int, is_new: bool, out: Path, say: Say) -> list[dict[str, Any]]:
    """Draw a home and an episode, run the agents, and write a page about them into `out`; return one row per run.

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
        episodes = draw_episodes(settings, seed, out, temporary, say)
        by_id = {episode.id: episode for episode in Episode.load(episodes)}
        say(Step(3, STEPS, "two agents tour the home twice, hear the question and go"))
        map_items(partial(_run_agent, episodes, out, temporary / "tours"), AGENTS, len(AGENTS))
        for arm in AGENTS:
            for _, run in read_runs(runs_path(out / arm)):
                rows.append(
                    {
                        "question": by_id[run.episode].sentence,
                        "agent": settings.arms[arm].system,
                        "result": "success" if run.success else "failure",
                        "metres to the answer": "—" if run.answer_distance_m is None else run.answer_distance_m,
                        "metres walked": run.path_length_m,
                        "actions": run.actions,
                    }
                )
        says = f"ovman demo drew this home from seed {seed}"
        note = (
            f"Nobody has seen this home before: {says} just now." if is_new else f"{says}. No agent was trained or tuned in it."
        )
        say(Step(STEPS - 1, STEPS, "the page"))
        page = Namespace(
            config=CONFIG, results=out, episodes=[*by_id], all=False, output=out / PAGE, runs=[str(out / arm) for arm in AGENTS]
        )
        pages = list(playback.show(page, _ignore, temporary / "tours", note))
    say(Step(STEPS, STEPS, str(pages[0])))
    return rows


def draw_episodes(settings: Settings, seed: int, out: Path, temporary: Path, say: Say) -> Path:
    """Draw homes of a seed until one has a certified episode; return its file of episodes.

    The files are those that `Results` reads. EntryError if no home has one.
    """
    made = {name: out / name / f"{SPLIT}.jsonl" for name in ("episodes", "scenes")}
    files = {name: temporary / f"{name}.jsonl" for name in ("candidates", "trials", "admissible", "certified", "sightings")}
    for path in made.values():
        path.parent.mkdir(parents=True, exist_ok=True)
    cache, first = Cache(temporary / "items"), seed % len(RELATIONS)
    relations: tuple[str, ...] = (*RELATIONS[first:], *RELATIONS[:first])
    for k in range(HOMES):
        homes = Homes(seed=seed + k, count=1, rooms=(1,), assets="test")
        say(Step(0, STEPS, "a home from the seed"))
        with _without_progress():
            (name,) = scenes.draw_homes(homes)
            scenes.run([name], settings, made["scenes"], cache)
        for relation in relations:
            own = _settings_of(settings, homes, relation)
            say(Step(1, STEPS, f"a change in {name}: {relation}"))
            with _without_progress():
                candidates.run(SPLIT, made["scenes"], own, files["candidates"])
                trials.run(made["scenes"], files["candidates"], own, files["trials"], cache)
                verdict.run(files["trials"], own, files["admissible"])
            say(Step(2, STEPS, "an oracle solves it"))
            with _without_progress():
                certification.run(files["admissible"], files["trials"], own, files["certified"], cache)
                given = files["trials"], files["admissible"], files["certified"]
                release.run(*given, own, made["episodes"], files["sightings"], temporary / "rejections.csv", SPLIT)
            if made["episodes"].stat().st_size:
                return made["episodes"]
    raise EntryError(f"--seed: none of {HOMES} homes has a certified episode; write another seed than {seed}")


def _settings_of(settings: Settings, homes: Homes, relation: str) -> Settings:
    """Return the settings of a split like everyday's in one home, with one episode of a relation."""
    none = dict.fromkeys(type(settings.splits[LIKE].draws).model_fields, 0)
    entry = settings.splits[LIKE].model_dump(mode="json") | {
        "name": SPLIT,
        "scenes": (),
        "homes": homes.model_dump(mode="json"),
        "draws": none | {relation: DRAWS},
        "episodes": none | {relation: 1},
    }
    return settings.model_copy(
        update={
            "splits": {**settings.splits, SPLIT: Split.model_validate(entry)},
            "benchmark": settings.benchmark.model_copy(update={"allow_short_split": True}),
            "admissibility": settings.admissibility.model_copy(update={"runs": 1}),
        }
    )


def _run_agent(episodes: Path, out: Path, cache: Path, arm: str) -> None:
    """Evaluate an agent on the episodes like `ovman eval`."""
    names = ("agent", "server", "split", "name", "needs", "in_process")
    given = {"arm": arm, "episodes": episodes, "out": out / arm, "cache": cache, "seeds": (0,), "scenes": (), "workers": 1}
    run_eval(Namespace(**dict.fromkeys(names), **given, failures="stop", release=DATA, config=CONFIG), _ignore)


@contextmanager
def _without_progress() -> Iterator[None]:
    """Discard the lines that the stages of the workflow print."""
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        yield


def _ignore(line: str) -> None:
    """Say nothing."""

"""The command `ovman show`: pages about episodes."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from functools import cache as cache_result
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ovman.agents.interface import VISITS, Action
from ovman.atomic import replace_bytes
from ovman.cache import Cache
from ovman.entry.manifest import read_manifest, read_runs, runs_path
from ovman.entry.verification import replay_job
from ovman.evaluation.tours import TourCache
from ovman.perception.detections import detect_tours, load_networks
from ovman.perception.maps import build_map
from ovman.provenance import digest_code
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.visit import tour_path
from ovman.report.show.answers import Entry, describe_run
from ovman.report.show.evidence import read_evidence
from ovman.report.show.page import render_page
from ovman.report.show.results import Results, ShowError
from ovman.runner import ACTIONS, Run, open_env, open_session
from ovman.settings import Settings, config
from ovman.shipped import EMBEDDED, HOME, user_cache
from ovman.sim.session import Session

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

RESULTS, CONFIG = Path("results"), Path("config.yaml")
RELEASE = HOME / EMBEDDED
Say = Callable[[str], None]


def show(options: argparse.Namespace, say: Say, cache: Path | None = None, note: str = "") -> Iterator[Path]:
    """Write the pages of the episodes that match and yield each file.

    say: Takes a line about each tour that is recorded or looked at. cache: Keeps the recorded tours and their detections; the
    user's by default. note: A sentence about the episodes.

    Raises:
        ShowError, ConfigError, RecordError, EntryError, SimulatorError: In one line.
    """
    settings = config.load(options.config or (CONFIG if CONFIG.is_file() else HOME / CONFIG))
    default = RESULTS if (RESULTS / "episodes").is_dir() else RELEASE
    results = Results(Path(options.results or default), settings)
    directory = Path("pages") if results.directory == RELEASE else results.directory / "pages"
    if not options.episodes and not options.all:
        raise ShowError(f"name an episode, such as {next(iter(results.episodes))}, or write --all")
    patterns = ["*"] if options.all else options.episodes
    try:
        chosen = results.choose(patterns)
    except ShowError:
        if options.results is not None or default == RELEASE:
            raise
        results = Results(RELEASE, settings)
        chosen = results.choose(patterns)
    output = Path(options.output or directory)
    for episode in chosen:
        is_file = options.output is not None and len(chosen) == 1 and not output.is_dir()
        path = output if is_file else output / f"{episode.id}.html"
        text = _page(results, episode, options.runs, say, cache or user_cache(), note)
        try:
            replace_bytes(path, text.encode())
        except OSError as error:
            raise ShowError(f"{path}: {error.strerror}; name another place with --output") from None
        yield path


def _page(results: Results, episode: Episode, evaluations: Sequence[str], say: Say, cache: Path, note: str) -> str:
    """Return the page of an episode. Its tours are recorded, and objects detected in them, if the cache lacks them."""
    settings = results.settings
    own = list(_own_runs(evaluations, episode, settings, say))
    results.scene(episode)  # nothing is recorded for a page that cannot be drawn
    tours = _tours(results, episode, cache, say)
    if tours is None:
        return render_page(results, episode, own=own, note=note)
    networks = load_networks(settings)

    @cache_result
    def load() -> tuple[Detector, Encoder]:
        say(f"detecting objects in the tours of {episode.id}")
        return networks()

    kept = Cache(cache / "detections" / digest_code("ovman.perception.detections"))
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        seen = detect_tours({episode.visits[which]: tours[which] for which in VISITS}, settings, kept, load)
    detected = {which: seen[episode.visits[which]] for which in VISITS}
    maps = {which: build_map([one], settings.maps.cluster_radius_m) for which, one in detected.items()}
    evidence = read_evidence(results, episode, maps, networks()[1].texts([episode.noun])[0])
    return render_page(results, episode, evidence, {which: (tours[which], detected[which]) for which in VISITS}, own, note)


def _tours(results: Results, episode: Episode, cache: Path, say: Say) -> Mapping[str, Path] | None:
    """Return the folders of the recorded tours; record them if the results have none. None if that needs Unity."""
    there = {which: tour_path(results.directory / "visits" / episode.scene, episode.visits[which]) for which in VISITS}
    if all((directory / "visit.json").is_file() for directory in there.values()):
        return there
    if episode.backend != "embedded":
        return None
    with Session(episode.scene, episode.settings) as session:
        recorded = TourCache(cache, say).places(session, episode)
    return {which: recorded[episode.visits[which]] for which in VISITS}


def _own_runs(evaluations: Sequence[str], episode: Episode, settings: Settings, say: Say) -> Iterator[Entry]:
    """Yield the runs of an episode in folders of evaluations; those with a trace are replayed. EntryError, SimulatorError."""
    for number, directory in enumerate(map(Path, evaluations)):
        arm, of_arm = replay_job(settings, read_manifest(directory))
        runs = [run for _, run in read_runs(runs_path(directory)) if run.episode == episode.id]
        if not runs:
            say(f"{directory}: has no run of {episode.id}; its page shows none")
            continue
        lines = []
        with open_session(episode, arm, of_arm) as session:
            for run in runs:
                trace = partial(_trace_path, session, Run(episode, arm, run.seed, of_arm), run.trace or "")
                lines.append(describe_run(run, episode, session.with_restarts(trace) if run.trace else ()))
        yield Entry(f"own-{number}", arm.name, str(directory), False, True, tuple(lines))


def _trace_path(session: Session, run: Run, trace: str) -> list[Point]:
    """Return the position of the agent at its spawn and after each action that moves it."""
    env = open_env(session, run)
    path = [(session.pose.x, session.pose.z)]
    for action in (ACTIONS[letter] for letter in trace):
        _, done = env.step(action)
        if action not in (Action.STOP, Action.ABSTAIN):
            path.append((session.pose.x, session.pose.z))
        if done:
            break
    return path

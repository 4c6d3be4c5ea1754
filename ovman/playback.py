"""The command `ovman show`: pages about episodes, with an index if there are several."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ovman.agents.interface import VISITS, Action
from ovman.atomic import replace_bytes
from ovman.cache import Cache
from ovman.entry.manifest import read_manifest, read_runs, runs_path
from ovman.entry.verification import replay_job
from ovman.evaluation.tours import TourCache
from ovman.perception import detections
from ovman.provenance import digest_code
from ovman.records.episode import Episode
from ovman.report.show.answers import Drive, Pose
from ovman.report.show.page import index, page
from ovman.report.show.results import Results, ShowError
from ovman.runner import ACTIONS, Run, open_env, open_session
from ovman.settings import MAIN, Settings, arms_of, config
from ovman.shipped import EMBEDDED, HOME, user_cache
from ovman.sim.session import Session

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

PAGES = "pages"
"""The folder of a results directory that pages are written into unless another place is named."""
RESULTS, CONFIG = "results", "config.yaml"
Say = Callable[[str], None]


def show(
    patterns: Sequence[str],
    all_of_them: bool,
    results_dir: str | Path | None,
    output: str | Path | None,
    config_file: str | Path | None,
    evaluations: Sequence[str | Path],
    say: Say,
    cache: Path | None = None,
) -> Iterator[Path]:
    """Write the pages of the episodes that match and yield each file, the index of several last.

    Args:
        patterns: Ids of episodes, or shell wildcards.
        all_of_them: Every episode, whatever `patterns` has.
        results_dir: `results` of the working directory by default; the release if that is missing or lacks the episodes.
        output: A file for one episode, a directory for many; by default `pages` in the results, or in the working directory.
        config_file: That of the working directory by default, and the release's if there is none.
        evaluations: Folders that `ovman eval` wrote, whose runs are drawn and judged as well.
        say: Takes a line about each tour that is recorded or looked at.
        cache: Keeps the recorded tours and their detections; the user's by default.

    Raises:
        ShowError, ConfigError, RecordError, EntryError, SimulatorError: In one line.
    """
    settings, results, directory = places(results_dir, output, config_file)
    if not patterns and not all_of_them:
        raise ShowError(f"name an episode, such as {next(iter(results.episodes), 'FloorPlan201/moved/0000')}, or write --all")
    results, chosen = _chosen(results, ["*"] if all_of_them else patterns, results_dir is None)
    alone = len(chosen) == 1 and output is not None and not directory.is_dir()
    for name in chosen:
        episode = results.episodes[name]
        results.scene(episode)  # nothing is recorded for a page that cannot be drawn
        _supply(results, episode, settings, cache or user_cache(), say)
        drives = list(_own_drives(evaluations, episode, settings, say))
        yield _write(directory if alone else directory / f"{name}.html", page(results, name, settings, drives))
    if len(chosen) > 1:
        yield _write(directory / "index.html", index(results, chosen, [Path(f"{name}.html") for name in chosen]))


def places(
    results_dir: str | Path | None, output: str | Path | None, config_file: str | Path | None
) -> tuple[Settings, Results, Path]:
    """Return the settings, the results, and where pages go, with the defaults of `show`. ConfigError."""
    released = results_dir is None and not Path(RESULTS, "episodes").is_dir()
    settings = config.load(Path(config_file) if config_file else Path(CONFIG) if Path(CONFIG).is_file() else HOME / CONFIG)
    splits = {name: split.arms for name, split in settings.splits.items() if name != MAIN}
    apart = {name for name, split in settings.splits.items() if not split.in_main_job}
    directory_of_results = HOME / EMBEDDED if released else Path(results_dir or RESULTS)
    results = Results(directory_of_results, arms_of(settings.arms), splits, apart)
    directory = Path(output) if output is not None else Path() / PAGES if released else results.directory / PAGES
    return settings, results, directory


def _chosen(results: Results, patterns: Sequence[str], or_released: bool) -> tuple[Results, list[str]]:
    """Return the episodes that match, from the release if the results lack them. ShowError if neither has them."""
    try:
        return results, results.choose(patterns)
    except ShowError:
        if not or_released:
            raise
        released = Results(HOME / EMBEDDED, results.arms, results.splits, results.apart)
        return released, released.choose(patterns)


def _supply(results: Results, episode: Episode, settings: Settings, cache: Path, say: Say) -> None:
    """Record the tours of an episode and detect objects in them, if the results lack them. SimulatorError, WeightsError."""
    if episode.backend != "embedded":
        return
    tours = _tours(results, episode, cache, say)
    lacks = [which for which in VISITS if results.map(episode, which) is None or results.detections(episode, which) is None]
    visits = {episode.visits[which]: tours[which] for which in VISITS}
    if not lacks:
        results.supply(episode, tours)
        return
    networks = detections.load_networks(settings)

    def loaded() -> tuple[Detector, Encoder]:
        say(f"detecting objects in the tours of {episode.id}")
        return networks()

    kept = Cache(cache / "detections" / digest_code("ovman.perception.detections"))
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        seen = detections.detect_tours(visits, settings, kept, functools.cache(loaded))
    noun = None if episode.noun in results.nouns else networks()[1].texts([episode.noun])[0]
    results.supply(episode, tours, seen, noun, settings.maps.cluster_radius_m)


def _tours(results: Results, episode: Episode, cache: Path, say: Say) -> Mapping[str, Path]:
    """Return the folders of the recorded tours; record them if the results have none."""
    there = {which: results.visit_directory(episode, which) for which in VISITS}
    if all((directory / "visit.json").is_file() for directory in there.values()):
        return there
    with Session(episode.scene, episode.settings) as session:
        recorded = TourCache(cache, say).places(session, episode)
    return {which: recorded[episode.visits[which]] for which in VISITS}


def _own_drives(evaluations: Sequence[str | Path], episode: Episode, settings: Settings, say: Say) -> Iterator[Drive]:
    """Yield the runs of an episode in folders of evaluations; those with a trace are replayed. EntryError, SimulatorError."""
    for directory in map(Path, evaluations):
        arm, of_arm = replay_job(settings, read_manifest(directory))
        runs = [run for _, run in read_runs(runs_path(directory)) if run.episode == episode.id]
        if not runs:
            say(f"{directory}: has no run of {episode.id}; its page shows none")
        with open_session(episode, arm, of_arm) as session:
            for run in runs:
                again = Run(episode, arm, run.seed, of_arm)
                trace = partial(_trace_poses, session, again, run.trace or "")
                yield Drive(run, () if run.trace is None else session.with_restarts(trace))


def _trace_poses(session: Session, run: Run, trace: str) -> list[Pose]:
    """Return the pose of the agent at its spawn and after each action that moves it."""
    env = open_env(session, run)
    poses = [_pose(session)]
    for action in (ACTIONS[letter] for letter in trace):
        _, done = env.step(action)
        if action not in (Action.STOP, Action.ABSTAIN):
            poses.append(_pose(session))
        if done:
            break
    return poses


def _pose(session: Session) -> Pose:
    return session.pose.x, session.pose.z, session.pose.yaw_deg


def _write(path: Path, text: str) -> Path:
    """Write a whole file. ShowError if it cannot be written."""
    try:
        replace_bytes(path, text.encode())
    except OSError as error:
        raise ShowError(f"{path}: {error.strerror}; name another place with --output") from None
    return path

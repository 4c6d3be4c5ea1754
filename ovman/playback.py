"""The commands `ovman show` and `ovman gallery`: pages about episodes, films of runs, and all world pairs of a split."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from functools import cache as cache_result
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ovman.agents.interface import LETTERS, VISITS, Action, Observation
from ovman.atomic import replace_bytes
from ovman.cache import Cache
from ovman.entry.manifest import read_manifest, read_runs, runs_path
from ovman.entry.verification import replay_job
from ovman.evaluation.tours import TourCache
from ovman.perception.detections import detect_tours, load_networks
from ovman.perception.maps import build_map
from ovman.provenance import digest_code
from ovman.records.episode import Episode
from ovman.records.geometry import Spawn
from ovman.records.run import Score
from ovman.records.visit import tour_path
from ovman.report.show.answers import Entry, describe_run
from ovman.report.show.evidence import read_evidence
from ovman.report.show.film import make_film
from ovman.report.show.gallery import render_gallery
from ovman.report.show.page import render_page
from ovman.report.show.results import Results, ShowError
from ovman.runner import ACTIONS, Run, open_env, open_session
from ovman.settings import Kind, Settings, config
from ovman.settings.arms import ArmJob
from ovman.settings.settings import arm_job, settings_of_arm
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
    results, default = _open_results(options)
    directory = Path("pages") if results.directory == RELEASE else results.directory / "pages"
    if not options.episodes and not options.all:
        raise ShowError(f"name an episode, such as {next(iter(results.episodes))}, or write --all")
    patterns = ["*"] if options.all else options.episodes
    try:
        chosen = results.choose(patterns)
    except ShowError:
        if options.results is not None or default == RELEASE:
            raise
        results = Results(RELEASE, results.settings)
        chosen = results.choose(patterns)
    output = Path(options.output or directory)
    for episode in chosen:
        is_file = options.output is not None and len(chosen) == 1 and not output.is_dir()
        path = output if is_file else output / f"{episode.id}.html"
        text = _page(results, episode, options.runs, say, cache or user_cache(), note)
        _write(path, text.encode(), "--output")
        yield path


def write_gallery(options: argparse.Namespace) -> Path:
    """Write the gallery of a split and return its file.

    Raises:
        ShowError, ConfigError, RecordError, EntryError: In one line.
    """
    results, _ = _open_results(options)
    own = {}
    for directory in map(Path, options.runs):
        own[f"{read_manifest(directory).arm} in {directory}"] = [run for _, run in read_runs(runs_path(directory))]
    path = Path(options.out) / "index.html"
    _write(path, render_gallery(results, options.split, path.parent, own).encode(), "--out")
    return path


def write_film(options: argparse.Namespace) -> Path:
    """Write the film of a run of an arm that navigates, or of a run in the folder of an evaluation, and return its file.

    Raises:
        ShowError, ConfigError, RecordError, EntryError, SimulatorError: In one line.
    """
    path, (results, _) = Path(options.video), _open_results(options)
    if path.suffix != ".webp":
        raise ShowError(f"--video {path}: films are animated WebP; write a name that ends in .webp")
    if len(options.episodes) != 1 or options.all or options.output is not None:
        raise ShowError("--video: a film shows one episode; name one, without --all and --output")
    chosen = results.choose(options.episodes)
    if len(chosen) > 1:
        raise ShowError(f"--video: a film shows one episode; {options.episodes[0]} matches {len(chosen)}, such as {chosen[0].id}")
    (episode,) = chosen
    title, arm, of_arm, run = _choose_run(results, episode, options)
    scene = results.scene(episode)
    with open_session(episode, arm, of_arm) as session:
        replayed = partial(_replay, session, Run(episode, arm, run.seed, of_arm), run.trace or "", looks=True)
        poses, images, end = session.with_restarts(replayed)
    line = describe_run(end, episode)
    _write(path, make_film(episode, scene, f"{title}, seed {run.seed}", line, poses, images), "--video")
    return path


def _choose_run(results: Results, episode: Episode, options: argparse.Namespace) -> tuple[str, ArmJob, Settings, Score]:
    """Return the agent in words, its arm, the settings of its job and its run. ShowError if no run that fits has a trace."""
    settings, found = results.settings, list[tuple[str, ArmJob, Settings, Score]]()
    if options.runs:
        for directory in map(Path, options.runs):
            arm, of_arm = replay_job(settings, read_manifest(directory))
            runs = [run for _, run in read_runs(runs_path(directory)) if run.episode == episode.id]
            found += [(arm.name, arm, of_arm, run) for run in runs]
    else:
        for one in results.arms(episode, Kind.EMBODIED):
            job = arm_job(settings, one.name), settings_of_arm(settings, one.name)
            found += [(one.system, *job, run) for run in results.runs(one.name, episode)]
    for fits in found:
        if fits[3].trace is not None and options.arm in (None, fits[1].name) and options.seed in (None, fits[3].seed):
            return fits
    asked = "".join(f" of {word} {value}" for word, value in (("arm", options.arm), ("seed", options.seed)) if value is not None)
    seeds: dict[str, list[str]] = {}
    for _, arm, _, run in found:
        seeds.setdefault(arm.name, []).append(str(run.seed))
    there = ", ".join(f"{name} (seed {' '.join(of_arm)})" for name, of_arm in seeds.items()) or "none"
    raise ShowError(f"{episode.id}: no recorded run{asked}; there: {there}. Name a folder of `ovman eval` with --runs")


def _open_results(options: argparse.Namespace) -> tuple[Results, Path]:
    """Return the results that the options name, and the directory that is used by default."""
    settings = config.load(options.config or (CONFIG if CONFIG.is_file() else HOME / CONFIG))
    default = RESULTS if (RESULTS / "episodes").is_dir() else RELEASE
    return Results(Path(options.results or default), settings), default


def _write(path: Path, content: bytes, option: str) -> None:
    """Write a file. ShowError if that is refused."""
    try:
        replace_bytes(path, content)
    except OSError as error:
        raise ShowError(f"{path}: {error.strerror}; name another place with {option}") from None


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
                again = partial(_replay, session, Run(episode, arm, run.seed, of_arm), run.trace or "")
                poses = session.with_restarts(again)[0] if run.trace else ()
                lines.append(describe_run(run, episode, [(pose.x, pose.z) for pose in poses]))
        yield Entry(f"own-{number}", arm.name, str(directory), False, True, tuple(lines))


def _replay(session: Session, run: Run, trace: str, looks: bool = False) -> tuple[list[Spawn], list[np.ndarray], Score]:
    """Return the poses of the agent at its spawn and after each action, what it sees there if it looks, and the judged run."""
    env, poses, images = open_env(session, run), list[Spawn](), list[np.ndarray]()

    def keep(seen: Observation) -> None:
        poses.append(Spawn(x=session.pose.x, z=session.pose.z, yaw_deg=session.pose.yaw_deg))
        if seen.rgb is not None:
            images.append(seen.rgb.copy())

    env.looks = looks
    keep(env.observe())
    for action in (ACTIONS[letter] for letter in f"{trace}{LETTERS[Action.ABSTAIN]}"):
        observation, done = env.step(action)
        if action not in (Action.STOP, Action.ABSTAIN):
            keep(observation)
        if done:
            break
    return poses, images, env.score(run.arm.name, run.seed)

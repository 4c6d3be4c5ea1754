"""The command `ovman show --rrd`: recordings of episodes for Rerun's viewer."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from ovman.agents.interface import VISITS
from ovman.atomic import replacing
from ovman.entry.tour_cache import TourCache
from ovman.models.episode import Episode
from ovman.models.settings import Kind, Settings, arms_of, of_kind
from ovman.perception.libraries import cache as user_cache
from ovman.playback.paths import runs_of_arms, runs_of_evaluation, traced
from ovman.playback.recording import write
from ovman.report.show.command import places
from ovman.report.show.reasoning import reasonings
from ovman.report.show.results import Results, ShowError
from ovman.report.show.verdicts import static_rows
from ovman.sim.session import Session


def record(
    patterns: Sequence[str],
    results_dir: str | Path | None,
    output: str | Path | None,
    config_file: str | Path | None,
    evaluations: Sequence[str | Path],
    cache: Path | None = None,
) -> Iterator[Path]:
    """Write a recording of each episode that matches, and yield its file.

    results_dir, output, config_file: as for `ovman.report.show.command.show`. evaluations: folders that `ovman eval` wrote, whose
    runs are drawn as well. cache: folder of tours, which are recorded where the results have none; the user's by default.
    ShowError, ConfigError, RecordError, EntryError or SimulatorError, in one line.
    """
    if find_spec("rerun") is None:
        raise ShowError("rerun-sdk is not installed; pip install 'ovman[rerun]' brings it")
    settings, results, directory = places(results_dir, output, config_file)
    if not patterns:
        raise ShowError("name an episode, such as FloorPlan201/moved/0001")
    chosen = results.chosen(patterns)
    for name in chosen:
        alone = len(chosen) == 1 and output is not None and not directory.is_dir()
        path = directory if alone else directory / f"{name}.rrd"
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as partial:
            _write(partial, results, results.episodes[name], settings, evaluations, cache or user_cache())
        yield path


def _write(
    path: Path, results: Results, episode: Episode, settings: Settings, evaluations: Sequence[str | Path], cache: Path
) -> None:
    arms = of_kind(arms_of(settings.arms), Kind.EMBODIED)
    judged = [run for arm in arms for run in results.runs(arm.name, episode).values()]
    runs = runs_of_arms(judged, settings)
    for one in evaluations:
        runs += runs_of_evaluation(Path(one), episode, settings)
    # One path an arm and seed: an evaluation's own run stands for the one that the results have.
    drawn = {(run.arm, run.seed): (run, of) for run, of in runs}
    write(
        path,
        episode,
        results.scene(episode.scene),
        _tours(results, episode, cache),
        reasonings(results, episode, settings),
        static_rows(results, episode),
        list(traced(list(drawn.values()), episode)),
        settings,
    )


def _tours(results: Results, episode: Episode, cache: Path) -> Mapping[str, Path]:
    """The folders of the recorded tours; recorded now where the results have none."""
    there = {which: results.visit_directory(episode, which) for which in VISITS}
    if all((directory / "visit.json").is_file() for directory in there.values()):
        return there
    with Session(episode.scene, episode.settings) as session:
        places = TourCache(cache, logging.getLogger(__name__).info).places(session, episode)
    return {which: places[episode.visits[which]] for which in VISITS}

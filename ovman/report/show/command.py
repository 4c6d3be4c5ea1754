"""The command `ovman show`: pages about episodes, and an index where they are many."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ovman.atomic import replace_bytes
from ovman.models.settings import Settings, arms_of
from ovman.report.show.index import index
from ovman.report.show.page import page
from ovman.report.show.results import Results, ShowError
from ovman.shipped import EMBEDDED, HOME
from ovman.workflow import config

PAGES = "pages"
"""The folder of a results directory that pages are written into unless another place is named."""
RESULTS, CONFIG = "results", "config.yaml"


def show(
    patterns: Sequence[str],
    all_of_them: bool,
    results_dir: str | Path | None,
    output: str | Path | None,
    config_file: str | Path | None,
) -> Iterator[Path]:
    """Write the pages of the episodes that match and yield each file, the index of several last.

    results_dir: `results` of the working directory if it is not named, and where there are none the release, which has no tours
    and no maps. output: a file for one episode, a directory for many; `pages` in the results, or in the working directory for
    the release. config_file: that of the working directory if it is not named, and where there is none the release's. Raises
    ShowError, ConfigError or RecordError, all ValueErrors of one line, for what cannot be shown.
    """
    settings, results, directory = places(results_dir, output, config_file)
    if not patterns and not all_of_them:
        raise ShowError(f"name an episode, such as {next(iter(results.episodes), 'FloorPlan201/moved/0000')}, or write --all")
    chosen = results.chosen(["*"] if all_of_them else patterns)
    if len(chosen) == 1 and output is not None and not directory.is_dir():
        yield _write(directory, page(results, chosen[0], settings))
        return
    for name in chosen:
        yield _write(directory / file_name(name), page(results, name, settings))
    if len(chosen) > 1:
        yield _write(directory / "index.html", index(results, chosen, [file_name(name) for name in chosen]))


def places(
    results_dir: str | Path | None, output: str | Path | None, config_file: str | Path | None
) -> tuple[Settings, Results, Path]:
    """The settings, the results, and where pages go, for what is named and what is not, as `show` says. ConfigError."""
    released = results_dir is None and not Path(RESULTS, "episodes").is_dir()
    directory_of_results = HOME / EMBEDDED if released else Path(results_dir or RESULTS)
    settings = config.load(Path(config_file) if config_file else Path(CONFIG) if Path(CONFIG).is_file() else HOME / CONFIG)
    results = Results(directory_of_results, arms_of(settings.arms), {name: split.arms for name, split in settings.splits.items()})
    directory = Path(output) if output is not None else Path() / PAGES if released else results.directory / PAGES
    return settings, results, directory


def file_name(episode: str) -> Path:
    """Of an episode's page, below the directory of the pages: FloorPlan201/moved/0001.html."""
    return Path(f"{episode}.html")


def _write(path: Path, text: str) -> Path:
    """A file that is there whole or not at all. ShowError where it cannot be written."""
    try:
        replace_bytes(path, text.encode())
    except OSError as error:
        raise ShowError(f"{path}: {error.strerror}; name another place with --output") from None
    return path

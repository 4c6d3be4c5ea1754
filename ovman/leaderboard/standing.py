"""What each submission comes to here: a row of a table where it agrees, else what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ovman.analysis.rates import ALL, Rate
from ovman.entry import tables
from ovman.entry.beside import Beside
from ovman.entry.errors import EntryError
from ovman.entry.manifest import Manifest, read_manifest
from ovman.entry.recorded import read_recorded
from ovman.entry.release import Release
from ovman.entry.score import score_file
from ovman.entry.score_page import complaint
from ovman.entry.summary import summary_of
from ovman.entry.verification import verify
from ovman.leaderboard.entry import FILE, PREDICTIONS, Entry, Role, Submission, submissions
from ovman.records.run import Score
from ovman.settings import Source
from ovman.workflow.journal import Journal, digest

SHOWN = 3
"""Reasons that are shown of a submission that is refused; the rest are counted."""
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Standing:
    """A submission that agrees.

    rates: by relation, then all. chance: of 1/n over all. reached_by: controls of the release whose success is no lower, with
    it. where: its agent ran, and its body where that is not the benchmark's own; None for predicted points. runs: seeds that
    were driven again, or runs that were judged. traces: digest of the actions of all runs; None for predicted points. oracles:
    arms of the release that are handed the answer and do the same in every run.
    """

    name: str
    entry: Entry
    split: str
    rates: Sequence[Rate]
    chance: float
    reached_by: Sequence[tuple[str, float]]
    where: str | None
    runs: int
    traces: str | None = None
    oracles: Sequence[str] = ()

    @property
    def drives(self) -> bool:
        """Whether it was driven."""
        return self.where is not None


@dataclass(frozen=True, slots=True)
class Refusal:
    """A submission that does not stand, and why, a line each."""

    place: str
    reasons: Sequence[str]


def standings(
    directory: Path, release: Release, say: Say, workers: int = 1, journal: Journal | None = None
) -> Iterator[Standing | Refusal]:
    """What comes of each submission below `directory`, by the names of their entries.

    journal: as for `verify`. What is wrong with one entry is its own: others stand. EntryError where there is no entry;
    SimulatorError.
    """
    folders = sorted(path for path in directory.iterdir() if path.is_dir()) if directory.is_dir() else []
    if not any((folder / FILE).exists() for folder in folders):
        raise EntryError(f"{directory}: holds no entry; make one with `ovman enter`")
    for folder in folders:
        try:
            found = list(submissions(folder))
        except ValueError as error:
            yield Refusal(folder.name, [str(error)])
            continue
        for one in found:
            say(f"{one.place}: {'replayed' if one.drives else 'judged again'}")
            try:
                yield _driven(one, release, say, workers, journal) if one.drives else _judged(one, release)
            except ValueError as error:
                yield Refusal(one.place, [str(error)])


def barred(one: Submission, manifest: Manifest, release: Release) -> Iterator[str]:
    """Why an evaluation is no entry, whatever its runs are. A line each."""
    place = one.directory / "manifest.json"
    if manifest.split != one.split:
        yield f"{place}: split: {manifest.split}, and the folder is called {one.split}; name it after its split"
    if not manifest.whole:
        yield f"{place}: asked: {len(manifest.asked)} of {manifest.n} episodes; run them all"
    wanted = list(release.settings.evaluation.seeds)
    if sorted(manifest.seeds) != sorted(wanted):
        yield f"{place}: seeds: {list(manifest.seeds)}; run it under {wanted}"
    allowed = release.settings.primitives.action_budget
    if manifest.budget is not None and manifest.budget > allowed:
        yield f"{place}: budget: {manifest.budget} actions; run it under the episodes' own, {allowed}, or fewer"
    if manifest.handed and one.entry.role is not Role.DIAGNOSTIC:
        yield f"{place}: handed: {', '.join(manifest.handed)}; an agent that is handed truth is entered as {Role.DIAGNOSTIC}"


def _driven(one: Submission, release: Release, say: Say, workers: int, journal: Journal | None) -> Standing | Refusal:
    manifest = read_manifest(one.directory)
    if reasons := list(barred(one, manifest, release)):
        return Refusal(one.place, reasons)
    found = verify(one.directory, release, None, say, workers, journal)
    if not found.agrees:
        return Refusal(one.place, found.differences)
    episodes = read_recorded(one.directory, manifest, release, None).episodes
    runs = first_attempts(found.runs, manifest)
    summary = summary_of(runs, [*episodes.values()], manifest, release)
    ran = str(manifest.where) if manifest.embodiment == "default" else f"{manifest.where}, {manifest.embodiment}"
    traces = traces_of(found.runs)
    oracles = [
        arm
        for arm, entry in release.settings.arms.items()
        if entry.answer is Source.HANDED and traces_of(release.runs(arm, one.split)) == traces
    ]
    if manifest.repeated:
        ran += f", runs failed at the first attempt: {len(manifest.repeated)}"
    made = _standing(one, summary.rates, summary.beside, ran, len(manifest.seeds))
    return replace(made, traces=traces, oracles=oracles)


def traces_of(runs: Sequence[Score]) -> str:
    """Return a digest of the actions of runs by episode and seed."""
    return digest(sorted([run.episode, run.seed, run.trace] for run in runs))


def first_attempts(runs: Sequence[Score], manifest: Manifest) -> list[Score]:
    """Return the runs as their first attempts ended: one that took several attempts failed at the first."""
    again = {(one.episode, one.seed) for one in manifest.repeated if one.attempts > 1}
    failed = {"outcome": "abstained", "success": False, "spl": 0.0}
    return [run.model_copy(update=failed) if (run.episode, run.seed) in again else run for run in runs]


def _judged(one: Submission, release: Release) -> Standing | Refusal:
    found = score_file(one.directory / PREDICTIONS, release, one.split)
    if not found.whole:
        return Refusal(one.place, [complaint(found)])
    by_arm = tables.by_arm(found.rates)
    if len(by_arm) > 1:
        names = ", ".join(arm for arm, _ in by_arm)
        return Refusal(one.place, [f"{found.file}: arm: has {names}; one entry is one arm"])
    return _standing(one, found.rates, found.beside, None, found.rates[-1].seeds)


def _standing(one: Submission, rates: Sequence[Rate], beside: Beside, where: str | None, runs: int) -> Standing:
    reached = tables.reaching(rates[-1].rate, beside)
    return Standing(one.name, one.entry, one.split, rates, beside.chance[ALL], reached, where, runs)

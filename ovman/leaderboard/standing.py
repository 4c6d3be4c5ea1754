"""The result of each submission: a row of a table if it agrees with what is replayed or judged here, else a refusal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ovman.analysis.outcomes import group_by
from ovman.analysis.rates import Rate
from ovman.cache import Cache, digest
from ovman.draws.folder import read_draw
from ovman.entry import EntryError
from ovman.entry.manifest import Manifest, read_manifest
from ovman.entry.release import Release
from ovman.entry.score import complaint, score_file
from ovman.entry.summary import summarise
from ovman.entry.verification import verify
from ovman.leaderboard.commitment import read_commitment, reasons_uncommitted
from ovman.leaderboard.entry import FILE, PREDICTIONS, Entry, Role, Submission, submissions
from ovman.records.run import Score
from ovman.settings import Source
from ovman.settings.arms import Track

SHOWN = 3
"""Reasons that are shown of a refused submission; the others are counted."""
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Standing:
    """A submission that agrees.

    Attributes:
        name: Of the entry.
        entry: Who enters what.
        split: Name of the split or of the draw.
        rates: By relation, then all.
        reached_by: Controls of the release whose success is not lower, with it.
        where: Where its agent ran, and its body if that is not the benchmark's own; None for predicted points.
        runs: Number of seeds that were replayed, or of runs that were judged.
        traces: Digest of the actions of all runs; None for predicted points.
        oracles: Arms of the release with the oracle answer that do the same in every run.
        committed: Time of the entry's commitment on a draw, None on a split.
        track: Of the evaluation; predicted points are in the paper's.
    """

    name: str
    entry: Entry
    split: str
    rates: Sequence[Rate]
    reached_by: Sequence[tuple[str, float]]
    where: str | None
    runs: int
    traces: str | None = None
    oracles: Sequence[str] = ()
    committed: str | None = None
    track: Track = Track.PAPER

    @property
    def drives(self) -> bool:
        """Whether it navigates; it holds predicted points if not."""
        return self.where is not None


@dataclass(frozen=True, slots=True)
class Refusal:
    """A submission that does not stand, with one line per reason."""

    place: str
    reasons: Sequence[str]

    @property
    def summary(self) -> str:
        """The first reasons, and the number of others."""
        more = len(self.reasons) - SHOWN
        return "; ".join(self.reasons[:SHOWN]) + (f"; and {more} more" if more > 0 else "")


def judge_submissions(
    directory: Path,
    release: Release,
    say: Say,
    workers: int = 1,
    cache: Cache | None = None,
    draws: Mapping[str, Path] = MappingProxyType({}),
) -> Iterator[Standing | Refusal]:
    """Yield the result of each submission below `directory`, by the names of their entries.

    An invalid submission does not affect others. cache: As for `verify`. draws: Folders of draws by name; submissions on other
    draws are left out.

    Raises:
        EntryError: There is no entry.
        SimulatorError: The simulator refuses.
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
            if one.is_fresh and one.split not in draws:
                say(f"{one.place}: left out; name the folder of its draw with --draw")
                continue
            say(f"{one.place}: {'replayed' if one.drives else 'judged again'}")
            try:
                if one.drives:
                    yield _replay(one, release, say, workers, cache, draws.get(one.split))
                elif one.is_fresh:
                    yield Refusal(one.place, [f"{one.directory}: points on a draw name no committed agent; enter an evaluation"])
                else:
                    yield _judge_points(one, release)
            except ValueError as error:
                yield Refusal(one.place, [str(error)])


def reasons_against(one: Submission, manifest: Manifest, release: Release) -> Iterator[str]:
    """Yield lines on why an evaluation is not an entry, whatever its runs are."""
    place = one.directory / "manifest.json"
    if (of := manifest.draw or manifest.split) != one.split:
        yield f"{place}: split: {of}, and the folder is called {one.split}; name it after its split or draw"
    if not manifest.is_whole:
        yield f"{place}: asked: {len(manifest.asked)} of {manifest.n} episodes; run them all"
    wanted = list(release.settings.evaluation.seeds)
    if sorted(manifest.seeds) != sorted(wanted):
        yield f"{place}: seeds: {list(manifest.seeds)}; run it under {wanted}"
    allowed = release.settings.primitives.action_budget
    if manifest.budget is not None and manifest.budget > allowed:
        yield f"{place}: budget: {manifest.budget} actions; run it under the episodes' own, {allowed}, or fewer"
    if manifest.handed and one.entry.role is not Role.DIAGNOSTIC:
        yield f"{place}: handed: {', '.join(manifest.handed)}; an agent that is handed truth is entered as {Role.DIAGNOSTIC}"


def digest_traces(runs: Sequence[Score]) -> str:
    """Return a digest of the actions of runs by episode and seed."""
    return digest(sorted([run.episode, run.seed, run.trace] for run in runs))


def first_attempts(runs: Sequence[Score], manifest: Manifest) -> list[Score]:
    """Return the runs as their first attempts ended: one that took several attempts failed at the first."""
    again = {(one.episode, one.seed) for one in manifest.repeated if one.attempts > 1}
    failed = {"outcome": "abstained", "success": False, "spl": 0.0}
    return [run.model_copy(update=failed) if (run.episode, run.seed) in again else run for run in runs]


def _replay(
    one: Submission, release: Release, say: Say, workers: int, cache: Cache | None, draw: Path | None
) -> Standing | Refusal:
    """Judge an evaluation. draw: Folder of the draw that it is on, None for a split."""
    manifest, committed, entry = read_manifest(one.directory), None, one.directory.parent
    reasons = list(reasons_against(one, manifest, release))
    if draw is not None:
        reasons += reasons_uncommitted(entry, manifest, read_draw(draw))
        commitment = read_commitment(entry)
        committed = None if commitment is None else commitment.time
    if reasons:
        return Refusal(one.place, reasons)
    found = verify(one.directory, release, draw, say, workers, cache)
    if not found.agrees:
        return Refusal(one.place, found.differences)
    summary = summarise(first_attempts(found.runs, manifest), found.episodes, manifest, release)
    ran = manifest.ran if manifest.embodiment == "default" else f"{manifest.ran}, {manifest.embodiment}"
    if manifest.repeated:
        ran += f", runs failed at the first attempt: {len(manifest.repeated)}"
    traces = digest_traces(found.runs)
    told = [name for name, arm in release.settings.arms.items() if arm.answer is Source.HANDED]
    oracles = [name for name in told if digest_traces(release.scores(name, one.split)) == traces]
    reached = summary.baselines.reaching(summary.rates[-1].rate)
    seeds = len(manifest.seeds)
    rest = traces, oracles, committed, manifest.track
    return Standing(one.name, one.entry, one.split, summary.rates, reached, ran, seeds, *rest)


def _judge_points(one: Submission, release: Release) -> Standing | Refusal:
    found = score_file(one.directory / PREDICTIONS, release, one.split)
    if not found.is_whole:
        return Refusal(one.place, [complaint(found)])
    arms = group_by(found.rates, "arm")
    if len(arms) > 1:
        return Refusal(one.place, [f"{found.file}: arm: has {', '.join(arms)}; one entry is one arm"])
    reached = found.baselines.reaching(found.rates[-1].rate)
    return Standing(one.name, one.entry, one.split, found.rates, reached, None, found.rates[-1].seeds)

"""`ovman score`: the static gate of a file of predictions, judged by the functions that make the released tables.

Nothing heavy is imported: no simulator, no network, no data frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis.outcomes import Case, StaticOutcome, static_outcomes
from ovman.analysis.rates import Rate, static_rates
from ovman.entry.beside import Beside, set_beside
from ovman.entry.errors import EntryError
from ovman.entry.predictions import Run, Submitted, read_submitted
from ovman.entry.release import Release
from ovman.records.episode import Episode, root_seed
from ovman.records.prediction import Prediction
from ovman.settings import Kind, Settings


@dataclass(frozen=True, slots=True)
class StaticScore:
    """The static gate of a file. of: what the episodes are, in words; n: how many they are.

    split: the released split that the episodes are, None for others. radius_m: how near to the answer a point succeeds, by the
    episodes' own protocols, ascending. rates: of each arm of the file by relation, then all. missing: of each run (arm and seed)
    that lacks episodes, how many; with any, the rates are of those that all runs of the arm answer, and no score. beside: has
    released arms and tests where the episodes are a released split and none is missing.
    """

    file: Path
    of: str
    split: str | None
    n: int
    radius_m: tuple[float, ...]
    rates: Sequence[Rate]
    missing: Mapping[Run, int]
    beside: Beside

    @property
    def whole(self) -> bool:
        """Whether each run answers every episode: only then it is a score."""
        return not self.missing


def score_file(file: Path, release: Release, split: str, episodes_file: Path | None = None, partial: bool = False) -> StaticScore:
    """Judge the predictions of a file on a split, or on the episodes of a file.

    episodes_file: instead of the split's; the released arms stand beside where its bytes are those of a released split. partial:
    whether rates are made where episodes are missing. settings of the release: single_visit.samples, evaluation.confidence,
    comparisons, arms. Raises EntryError or RecordError, one line, for what cannot be judged.
    """
    source = release.episodes(split) if episodes_file is None else episodes_file
    try:
        of_split = split if episodes_file is None else release.split_of(episodes_file.read_bytes())
        episodes = Episode.load(source)
    except OSError as error:
        raise EntryError(f"{source}: {error.strerror}; name a file of episodes") from None
    if not episodes:
        raise EntryError(f"{source}: holds no episode; name a file of episodes")
    of = f"the episodes of {source}" if of_split is None else f"the episodes of the split {of_split}"
    submitted = read_submitted(file, [episode.id for episode in episodes], of)
    missing = {run: len(absent) for run, absent in submitted.missing.items()}
    judged = [] if missing and not partial else list(_judged(episodes, submitted, release.settings))
    return StaticScore(
        file=file,
        of=of,
        split=of_split,
        n=len(episodes),
        radius_m=tuple(sorted({episode.protocol.success.radius_m for episode in episodes})),
        rates=static_rates(judged, release.settings.evaluation.confidence),
        missing=missing,
        beside=set_beside(judged, Kind.STATIC, of_split, release, not missing),
    )


def _judged(episodes: Sequence[Episode], submitted: Submitted, constants: Settings) -> Iterator[StaticOutcome]:
    """The outcomes of what every run of an arm answers, by the radius of each episode's own protocol."""
    cases = {episode.id: Case.of(episode) for episode in episodes}
    radius = {episode.id: episode.protocol.success.radius_m for episode in episodes}
    arms: dict[str, list[Prediction]] = {}
    for prediction in submitted.predictions:
        arms.setdefault(prediction.arm, []).append(prediction)
    for arm, predictions in arms.items():
        absent = {one for (of, _), some in submitted.missing.items() if of == arm for one in some}
        for radius_m in sorted({*radius.values()}):
            asked = [case for case in cases.values() if case.id not in absent and radius[case.id] == radius_m]
            there = {case.id for case in asked}
            yield from static_outcomes(
                asked,
                [prediction for prediction in predictions if prediction.episode in there],
                radius_m=radius_m,
                samples=constants.single_visit.samples,
                seed=root_seed(episodes),
            )

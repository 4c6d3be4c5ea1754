"""`ovman score`: the static score of a file of predictions, by the functions that make the released tables.

Nothing heavy is imported: no simulator, no network, no data frame.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ovman.analysis.outcomes import Outcome, group_by, static_outcomes
from ovman.analysis.rates import Rate, arm_rates
from ovman.draws.folder import locate_episodes
from ovman.entry import EntryError, tables
from ovman.entry.release import Baselines, Release, compare_with_baselines
from ovman.records.episode import Episode, root_seed
from ovman.records.prediction import Prediction
from ovman.records.record import records
from ovman.settings import Kind, Settings

SCHEMA = "ovman-static-score/1"

Run = tuple[str, int]
"""An arm and its seed."""


@dataclass(frozen=True, slots=True)
class StaticScore:
    """The static score of a file.

    Attributes:
        of: The episodes, in words.
        split: The released split of the episodes, None for others.
        n: Number of episodes.
        radius_m: Distances to the answer within which a point succeeds, by the episodes' own protocols, ascending.
        rates: Of each arm of the file by relation, then all.
        missing: Number of missing episodes of each run (arm and seed) that lacks some. The rates are then of the episodes that
            all runs of the arm answer, and are not a score.
    """

    file: Path
    of: str
    split: str | None
    n: int
    radius_m: tuple[float, ...]
    rates: Sequence[Rate]
    missing: Mapping[Run, int]
    baselines: Baselines

    @property
    def is_whole(self) -> bool:
        """Whether each run answers every episode: only then the rates are a score."""
        return not self.missing


def score_file(file: Path, release: Release, split: str, episodes_file: Path | None = None, partial: bool = False) -> StaticScore:
    """Judge the predictions of a file on a split, or on the episodes of a file.

    Episodes of a file have baselines if the bytes are those of a released split. partial: Whether rates are computed if episodes
    are missing. EntryError or RecordError, in one line, for a wrong file.
    """
    source = release.episodes(split) if episodes_file is None else locate_episodes(episodes_file)[0]
    try:
        of_split = split if episodes_file is None else release.split_of(source.read_bytes())
        episodes = Episode.load(source)
    except OSError as error:
        raise EntryError(f"{source}: {error.strerror}; name a file of episodes") from None
    if not episodes:
        raise EntryError(f"{source}: holds no episode; name a file of episodes")
    of = f"the episodes of {source}" if of_split is None else f"the episodes of the split {of_split}"
    predictions, absent = read_submitted(file, [episode.id for episode in episodes], of)
    outcomes = [] if absent and not partial else list(_judge(episodes, predictions, absent, release.settings))
    return StaticScore(
        file=file,
        of=of,
        split=of_split,
        n=len(episodes),
        radius_m=tuple(sorted({episode.protocol.success.radius_m for episode in episodes})),
        rates=arm_rates(outcomes, release.settings.evaluation.confidence, of_split or ""),
        missing={run: len(some) for run, some in absent.items()},
        baselines=compare_with_baselines(outcomes, Kind.STATIC, of_split, release, not absent),
    )


def read_submitted(path: Path, episodes: Sequence[str], of: str) -> tuple[list[Prediction], dict[Run, list[str]]]:
    """Read the predictions of a JSONL file, each for one of `episodes`; and the episodes that each run lacks, if it lacks some.

    A line needs `episode`, and `x` and `z` or another form of `Prediction`; `schema`, `arm` (the name of the file) and `seed` (0)
    may be left out. of: The episodes in words, for messages.

    Raises:
        EntryError: An episode is none of these, or a run answers one twice.
        RecordError: A record is wrong.
    """
    known, answered = frozenset(episodes), dict[Run, dict[str, str]]()
    predictions = []
    try:
        for place, value in records(path):
            if isinstance(value, dict):
                value = {"schema": "ovman-prediction/1", "arm": path.stem, "seed": 0} | value
            prediction = Prediction.from_json(value, place)
            if prediction.episode not in known:
                raise EntryError(f"{place}: episode: {prediction.episode!r} is none of {of}; name its split with --split")
            run = answered.setdefault((prediction.arm, prediction.seed), {})
            if (first := run.setdefault(prediction.episode, place)) != place:
                line = first.rpartition(":")[2]
                says = f"{prediction.episode} is answered in line {line} already, under the same arm and seed"
                raise EntryError(f"{place}: episode: {says}; remove one of the two, or give each run a `seed`")
            predictions.append(prediction)
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}; name a file of JSON lines") from None
    if not predictions:
        raise EntryError(
            f'{path}: holds no prediction; write one line per episode, {{"episode": "{episodes[0]}", "x": 0.5, "z": 1.5}}'
        )
    return predictions, {run: some for run, there in answered.items() if (some := [one for one in episodes if one not in there])}


def as_json(score: StaticScore) -> str:
    """Return the score as one JSON object with a line feed."""
    value = {
        "schema": SCHEMA,
        "file": str(score.file),
        "split": score.split,
        "episodes": score.of,
        "n": score.n,
        "radius_m": score.radius_m,
        "whole": score.is_whole,
        "missing": [{"arm": arm, "seed": seed, "episodes": n} for (arm, seed), n in score.missing.items()],
        "rates": [asdict(rate) for rate in score.rates],
        **tables.baseline_values(score.baselines),
    }
    return json.dumps(value, indent=1) + "\n"


def as_text(score: StaticScore) -> str:
    """Return the score as lines of text, each table below its title."""
    return "\n".join(_lines(score)) + "\n"


def complaint(score: StaticScore) -> str:
    """Return one line on why a partial set is not a score."""
    runs = [f"{arm}, seed {seed}: {n} of {score.n} episodes are missing" for (arm, seed), n in score.missing.items()]
    return f"{score.file}: {'; '.join(runs)}; a part of {score.of} is no score: answer them all, with an abstention where need be"


def _lines(score: StaticScore) -> Iterator[str]:
    radius, baselines = " or ".join(f"{radius:g}" for radius in score.radius_m), score.baselines
    yield f"{score.file}: static gate, a point within {radius} m of the answer, on {score.of}"
    for arm, rates in group_by(score.rates, "arm").items():
        partial = f"{arm}: PARTIAL, {rates[-1].n} of {score.n} episodes, no score"
        title = f"{arm}: {score.n} episodes" if score.is_whole else partial
        yield from ("", title, *tables.table(tables.rate_rows(rates, baselines.chance), markdown=False))
    yield from tables.baseline_lines(score.rates, baselines, "this file", markdown=False)


def _judge(
    episodes: Sequence[Episode], predictions: Sequence[Prediction], missing: Mapping[Run, Sequence[str]], constants: Settings
) -> Iterator[Outcome]:
    """Yield the outcomes of the answers of every run of an arm, by the radius of each episode's own protocol."""
    radius = {episode.id: episode.protocol.success.radius_m for episode in episodes}
    for arm, of_arm in group_by(predictions, "arm").items():
        absent = {one for (of, _), some in missing.items() if of == arm for one in some}
        for radius_m in sorted({*radius.values()}):
            asked = [episode for episode in episodes if episode.id not in absent and radius[episode.id] == radius_m]
            there = {episode.id for episode in asked}
            yield from static_outcomes(
                asked,
                [prediction for prediction in of_arm if prediction.episode in there],
                radius_m=radius_m,
                samples=constants.single_visit.samples,
                seed=root_seed(episodes),
            )

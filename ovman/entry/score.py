"""`ovman score`: the static score of a file of predictions, by the functions that make the released tables.

Nothing heavy is imported: no simulator, no network, no data frame.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ovman.analysis.outcomes import Case, Outcome, static_outcomes
from ovman.analysis.rates import Rate, arm_rates
from ovman.entry import EntryError, tables
from ovman.entry.release import Baselines, Release, compare_with_baselines, rates_by_arm
from ovman.records.episode import Episode, root_seed
from ovman.records.prediction import Prediction
from ovman.records.record import records
from ovman.settings import Kind, Settings

SCHEMA = "ovman-static-score/1"
FORMS = ("x", "z", "abstain", "candidates", "box")
"""Keys of which a record has one, or "x" and "z"."""
EXPECTED = '"x" and "z" in metres, or "abstain" with a reason'

Run = tuple[str, int]
"""An arm and its seed."""


@dataclass(frozen=True, slots=True)
class Submitted:
    """The predictions of a file in its order. missing: For each run that lacks some, the episodes that it does not answer."""

    predictions: Sequence[Prediction]
    missing: Mapping[Run, Sequence[str]]


@dataclass(frozen=True, slots=True)
class StaticScore:
    """The static score of a file.

    Attributes:
        file: The file.
        of: The episodes, in words.
        split: The released split of the episodes, None for others.
        n: Number of episodes.
        radius_m: Distances to the answer within which a point succeeds, by the episodes' own protocols, ascending.
        rates: Of each arm of the file by relation, then all.
        missing: Number of missing episodes of each run (arm and seed) that lacks some. The rates are then of the episodes that
            all runs of the arm answer, and are not a score.
        baselines: With released arms and tests if the episodes are a released split and none is missing.
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

    Args:
        file: The predictions.
        release: Its settings give single_visit.samples, evaluation.confidence, comparisons and arms.
        split: Name of the split.
        episodes_file: Episodes instead of the split's. They have baselines if the bytes are those of a released split.
        partial: Whether rates are computed if episodes are missing.

    Raises:
        EntryError: The file cannot be judged.
        RecordError: A record is wrong.
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
    outcomes = [] if missing and not partial else list(_judge(episodes, submitted, release.settings))
    return StaticScore(
        file=file,
        of=of,
        split=of_split,
        n=len(episodes),
        radius_m=tuple(sorted({episode.protocol.success.radius_m for episode in episodes})),
        rates=arm_rates(outcomes, release.settings.evaluation.confidence),
        missing=missing,
        baselines=compare_with_baselines(outcomes, Kind.STATIC, of_split, release, not missing),
    )


def read_submitted(path: Path, episodes: Sequence[str], of: str) -> Submitted:
    """Read the predictions of a JSONL file, each for one of `episodes`.

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
            prediction = Prediction.from_json(_complete(value, path.stem, place), place)
            if prediction.episode not in known:
                raise EntryError(
                    f"{place}: episode: {prediction.episode!r} is none of {of}; {_remedy(prediction.episode, episodes)}"
                )
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
            f'{path}: holds no prediction; write a line an episode, {{"episode": "{episodes[0]}", "x": 0.5, "z": 1.5}}'
        )
    missing = {run: [one for one in episodes if one not in there] for run, there in answered.items()}
    return Submitted(predictions, {run: absent for run, absent in missing.items() if absent})


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
    for arm, rates in rates_by_arm(score.rates):
        partial = f"{arm}: PARTIAL, {rates[-1].n} of {score.n} episodes, no score"
        title = f"{arm}: {score.n} episodes" if score.is_whole else partial
        yield from ("", title, *tables.table(tables.rate_rows(rates, baselines.chance), markdown=False))
    if baselines.released:
        yield from (
            "",
            "beside it: success of the released arms on the same episodes, and p of McNemar's exact test against them",
        )
        yield from tables.table(tables.baseline_rows(score.rates, baselines, "this file"), markdown=False)
        yield from tables.remark_baselines(score.rates, baselines)
    elif baselines.entries:
        yield from ("", tables.ENTRIES, *tables.table(tables.entry_rows(baselines), markdown=False))
    elif score.is_whole:
        yield from ("", "beside it: nothing; the release has no static arms on these episodes")


def _judge(episodes: Sequence[Episode], submitted: Submitted, constants: Settings) -> Iterator[Outcome]:
    """Yield the outcomes of the answers of every run of an arm, by the radius of each episode's own protocol."""
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


def _complete(value: Any, arm: str, place: str) -> Any:
    """Return the record with the keys that may be left out. EntryError if it holds no answer."""
    if not isinstance(value, dict):
        return value
    if "episode" in value and not any(value.get(form) is not None for form in FORMS):
        others = [key for key in value if key not in Prediction.model_fields and key not in ("schema", "evidence")]
        near = [key for key in others for form in FORMS if difflib.get_close_matches(key.lower(), [form, f"{form}_m"], 1, 0.6)]
        key, remedy = (f"{near[0]}: ", f"rename {near[0]!r}") if near else ("", "add them")
        raise EntryError(f"{place}: {key}the record holds no answer; expected {EXPECTED}; {remedy}")
    return {"schema": "ovman-prediction/1", "arm": arm, "seed": 0} | value


def _remedy(episode: str, episodes: Sequence[str]) -> str:
    """Return the advice for an unknown id. The number of an episode of a further split begins with the split's name."""
    split = episode.rpartition("/")[2].rpartition("-")[0]
    if split and not any(one.rpartition("/")[2].startswith(f"{split}-") for one in episodes):
        return f"name its split, --split {split}"
    near = difflib.get_close_matches(episode, episodes, n=1)
    return f"write {near[0]!r}, or name another split with --split" if near else "name its split with --split"

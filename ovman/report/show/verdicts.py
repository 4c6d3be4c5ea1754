"""The answers of the arms with the verdicts of the metrics. Nothing is judged here."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from string import ascii_uppercase

from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Answer, Predicted, UniformBox, UniformPick
from ovman.records.run import Score
from ovman.report.show.results import Results
from ovman.settings import Arm, Kind
from ovman.task import Relation

Point = tuple[float, float]
FOUND, MISSED, CHANCE, ABSTAINED, UNKNOWN = "found", "missed", "chance", "abstained", "unknown"
"""Verdicts; CHANCE is that of a stochastic pick, UNKNOWN stands for a missing row of the metrics."""
REASONS: Mapping[str, str] = {
    "displacement_above_tau": "even the steadiest pair moved",
    "no_motion": "no track spreads far enough to be motion",
    "nothing_grounded": "no object of its maps is what the noun means",
    "not_parsed": "the sentence was not understood",
}


Pose = tuple[float, float, float]
"""x and z in metres, yaw in degrees."""


@dataclass(frozen=True, slots=True)
class Drive:
    """A run as it was driven again. poses: at the spawn, then after each action; empty without a trace."""

    run: Score
    poses: Sequence[Pose]


@dataclass(frozen=True, slots=True)
class StaticRow:
    """A run of an arm that predicts a point.

    letter: its name on the maps; answer: in words; verdict: one of the constants above; words: the verdict in more words;
    distance_m: from the answer; beside: the true instance nearest to the predicted point, and its distance; run: its number for
    an arm with several runs, else None.
    """

    letter: str
    arm: Arm
    outcome: Predicted | None
    answer: str
    verdict: str
    words: str
    distance_m: float | None
    beside: str
    run: int | None = None


@dataclass(frozen=True, slots=True)
class Stop:
    """A run of an embodied arm.

    at: (x, z) of the stop in metres, None without one; yaw_deg: heading at the stop; own_task: whether it was also judged on a
    task of its own.
    """

    seed: int
    at: Point | None
    yaw_deg: float
    verdict: str
    words: str
    own_task: bool = False


@dataclass(frozen=True, slots=True)
class EmbodiedRow:
    """The runs of an embodied arm. letter: its name on the maps."""

    letter: str
    arm: Arm
    stops: tuple[Stop, ...]


def static_rows(results: Results, episode: Episode) -> list[StaticRow]:
    """The static arms that answer the episode's split, in the order of the tables, those with several runs once a run."""
    predictions, relation = results.predictions(episode.id), episode.relation
    rows = []
    for letter, arm in _lettered(results, episode.split, Kind.STATIC):
        runs = predictions.get(arm.name, {})
        if not runs:
            command = results.command(episode.split)
            rows.append(StaticRow(letter, arm, None, "—", UNKNOWN, f"no prediction here: “{command}” makes it", None, ""))
        for run, prediction in runs.items():
            row = results.static_verdict(arm.name, run, episode.id)
            verdict, words, distance = _static(row, results.command(episode.split))
            outcome = prediction.outcome
            name, number = (f"{letter}{run}", run) if len(runs) > 1 else (letter, None)
            beside = _beside(outcome, episode)
            rows.append(StaticRow(name, arm, outcome, answer_words(outcome, relation), verdict, words, distance, beside, number))
    return rows


def embodied_rows(results: Results, episode: Episode) -> list[EmbodiedRow]:
    """The embodied arms that answer the episode's split, in the order of the tables; their letters follow the static arms'."""
    return [
        EmbodiedRow(letter, arm, tuple(stop_of(run, episode.relation.past) for run in results.runs(arm.name, episode).values()))
        for letter, arm in _lettered(results, episode.split, Kind.EMBODIED)
    ]


def letters(number: int) -> str:
    """The name of the arm with a number, from 0: A to Z, then AA, AB and so on, as columns of a spreadsheet."""
    before, last = divmod(number, len(ascii_uppercase))
    return (letters(before - 1) if before else "") + ascii_uppercase[last]


def _lettered(results: Results, split: str, kind: Kind) -> Iterator[tuple[str, Arm]]:
    """The arms of a kind that answer a split, with their letters, which run through the static arms first."""
    static, embodied = (results.asked(split, of) for of in (Kind.STATIC, Kind.EMBODIED))
    named = [(letters(number), arm) for number, arm in enumerate([*static, *embodied])]
    return (one for one in named if one[1].kind is kind)


def answer_words(outcome: Predicted, relation: Relation) -> str:
    """The answer of an arm in words; an abstention with its reason."""
    match outcome:
        case Answer(x, z):
            return f"({x:.2f}, {z:.2f})"
        case Abstention(reason):
            return f"abstains: {_why(str(reason), relation)}"
        case UniformPick(candidates):
            count = len(candidates)
            return f"one of {count} candidates" if count > 1 else "its only candidate" if count else "none: no candidate"
        case UniformBox(x_min, z_min, x_max, z_max):
            return f"anywhere in {x_max - x_min:.2f} × {z_max - z_min:.2f} m"
    raise TypeError(f"not an outcome of a prediction: {outcome!r}")


def _why(reason: str, relation: Relation) -> str:
    visit = "first" if relation.past else "second"
    unmatched = f"no object of the {visit} visit is left unmatched"
    if reason == AbstentionReason.DISPLACEMENT_BELOW_TAU:
        return f"{unmatched}, and no pair moved far enough"
    if reason == AbstentionReason.NO_COUNTERPART:
        return "several candidates, and nothing in the other visit to tell them apart by"
    if reason == AbstentionReason.NO_CANDIDATE:
        if relation is Relation.STABLE:
            return "nothing is matched"
        return f"{unmatched}, and nothing is matched" if relation in (Relation.MOVED, Relation.FORMER) else unmatched
    return REASONS.get(reason, reason.replace("_", " "))


def _static(row: Mapping[str, str] | None, command: str) -> tuple[str, str, float | None]:
    if row is None:
        return UNKNOWN, f"not judged yet: “{command}” judges it", None
    success = float(row["success"])
    if row["outcome"] == "abstained":
        return ABSTAINED, "abstained", None
    if row["outcome"] == "expected":
        return CHANCE, f"right with probability {success:.2f}", None
    distance = float(row["distance_m"])
    return (FOUND, "found", distance) if success == 1.0 else (MISSED, "missed", distance)


def stop_of(run: Score, past: bool) -> Stop:
    """Return the end of a run with its verdict in words. past: the answer is a place, and what is seen there is left out."""
    at = None if run.stop is None else (run.stop.x, run.stop.z)
    yaw = 0.0 if run.stop is None else run.stop.yaw_deg
    if run.outcome == "abstained":
        return Stop(run.seed, at, yaw, ABSTAINED, "abstained")
    ended = {"stopped": "", "budget": "out of actions, ", "stalled": "stalled, "}[run.outcome]
    away = "" if run.answer_distance_m is None else f"{run.answer_distance_m:.2f} m away · "
    seen = "" if past or not run.visible_px else f"sees {max(run.visible_px.values())} px · "
    own = "" if run.own_success is None else f" · any instance: {'found' if run.own_success else 'missed'}"
    weight = f" · SPL {run.spl:.2f}" if run.success else ""
    words = f"{ended}{away}{seen}{run.path_length_m:.2f} m, {run.actions} actions{weight}{own}"
    return Stop(run.seed, at, yaw, FOUND if run.success else MISSED, words, bool(own))


def _beside(outcome: Predicted, episode: Episode) -> str:
    """The true instance nearest to a predicted point, in the visit that the relation answers from."""
    if not isinstance(outcome, Answer):
        return ""
    world = episode.world_1 if episode.relation.past else episode.world_2
    gap, name = min((math.hypot(outcome.x - k.x, outcome.z - k.z), k.id) for k in world)
    called = "the target" if name == episode.target else "the distractor" if name == episode.distractor else "another instance"
    return f"{gap:.2f} m from {called}"

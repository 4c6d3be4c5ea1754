"""Describe the answers of the arms and the verdicts of the metrics. Nothing is judged here."""

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

FOUND, MISSED, CHANCE, ABSTAINED, UNKNOWN = "found", "missed", "chance", "abstained", "unknown"
"""Verdicts. CHANCE is that of a stochastic pick; UNKNOWN stands for a missing row of the metrics."""
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
    """A replayed run. poses: at the spawn, then after each action; empty without a trace."""

    run: Score
    poses: Sequence[Pose]


@dataclass(frozen=True, slots=True)
class StaticRow:
    """A run of an arm that predicts a point.

    Attributes:
        letter: The arm's name on the plans.
        arm: The arm.
        outcome: The prediction.
        answer: The prediction in words.
        verdict: One of the constants above.
        words: The verdict in more words.
        distance_m: From the answer.
        nearest: The true instance nearest to the predicted point, and its distance.
        run: Number of the run for an arm with several runs, else None.
    """

    letter: str
    arm: Arm
    outcome: Predicted | None
    answer: str
    verdict: str
    words: str
    distance_m: float | None
    nearest: str
    run: int | None = None


@dataclass(frozen=True, slots=True)
class Stop:
    """The end of a run. at: (x, z) in metres, None without a stop; own_task: whether it was also judged on its own task."""

    seed: int
    at: tuple[float, float] | None
    yaw_deg: float
    verdict: str
    words: str
    own_task: bool = False


@dataclass(frozen=True, slots=True)
class EmbodiedRow:
    """The runs of an arm that navigates. letter: its name on the plans."""

    letter: str
    arm: Arm
    stops: tuple[Stop, ...]


def list_static(results: Results, episode: Episode) -> list[StaticRow]:
    """Return the static arms that answer the episode's split in the order of the tables, one row per run."""
    predictions, command, rows = results.predictions(episode), results.command(episode.split), []
    for letter, arm in _assign_letters(results, episode.split, Kind.STATIC):
        runs = predictions.get(arm.name, {})
        if not runs:
            rows.append(StaticRow(letter, arm, None, "—", UNKNOWN, f"no prediction here: “{command}” makes it", None, ""))
        for run, prediction in runs.items():
            judged = results.static_verdict(arm.name, run, episode)
            verdict, words, distance = _describe_verdict(judged, command)
            outcome = prediction.outcome
            name, number = (f"{letter}{run}", run) if len(runs) > 1 else (letter, None)
            answer, nearest = _describe_outcome(outcome, episode.relation), _find_nearest(outcome, episode)
            rows.append(StaticRow(name, arm, outcome, answer, verdict, words, distance, nearest, number))
    return rows


def list_embodied(results: Results, episode: Episode) -> list[EmbodiedRow]:
    """Return the arms that navigate on the episode's split in the order of the tables; letters follow the static arms'."""
    rows = []
    for letter, arm in _assign_letters(results, episode.split, Kind.EMBODIED):
        runs = results.runs(arm.name, episode).values()
        rows.append(EmbodiedRow(letter, arm, tuple(describe_stop(run, episode.relation.past) for run in runs)))
    return rows


def _assign_letters(results: Results, split: str, kind: Kind) -> Iterator[tuple[str, Arm]]:
    """Yield the arms of a kind that answer a split with their letters, which run through the static arms first."""
    arms = [arm for of_kind in (Kind.STATIC, Kind.EMBODIED) for arm in results.arms_of(split, of_kind)]
    for number, arm in enumerate(arms):
        if arm.kind is kind:
            yield count_in_letters(number), arm


def count_in_letters(number: int) -> str:
    """Return A to Z for 0 to 25, then AA, AB and so on, as columns of a spreadsheet."""
    before, last = divmod(number, len(ascii_uppercase))
    return (count_in_letters(before - 1) if before else "") + ascii_uppercase[last]


def _describe_outcome(outcome: Predicted, relation: Relation) -> str:
    match outcome:
        case Answer(x, z):
            return f"({x:.2f}, {z:.2f})"
        case Abstention(reason):
            return f"abstains: {_describe_reason(str(reason), relation)}"
        case UniformPick(candidates):
            count = len(candidates)
            return f"one of {count} candidates" if count > 1 else "its only candidate" if count else "none: no candidate"
        case UniformBox(x_min, z_min, x_max, z_max):
            return f"anywhere in {x_max - x_min:.2f} × {z_max - z_min:.2f} m"
    raise TypeError(f"not an outcome of a prediction: {outcome!r}")


def _describe_reason(reason: str, relation: Relation) -> str:
    unmatched = f"no object of the {'first' if relation.past else 'second'} visit is left unmatched"
    if reason == AbstentionReason.DISPLACEMENT_BELOW_TAU:
        return f"{unmatched}, and no pair moved far enough"
    if reason == AbstentionReason.NO_COUNTERPART:
        return "several candidates, and nothing in the other visit to tell them apart by"
    if reason == AbstentionReason.NO_CANDIDATE:
        if relation is Relation.STABLE:
            return "nothing is matched"
        return f"{unmatched}, and nothing is matched" if relation in (Relation.MOVED, Relation.FORMER) else unmatched
    return REASONS.get(reason, reason.replace("_", " "))


def _describe_verdict(row: Mapping[str, str] | None, command: str) -> tuple[str, str, float | None]:
    """Return the verdict, the same in words, and the distance from the answer, of a row of the metrics."""
    if row is None:
        return UNKNOWN, f"not judged yet: “{command}” judges it", None
    success = float(row["success"])
    if row["outcome"] == "abstained":
        return ABSTAINED, "abstained", None
    if row["outcome"] == "expected":
        return CHANCE, f"right with probability {success:.2f}", None
    verdict = FOUND if success == 1.0 else MISSED
    return verdict, verdict, float(row["distance_m"])


def _find_nearest(outcome: Predicted, episode: Episode) -> str:
    """Return the true instance nearest to a predicted point, in the visit that the relation answers from."""
    if not isinstance(outcome, Answer):
        return ""
    world = episode.world_1 if episode.relation.past else episode.world_2
    gap, name = min((math.hypot(outcome.x - instance.x, outcome.z - instance.z), instance.id) for instance in world)
    role = "the target" if name == episode.target else "the distractor" if name == episode.distractor else "another instance"
    return f"{gap:.2f} m from {role}"


def describe_stop(run: Score, past: bool) -> Stop:
    """Return the end of a run with its verdict in words. past: the answer is a place, so what the agent sees is left out."""
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

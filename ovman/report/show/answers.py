"""Describe the answers of the arms and the verdicts of the metrics. Nothing is judged here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ovman.analysis.outcomes import EXPECTED, Outcome
from ovman.records.episode import Episode
from ovman.records.geometry import Point
from ovman.records.prediction import Abstention, Answer, Predicted, UniformBox, UniformPick
from ovman.records.run import Score
from ovman.report.show.results import Results
from ovman.settings import Arm, Kind, Source

FOUND, MISSED, CHANCE, ABSTAINED, UNKNOWN = "found", "missed", "chance", "abstained", "unknown"
"""Verdicts. CHANCE is that of a stochastic pick; UNKNOWN stands for a missing row of the metrics."""


@dataclass(frozen=True, slots=True)
class Line:
    """A prediction, or a run of an arm that navigates.

    Attributes:
        number: Of the run, or its seed.
        verdict: One of the constants above.
        words: The answer and the verdict in more words.
        at: Predicted point or stop, (x, z) in metres.
        yaw_deg: At the stop.
        path: Positions of a replayed run, from the spawn.
        outcome: The prediction.
    """

    number: int
    verdict: str
    words: str
    at: Point | None = None
    yaw_deg: float | None = None
    path: Sequence[Point] = ()
    outcome: Predicted | None = None


@dataclass(frozen=True, slots=True)
class Entry:
    """An arm, or a user's own agent, with its lines. key: identifier in the page; is_shown: on the plan at first."""

    key: str
    title: str
    about: str
    is_control: bool
    is_shown: bool
    lines: tuple[Line, ...]


def list_entries(results: Results, episode: Episode, kind: Kind) -> list[Entry]:
    """Return the arms of a kind with their answers to an episode, in the order of the tables; none without answers."""
    titles, entries = shown_titles(results), []
    for arm in results.arms(episode, kind):
        if kind is Kind.STATIC:
            predictions = results.predictions(arm.name, episode)
            lines = [describe_prediction(one.seed, one.outcome, row, episode) for one, row in predictions]
        else:
            lines = [describe_run(run, episode) for run in results.runs(arm.name, episode)]
        if lines:
            title = titles.get(arm.name, arm.system)
            entries.append(Entry(arm.name, title, describe_arm(arm), arm.control, arm.name in titles, tuple(lines)))
    return entries


def shown_titles(results: Results) -> dict[str, str]:
    """Return the titles of the arms that the plan shows at first, the reference agent and the joint agent."""
    comparisons = results.settings.comparisons
    agents = {comparisons.agent, *(name for name, entry in comparisons.controls.items() if entry.role == "joint")}
    systems = {title: system for title, system in comparisons.overview.items() if system.static in agents}
    return {arm: title for title, system in systems.items() for arm in (system.static, system.embodied) if arm is not None}


def describe_prediction(run: int, outcome: Predicted, judged: Outcome | None, episode: Episode) -> Line:
    """Return a prediction with its verdict in the metrics."""
    answer, at = "", None
    match outcome:
        case Answer(x, z):
            answer, at = f"({x:.2f}, {z:.2f}), {_describe_nearest((x, z), episode)}", (x, z)
        case Abstention(reason):
            answer = reason.replace("_", " ")
        case UniformPick(candidates):
            answer = f"one of {len(candidates)} candidates"
        case UniformBox(x_min, z_min, x_max, z_max):
            answer = f"anywhere in {x_max - x_min:.2f} × {z_max - z_min:.2f} m"
    if judged is None:
        verdict, says = UNKNOWN, "not judged here"
    elif judged.outcome == "abstained":
        verdict, says = ABSTAINED, "abstained"
    elif judged.outcome == EXPECTED:
        verdict, says = CHANCE, f"right with probability {judged.success:.2f}"
    else:
        verdict, says = FOUND if judged.success == 1.0 else MISSED, f"{judged.distance_m:.2f} m away"
    return Line(run, verdict, f"{says} · {answer}", at, outcome=outcome)


def describe_run(run: Score, episode: Episode, path: Sequence[Point] = ()) -> Line:
    """Return a run with its verdict. If the answer is a place, no object has to be seen, so its pixels are left out."""
    at, yaw = (None, None) if run.stop is None else ((run.stop.x, run.stop.z), run.stop.yaw_deg)
    says: list[str] = [] if run.outcome == "stopped" else ["out of actions" if run.outcome == "budget" else run.outcome]
    if run.answer_distance_m is not None:
        says.append(f"{run.answer_distance_m:.2f} m away")
        if run.rival_distance_m is not None and run.rival_distance_m <= run.answer_distance_m:
            says.append(f"a wrong answer is nearer, {run.rival_distance_m:.2f} m")
    if run.visible_px and not episode.relation.past:
        says.append(f"sees {max(run.visible_px.values())} px")
    says.append(f"{run.path_length_m:.2f} m, {run.actions} actions")
    if run.success:
        says.append(f"SPL {run.spl:.2f}")
    if run.own_success is not None:
        says.append(f"any instance: {'found' if run.own_success else 'missed'}")
    verdict = ABSTAINED if run.outcome == "abstained" else FOUND if run.success else MISSED
    return Line(run.seed, verdict, " · ".join(says), at, yaw, path)


def describe_arm(arm: Arm) -> str:
    """Return what an arm remembers and what of the truth it is given."""
    handed = {"oracle grounding": arm.grounding, "oracle positions": arm.positions}
    return ", ".join([arm.memory, *(words for words, source in handed.items() if source is Source.HANDED)])


def _describe_nearest(point: Point, episode: Episode) -> str:
    """Return the true instance nearest to a predicted point, in the visit that the relation answers from."""
    world = episode.world_1 if episode.relation.past else episode.world_2
    gap, name = min((math.dist(point, instance.position), instance.id) for instance in world)
    role = {episode.target: "the target", episode.distractor: "the distractor"}.get(name, "another instance")
    return f"{gap:.2f} m from {role}"

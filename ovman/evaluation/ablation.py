"""Variants of an episode: its scripted change with some of what its split adds to the paper's protocol, and no more. Pure.

A split may add changes of other categories, a second tour of its own, another light, and sensors that err. What each of
them costs an agent is seen on the same episodes with one of them in force at a time. Query, answer and spawn stay; nothing is
certified anew.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.sighting import VisitPair
from ovman.records.tour import Tour
from ovman.records.variant import VARIANTS, Setting
from ovman.sim.visit import mover_seed, visit_name


def variant(episode: Episode, kept: Collection[Setting]) -> Episode:
    """The episode with those of its split's settings that are `kept`; of the same id, with names of visits that fit."""
    others = Setting.OTHERS in kept
    changes = tuple(change for change in episode.changes if others or change.category == episode.category)
    instances = {change.instance for change in changes}
    first, second = (_tour(episode, which, kept) for which in ("first", "second"))
    made = episode.model_copy(
        update={
            "changes": changes,
            "movers": tuple(mover for mover in episode.movers if mover.instance in instances),
            "drift_m": {instance: metres for instance, metres in episode.drift_m.items() if instance in instances},
            "tours": VisitPair[Tour](first=first, second=second),
        }
    )
    names = [_visit(made, which) for which in ("first", "second")]
    return made.model_copy(update={"visits": VisitPair[str](first=names[0], second=names[1])})


def _tour(episode: Episode, which: str, kept: Collection[Setting]) -> Tour:
    own = episode.tours[which]
    walked = own if Setting.SECOND_TOUR in kept else episode.tours.first
    return Tour(
        waypoints=walked.waypoints,
        headings=walked.headings,
        first_yaw_deg=walked.first_yaw_deg,
        light=own.light if Setting.LIGHT in kept else None,
        sensors=own.sensors if Setting.SENSORS in kept else None,
    )


def _visit(episode: Episode, which: str) -> str:
    """Name of a visit of an episode, as trials name visits: equal visits of a scene share it."""
    alterations, tour = episode.alterations(which), episode.tours[which]
    seed = mover_seed(episode.provenance.seed, episode.id, alterations)
    return visit_name(alterations, seed, tour, episode.tours.first.waypoints)


def run(episodes_file: Path, outputs: Mapping[str, Path]) -> None:
    """Write every variant of the episodes of a file, by its name."""
    episodes = Episode.load(episodes_file)
    for name, output in outputs.items():
        output.write_text(lines([variant(episode, VARIANTS[name]) for episode in episodes]), encoding="utf-8")

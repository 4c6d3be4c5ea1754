"""Variants of an episode: its scripted change with some of what its split adds to the paper's protocol, and no more.

A split may add changes of other categories, a second tour of its own, another light, and sensors that err. Each variant has one
of them in force, which shows its cost to an agent on the same episodes. Query, answer and spawn stay; nothing is certified again.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ovman.agents.interface import VISITS
from ovman.cache import digest
from ovman.evaluation.tours import record_tour, tour_key
from ovman.processes import map_items
from ovman.records.episode import VARIANTS, Episode, Setting
from ovman.records.record import lines
from ovman.records.tour import Tour
from ovman.records.visit import VisitFiles, VisitManifest, VisitPair, kept
from ovman.settings import Settings
from ovman.sim.session import AgentPose, Session
from ovman.sim.visit import mover_seed, visit_name


def write_variants(episodes_file: Path, outputs: Mapping[str, Path]) -> None:
    """Write every variant of the episodes of a file, by its name."""
    episodes = Episode.load(episodes_file)
    for name, output in outputs.items():
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(lines([make_variant(episode, VARIANTS[name]) for episode in episodes]), encoding="utf-8")


def make_variant(episode: Episode, kept_settings: Collection[Setting]) -> Episode:
    """Return the episode with only these of its split's settings, under the same id, with names of visits that fit."""
    others = Setting.OTHERS in kept_settings
    changes = tuple(change for change in episode.changes if others or change.category == episode.category)
    instances = {change.instance for change in changes}
    first, second = (_tour(episode, which, kept_settings) for which in VISITS)
    variant = episode.model_copy(
        update={
            "changes": changes,
            "movers": tuple(mover for mover in episode.movers if mover.instance in instances),
            "drift_m": {instance: metres for instance, metres in episode.drift_m.items() if instance in instances},
            "tours": VisitPair[Tour](first=first, second=second),
        }
    )
    names = [_visit_name(variant, which) for which in VISITS]
    return variant.model_copy(update={"visits": VisitPair[str](first=names[0], second=names[1])})


def record_tours(
    settings: Settings, episode_files: Sequence[Path], visits: Path, manifest: Path, workers: int = 1, code: str = ""
) -> None:
    """Record the tours of all variants, and write one manifest row per scene. Equal visits are recorded once.

    Tours that are there and whole are kept.

    Args:
        settings: measurement.min_mask_px and benchmark.backend.
        episode_files: The episodes of the variants.
        visits: Directory of the recorded visits of all scenes.
        manifest: File of the manifest.
        workers: Number of processes, which share the scenes.
        code: Digest of the code, which is a part of each tour's key.

    Raises:
        SimulatorError: The simulator refuses.
    """
    scenes = sorted({episode.scene for file in episode_files for episode in Episode.load(file)})
    rows = map_items(partial(record_scene, settings, tuple(episode_files), visits, code), scenes, workers)
    manifest.write_text("".join(rows), encoding="utf-8")


def record_scene(settings: Settings, episode_files: Sequence[Path], visits: Path, code: str, scene: str) -> str:
    """Record the tours of a scene's episodes under `visits`, one directory per visit, and return the line of its manifest."""
    tours: dict[str, str] = {}
    episodes = [episode for file in episode_files for episode in Episode.load(file, scene)]
    made_by = digest(settings.constants(), code)
    with Session(scene, episodes[0].settings) as session:
        for episode in episodes:
            for which in VISITS:
                name = episode.visits[which]
                if name not in tours:
                    _record_if_missing(session, episode, which, visits / scene, settings.measurement.min_mask_px, made_by)
                    tours[name] = VisitFiles.load(visits / scene / name).content
    print(f"{scene}: {len(tours)} tours of {len(episodes)} variants of episodes", flush=True)
    return VisitManifest(scene=scene, visits=dict(sorted(tours.items()))).to_line()


def nearest_free(session: Session, pose: AgentPose) -> AgentPose:
    """Return the pose itself if it is free, else the same at the nearest reachable position; the first of equal ones.

    The second visit of a variant may have the first one's waypoints, and a displaced object may stand on one.
    """
    if session.teleport(pose, allowed=True):
        return pose
    x, z = min(sorted(session.reachable()), key=lambda point: math.dist(point, (pose.x, pose.z)))
    return replace(pose, x=x, z=z)


def _record_if_missing(session: Session, episode: Episode, which: str, visits: Path, min_mask_px: int, made_by: str) -> None:
    if not kept(visits / episode.visits[which], tour_key(episode, which, min_mask_px, made_by)):
        place_view = partial(nearest_free, session)
        session.with_restarts(partial(record_tour, session, episode, which, visits, min_mask_px, made_by, place_view))


def _tour(episode: Episode, which: str, kept_settings: Collection[Setting]) -> Tour:
    own = episode.tours[which]
    toured = own if Setting.SECOND_TOUR in kept_settings else episode.tours.first
    return Tour(
        waypoints=toured.waypoints,
        headings=toured.headings,
        first_yaw_deg=toured.first_yaw_deg,
        light=own.light if Setting.LIGHT in kept_settings else None,
        sensors=own.sensors if Setting.SENSORS in kept_settings else None,
    )


def _visit_name(episode: Episode, which: str) -> str:
    """Return the name of a visit of an episode, as trials name visits: equal visits of a scene share it."""
    alterations, tour = episode.alterations(which), episode.tours[which]
    seed = mover_seed(episode.provenance.seed, episode.id, alterations)
    return visit_name(alterations, seed, tour, episode.tours.first.waypoints)

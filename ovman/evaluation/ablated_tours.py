"""Stage `ablated_tours`: the tours of all variants of a scene's episodes, recorded. Equal visits are recorded once.

The second visit of a variant may have the first one's waypoints, and what was displaced may stand on one. Such a waypoint gives
way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ovman.evaluation.tours import record_tour, tour_key
from ovman.records.episode import Episode
from ovman.records.visit_files import VisitFiles, VisitManifest, kept
from ovman.sim.session import AgentPose, Session
from ovman.workflow.parameter import StageSettings


def run(scene: str, episode_files: Sequence[Path], constants: StageSettings, visits: Path, manifest_out: Path) -> None:
    """Record the tours of the scene's episodes under `visits`, a directory a visit, and write their manifest.

    Tours that are there and whole are kept. constants: measurement.min_mask_px and benchmark.backend; the rest is each episode's.
    SimulatorError where the simulator refuses.
    """
    tours: dict[str, str] = {}
    episodes = [episode for file in episode_files for episode in Episode.load(file, scene)]
    if episodes:
        with Session(scene, episodes[0].settings) as session:
            for episode in episodes:
                for which in ("first", "second"):
                    name = episode.visits[which]
                    if name not in tours:
                        _recorded(session, episode, which, visits, constants)
                        tours[name] = VisitFiles.load(visits / name).content
    manifest = VisitManifest(scene=scene, visits=dict(sorted(tours.items())))
    manifest_out.write_text(manifest.to_line(), encoding="utf-8")
    print(f"{scene}: {len(tours)} tours of {len(episodes)} variants of episodes", flush=True)


def _recorded(session: Session, episode: Episode, which: str, visits: Path, constants: StageSettings) -> None:
    min_mask_px, made_by = constants.measurement.min_mask_px, constants.canonical
    if not kept(visits / episode.visits[which], tour_key(episode, which, min_mask_px, made_by)):
        standing = partial(nearest_free, session)
        session.with_restarts(partial(record_tour, session, episode, which, visits, min_mask_px, made_by, standing))


def nearest_free(session: Session, pose: AgentPose) -> AgentPose:
    """The pose itself where it is free, else the same at the nearest position that can be reached; the first of equal ones."""
    if session.teleport(pose, allowed=True):
        return pose
    x, z = min(sorted(session.reachable()), key=lambda point: math.dist(point, (pose.x, pose.z)))
    return replace(pose, x=x, z=z)

"""The tours of an episode, recorded anew from its record alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ovman import seeds
from ovman.records.episode import Episode
from ovman.records.visit import Visit
from ovman.sim import visit
from ovman.sim.change import World, dynamic
from ovman.sim.session import AgentPose, Session
from ovman.workflow.journal import digest


def tour_key(episode: Episode, which: str, min_mask_px: int, made_by: str = "") -> str:
    """Key of the recording of an episode's visit "first" or "second". made_by: what else it follows from."""
    alterations = [alteration.to_json() for alteration in episode.alterations(which)]
    return digest(episode.scene, episode.visits[which], alterations, min_mask_px, *filter(None, [made_by]))


def record_tour(
    session: Session,
    episode: Episode,
    which: str,
    directory: Path,
    min_mask_px: int = 1,
    made_by: str = "",
    standing: Callable[[AgentPose], AgentPose] | None = None,
) -> Visit:
    """Tours the home in the visit "first" or "second" of an episode and records the frames in `directory`, named as the visit.

    session: on the episode's scene with the benchmark's body, as `ovman.evaluation.rollouts.session_for` makes it for an arm
    without a body of its own. min_mask_px: masks of fewer pixels are not recorded as seen. Movers draw as they did when the
    episode was made, so the tour ends in the state in which a run begins. made_by: as for `tour_key`. standing: as for
    `visit.record`. SimulatorError if the simulator refuses.
    """
    alterations, name = episode.alterations(which), episode.visits[which]
    rng = seeds.generator(episode.provenance.seed, *seeds.tour_movers(episode.id))
    world = World(session, alterations, episode.protocol.mover, rng, dynamic)
    views = visit.views(episode.tours[which])
    key = tour_key(episode, which, min_mask_px, made_by)
    tour = episode.tours[which]
    at = directory / name
    return visit.record(session, world, name, alterations, views, min_mask_px, at, key, tour.light, tour.sensors, standing)

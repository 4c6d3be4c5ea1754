"""The tours of an episode, recorded anew from its record alone."""

from __future__ import annotations

from pathlib import Path

from ovman.models.episode import Episode
from ovman.models.visit import Visit
from ovman.sim import visit
from ovman.sim.change import World, dynamic
from ovman.sim.session import Session
from ovman.workflow import seeds
from ovman.workflow.journal import digest


def record_tour(session: Session, episode: Episode, which: str, directory: Path, min_mask_px: int = 1) -> Visit:
    """Tours the home in the visit "first" or "second" of an episode and records the frames in `directory`, named as the visit.

    session: on the episode's scene with the benchmark's body, as `ovman.evaluation.rollouts.session_for` makes it for an arm
    without a body of its own. min_mask_px: masks of fewer pixels are not recorded as seen. Movers draw as they did when the
    episode was made, so the tour ends in the state in which a run begins. SimulatorError if the simulator refuses.
    """
    alterations, name = episode.alterations(which), episode.visits[which]
    rng = seeds.generator(episode.provenance.seed, "mover", episode.id, "tour")
    world = World(session, alterations, episode.protocol.mover, rng, dynamic)
    views = visit.views(episode.tours[which])
    key = digest(episode.scene, name, [alteration.to_json() for alteration in alterations], min_mask_px)
    tour = episode.tours[which]
    return visit.record(session, world, name, alterations, views, min_mask_px, directory / name, key, tour.light, tour.sensors)

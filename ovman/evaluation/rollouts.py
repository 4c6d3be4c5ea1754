"""Stage `rollouts`: the embodied arms run the released episodes of a scene, measured at the stop. Nothing is judged here.

An episode runs from its record alone; an arm that is given positions needs the episode's sightings, too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS, CameraPose, Observation, PrivilegedAnswer, SeenInstance, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import RolloutContext, agent_settings, run_settings
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.predictions import VISITS as RECORDED
from ovman.evaluation.predictions import predict, sightings_of, store_of
from ovman.evaluation.rollout import Limits, alias, roll_out
from ovman.evaluation.supervision import Supervised, failures, function
from ovman.models.episode import Episode
from ovman.models.prediction import Prediction
from ovman.models.record import lines
from ovman.models.relation import Relation
from ovman.models.run import Rollout
from ovman.models.settings import Source
from ovman.models.settings.arms import ArmJob
from ovman.models.sighting import Sighting, Sightings
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from ovman.workflow import seeds
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings


def session_for(episode: Episode, arm: ArmJob, settings: StageSettings) -> Session:
    """A session on the scene of an episode, with the body that an arm names. A context manager."""
    measured_by = run_settings(episode, settings)
    return Session(episode.scene, measured_by, Embodiment.named(arm.embodiment, measured_by))


def run_episode(
    session: Session,
    episode: Episode,
    arm: ArmJob,
    seed: int,
    settings: StageSettings,
    store: ObservationStore | None = None,
    sightings: Sightings | None = None,
) -> Rollout:
    """One run of an embodied arm on an episode.

    session: as `session_for` makes it. settings: of the stage `rollouts` for a job of the arm. store: of the episode's scene, for
    an arm that needs tours, maps or networks. sightings: of the episode, for an arm that is given positions. Nothing else is
    read: the run follows from the episode. AgentError, in one line, where the agent fails; ValueError where sightings are
    missing.
    """
    lens = episode.protocol.camera.field_of_view_deg
    store = ObservationStore(arm, settings, lens, RECORDED / episode.scene) if store is None else store

    def draws(of: str) -> np.random.Generator:
        return seeds.generator(episode.provenance.seed, of, arm.name, episode.id, seed)

    def name_of(instance: str) -> str:
        return alias(episode.visits.second, instance)

    def tour(which: str, reachable: np.ndarray) -> Visit:
        if arm.positions is not Source.HANDED:
            return store.visit(episode.visits[which], reachable)
        if arm.answer is Source.HANDED:
            return Visit((), reachable)
        if sightings is None:
            raise ValueError(f"arms.{arm.name} is given positions: it needs the sightings of {episode.id}")
        seen = sightings.sightings[which]
        return _true_tour(episode.visits[which], seen, episode.category, settings.admissibility.min_mask_px, reachable)

    privileged = None
    if arm.answer is Source.HANDED:
        follow = name_of(episode.target) if episode.relation is Relation.MOVING else None
        privileged = PrivilegedAnswer(episode.answer, follow)
    pilot = Pilot(episode.protocol.primitives, draws("paths"))
    context = RolloutContext(draws("picks"), agent_settings(episode, settings), pilot, store, privileged)
    made = function(arm.name, arm.agent)
    with failures(f"arms.{arm.name}.agent is {arm.agent!r}: it"):
        agent = made(context)
    second = episode.tours.second  # a run meets its light, and its own sensors err as those of the tour do
    sensed = seeds.integer(episode.provenance.seed, "sensors", arm.name, episode.id, seed)
    measured = roll_out(
        session,
        episode,
        Supervised(agent, arm, f"{episode.id}, seed {seed}"),
        tour("first", np.empty((0, 2))),
        lambda cells: tour("second", cells),
        name_of if arm.positions is Source.HANDED else None,
        draws("mover"),
        run_settings(episode, settings),
        Limits(arm.budget, arm.marks, arm.any_instance),
        seeds.integer(episode.provenance.seed, "actuation", arm.name, episode.id, seed) if session.embodiment.noisy else None,
        second.light,
        None if second.sensors is None else second.sensors.model_copy(update={"seed": sensed}),
    )
    return Rollout(episode=episode.id, arm=arm.name, seed=seed, **dict(measured))


def _true_tour(visit: str, sightings: Sequence[Sighting], category: str, min_mask_px: int, reachable: np.ndarray) -> Visit:
    """A recorded visit for an agent that is given positions: which instances each view recorded, and where."""
    views: dict[int, list[SeenInstance]] = {}
    for seen in sightings:
        if seen.px >= min_mask_px:
            views.setdefault(seen.view, []).append(SeenInstance(alias(visit, seen.instance), category, seen.x, seen.z))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)


DECIDING = ("admissibility.",)
"""Constants that say what an agent is given; what becomes of its answer does not depend on them."""
JUDGING: Mapping[str, Any] = {
    "split": True,
    "instances_in_category": True,
    "shortest_path_m": True,
    "world_1": True,
    "world_2": True,
    "drift_m": True,
    "certification": True,
    "protocol": {"success": {"radius_m", "visible_px"}},
    "provenance": {"trial"},
}
"""Fields of an episode that judge a run or say where the episode comes from: no run depends on them."""


def cache_key(
    arm: ArmJob,
    seed: int,
    episode: Episode,
    settings: StageSettings,
    store: ObservationStore,
    sightings: Sightings | None = None,
) -> str:
    """Key of a run in the journal: all that it depends on.

    Of an arm that executes another one's answer, that answer stands for perception and for the constants of the decision: a
    threshold of the agent that changes none of its answers starts no simulator.
    """
    stage = json.loads(settings.canonical)
    executed = stage["arm"].pop("executed", None)
    run_on = episode.model_dump(mode="json", by_alias=True, exclude=dict(JUDGING))
    if executed is None:
        visits = [episode.visits[which] for which in VISITS]
        known = None if sightings is None else sightings.to_json()
        return digest(seed, run_on, store.cache_key(visits, episode.noun), known, stage)
    outcome, _ = predict(ArmJob.model_validate(executed), episode, settings, store, sightings)
    answered = Prediction.of(episode.id, arm.name, seed, outcome).model_dump(mode="json", by_alias=True)
    of_agent = set(stage.pop("of_agent"))
    stage["constants"] = {k: v for k, v in stage["constants"].items() if k not in of_agent and not k.startswith(DECIDING)}
    stage["agent"] = stage["agent"][:1]
    return digest(seed, run_on, answered, stage)


def run(
    arm: ArmJob,
    scene: str,
    episodes_file: Path,
    settings: StageSettings,
    outputs: Mapping[int, Path],
    journal: Path,
    sightings_file: Path | None = None,
    visits: Path = RECORDED,
    files: Mapping[str, Sequence[Path]] = {},
) -> None:
    """Run an arm on the episodes of a scene under every seed of `outputs` (seed -> file); `journal` keeps finished runs.

    sightings_file: of the episodes, for an arm that reads it. visits: directory of all scenes' recorded visits. files: what was
    perceived, as for `ovman.evaluation.predictions.run`.
    """
    episodes = [episode for episode in Episode.load(episodes_file) if episode.scene == scene]
    sightings = sightings_of(arm, sightings_file)
    stores: dict[tuple[str, float], ObservationStore] = {}
    kept = Journal(journal)
    made: dict[int, list[Rollout]] = {seed: [] for seed in outputs}

    def rollout(session: Session, episode: Episode, seed: int) -> Rollout:
        store, seen = store_of(arm, episode, settings, visits, files, stores), sightings.get(episode.id)

        def work() -> Rollout:
            return run_episode(session, episode, arm, seed, settings, store, seen)

        key = cache_key(arm, seed, episode, settings, store, seen)
        return Rollout.from_json(kept.unit(key, lambda: session.with_restarts(work).to_json()), f"{journal}: {key}")

    for _, alike in groupby(episodes, key=lambda episode: (episode.backend, episode.protocol)):
        group = list(alike)
        with session_for(group[0], arm, settings) as session:
            for episode in group:  # all seeds of one: the simulator keeps the last few worlds
                for seed in outputs:
                    record = rollout(session, episode, seed)
                    made[seed].append(record)
                    print(f"{episode.id} {arm.name} seed {seed}: {record.outcome} after {record.actions} actions", flush=True)
    for seed, output in outputs.items():
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(lines(made[seed]), encoding="utf-8")

"""Stage `rollouts`: the embodied arms run the released episodes of some scenes, measured at the stop. Nothing is judged here.

An episode runs from its record alone; an arm that is given positions needs the episode's sightings, too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS
from ovman.evaluation.attempt import run_episode, session_for
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.predictions import VISITS as RECORDED
from ovman.evaluation.predictions import predict, sightings_of, store_of
from ovman.progress import Units
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer, Predicted, Prediction
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.records.sighting import Sightings
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

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
    answered: Predicted | None = None,
) -> str:
    """Key of a run in the journal: all that it depends on.

    Of an arm that executes another one's answer, that answer stands for perception and for the constants of the decision: a
    threshold of the agent that changes none of its answers starts no simulator. answered: that answer, where its prediction is at
    hand; else it is decided here.
    """
    stage = json.loads(settings.canonical)
    executed = stage["arm"].pop("executed", None)
    run_on = episode.model_dump(mode="json", by_alias=True, exclude=dict(JUDGING))
    if executed is None:
        visits = [episode.visits[which] for which in VISITS]
        known = None if sightings is None else sightings.to_json()
        return digest(seed, run_on, store.cache_key(visits, episode.noun), known, stage)
    if answered is None:
        answered, _ = predict(ArmJob.model_validate(executed), episode, settings, store, sightings)
    goal = Prediction.of(episode.id, arm.name, seed, answered).model_dump(mode="json", by_alias=True)
    of_agent = set(stage.pop("of_agent"))
    stage["constants"] = {k: v for k, v in stage["constants"].items() if k not in of_agent and not k.startswith(DECIDING)}
    stage["agent"] = stage["agent"][:1]
    return digest(seed, run_on, goal, stage)


def run(
    arm: ArmJob,
    episodes_file: Path,
    settings: StageSettings,
    outputs: Mapping[str, Mapping[int, Path]],
    journals: Mapping[str, Path],
    sightings_file: Path | None = None,
    visits: Path = RECORDED,
    files: Mapping[str, Sequence[Path]] = {},
    predictions: Path | None = None,
) -> None:
    """Run an arm on the episodes of some scenes under some seeds. One simulator serves all episodes that may share it.

    outputs: scene -> seed -> file. journals: keep the finished runs, by scene. sightings_file: of the episodes, for an arm that
    reads it. visits: directory of all scenes' recorded visits. files: what was perceived, as for
    `ovman.evaluation.predictions.run`. predictions: of the arm that this one executes, one an episode; an agent is offered its
    answer. An episode without one is decided here.
    """
    episodes = [episode for scene in outputs for episode in Episode.load(episodes_file, scene)]
    sightings = sightings_of(arm, sightings_file)
    answers = {} if predictions is None else {one.episode: one.outcome for one in Prediction.read(predictions)}
    kept = {scene: Journal(journals[scene]) for scene in outputs}
    made: dict[str, dict[int, list[Rollout]]] = {scene: {seed: [] for seed in of_seeds} for scene, of_seeds in outputs.items()}
    units = Units(sum(len(made[episode.scene]) for episode in episodes))

    def rollout(session: Session, episode: Episode, seed: int, stores: dict[tuple[str, float], ObservationStore]) -> Rollout:
        store, seen = store_of(arm, episode, settings, visits, files, stores), sightings.get(episode.id)
        answered = answers.get(episode.id)
        offered = answered if isinstance(answered, Answer | Abstention) else None

        def work() -> Rollout:
            return run_episode(session, episode, arm, seed, settings, store, seen, answered=offered)

        key, journal = cache_key(arm, seed, episode, settings, store, seen, answered), kept[episode.scene]
        return Rollout.from_json(journal.unit(key, lambda: session.with_restarts(work).to_json()), f"{journal.path}: {key}")

    for _, alike in groupby(episodes, key=lambda episode: (episode.backend, episode.protocol)):
        group = list(alike)
        with session_for(group[0], arm, settings) as session:
            for scene, of_scene in groupby(group, key=lambda episode: episode.scene):
                session.scene = scene
                stores: dict[tuple[str, float], ObservationStore] = {}  # what was seen of one scene alone is held
                for episode in of_scene:  # all seeds of one: the simulator keeps the last few worlds
                    for seed, records in made[scene].items():
                        records.append(rollout(session, episode, seed, stores))
                        said = f"{records[-1].outcome} after {records[-1].actions} actions"
                        units.done(f"{episode.id} {arm.name} seed {seed}: {said}")
    for scene, of_seeds in outputs.items():
        for seed, output in of_seeds.items():
            output.parent.mkdir(parents=True, exist_ok=True)
            output.write_text(lines(made[scene][seed]), encoding="utf-8")

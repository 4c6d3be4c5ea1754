"""Stage `rollouts`: an embodied arm runs the episodes of a split, measured at the stop. Nothing is judged here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS
from ovman.cache import Cache, digest
from ovman.evaluation import observations
from ovman.evaluation.observations import ObservationStore, store_opener
from ovman.evaluation.predictions import predict, read_sightings
from ovman.processes import Units, WorkerDied, map_items
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer, Predicted, Prediction
from ovman.records.run import Rollout
from ovman.runner import Run, open_session, run_episode
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.settings.settings import matching, own_constants
from ovman.sim.session import Session

DECIDING = ("admissibility.*",)
"""Constants that say what an agent is given. What becomes of its answer does not depend on them."""
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
"""Fields of an episode that judge a run or say where the episode comes from. No run depends on them."""


def run(
    arm: ArmJob,
    settings: Settings,
    episodes_file: Path,
    seeds: Sequence[int],
    output: Path,
    cache: Cache,
    perceived: Mapping[str, Path] = {},
    sightings_file: Path | None = None,
    predictions_file: Path | None = None,
    visits: Path = observations.VISITS,
    workers: int = 1,
) -> None:
    """Run an arm on all episodes under all seeds. Write one row per run to `output`: seed by seed, in the episodes' order.

    cache: Keeps finished runs. A scene whose runs are all there starts no simulator. perceived: Directories with a file of each
    scene, "maps", "dualmap", "detections", "segments", and the file "nouns". predictions_file: Of the arm that this one executes,
    one per episode, which is offered to the agent. An episode without one is decided again. visits: Directory of the recorded
    visits of all scenes. workers: Processes, which share the scenes.
    """
    episodes = Episode.load(episodes_file)
    scenes = list(dict.fromkeys(episode.scene for episode in episodes))
    opener = partial(store_opener, arm, settings, visits, perceived)  # called in each process: what it returns cannot be sent
    of_scene = partial(_run_scene, arm, settings, episodes_file, seeds, cache, opener, sightings_file, predictions_file)
    try:
        by_scene = map_items(of_scene, scenes, workers)
    except WorkerDied as died:
        raise WorkerDied(f"{arm.name}: {died}") from None
    rows = {(row.episode, row.seed): row for some in by_scene for row in some}
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text("".join(rows[one.id, seed].to_line() for seed in seeds for one in episodes), encoding="utf-8")


def rollout_key(run: Run, answered: Predicted | None = None) -> str:
    """Return the key of a run in the cache: a digest of everything that it depends on, except for code.

    For an arm that executes another one's answer, that answer stands for perception and for the constants of the decision: a
    threshold of the agent that changes none of its answers starts no simulator.

    answered: The answer of the executed arm, if its prediction is known; it is decided here if not.
    """
    episode, arm, constants = run.episode, run.arm, run.settings.constants()
    played = episode.model_dump(mode="json", by_alias=True, exclude=dict(JUDGING))
    if rivals := episode.rivals():  # positions in the worlds, which are judged by, and here measured
        played["rivals"] = rivals
    entry = arm.model_dump(mode="json", exclude={"executed"})
    assert run.store is not None
    if arm.executed is None:
        seen = run.store.cache_key([episode.visits[which] for which in VISITS], run.asked.phrase)
        known = None if run.sightings is None else run.sightings.to_json()
        return digest(run.seed, played, seen, known, entry, constants, asdict(run.asked))
    if answered is None:
        answered, _ = predict(arm.executed, episode, run.settings, run.store, run.sightings)
    goal = Prediction.of(episode.id, arm.name, run.seed, answered).model_dump(mode="json", by_alias=True)
    deciding = matching((*DECIDING, *own_constants(arm), *own_constants(arm.executed)), constants)
    return digest(run.seed, played, goal, entry, {key: constants[key] for key in constants if key not in deciding})


def _run_scene(
    arm: ArmJob,
    settings: Settings,
    episodes_file: Path,
    seeds: Sequence[int],
    cache: Cache,
    opener: Callable[[], Callable[[str, float], ObservationStore]],
    sightings_file: Path | None,
    predictions_file: Path | None,
    scene: str,
) -> list[Rollout]:
    """Return the rollouts of all episodes of a scene under all seeds. One simulator serves all of them that may share it."""
    episodes, sightings, rollouts = Episode.load(episodes_file, scene), read_sightings(arm, sightings_file), list[Rollout]()
    open_store, predictions = opener(), () if predictions_file is None else Prediction.read(predictions_file)
    answers, progress = {one.episode: one.outcome for one in predictions}, Units(len(episodes) * len(seeds))
    for _, alike in groupby(episodes, key=lambda episode: (episode.backend, episode.protocol)):
        group = list(alike)
        with open_session(group[0], arm, settings) as session:
            for episode in group:
                print(f"{episode.id} {arm.name}: under seeds {', '.join(map(str, seeds))}", flush=True)
                answered = answers.get(episode.id)
                offered = answered if isinstance(answered, Answer | Abstention) else None
                store = open_store(episode.scene, episode.protocol.camera.field_of_view_deg)
                for seed in seeds:  # the simulator keeps the last few worlds
                    one = Run(episode, arm, seed, settings, store, sightings.get(episode.id), offered)
                    value = cache.get_or_compute(rollout_key(one, answered), partial(_measure, session, one))
                    rollouts.append(Rollout.from_json(value, f"{cache.directory}: {episode.id}"))
                    ended = f"{rollouts[-1].outcome} after {rollouts[-1].actions} actions"
                    progress.done(f"{episode.id} {arm.name} seed {seed}: {ended}")
    return rollouts


def _measure(session: Session, run: Run) -> dict[str, Any]:
    return session.with_restarts(partial(run_episode, session, run)).to_json()

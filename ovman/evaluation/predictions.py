"""Stage `predictions`: what the static arms answer to the released episodes, from the recorded observations. Pure.

An arm that is given positions reads the file of sightings, one that is given its grounding the labels of its map's detections, or
the sightings where its reading is by positions; no other arm opens them.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from ovman import seeds
from ovman.evaluation.context import EpisodeContext, agent_settings
from ovman.evaluation.observation_store import ObservationStore, of_scene
from ovman.evaluation.supervision import AgentError, failures, function
from ovman.evaluation.withheld import asked, categories_in
from ovman.perception.labels import Labels, read_labels
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Predicted, Prediction
from ovman.records.record import lines
from ovman.records.sighting import Sightings
from ovman.settings import Arm, Withheld
from ovman.workflow.parameter import StageSettings

VISITS = Path("results", "visits")
"""Directory of the recorded visits of all scenes."""


def predict(
    arm: Arm,
    episode: Episode,
    settings: StageSettings,
    store: ObservationStore,
    sightings: Sightings | None = None,
    run: int = 0,
    labels: Mapping[str, Labels] | None = None,
    categories: Collection[str] = (),
) -> tuple[Predicted, Evidence | None]:
    """What a static arm answers to the query of an episode, and from which evidence.

    store: of the episode's scene; sightings: of the episode, for an arm that is given its grounding by positions, or positions;
    labels: of the detections of the scene's visits, for one that is given its grounding by them; run: 0 for the first of the
    arm's runs; categories: of the scene's instances, for one that is told a wrong noun. AgentError, in one line, where the arm's
    function fails or returns no prediction.
    """
    context = EpisodeContext(
        rng=seeds.generator(episode.provenance.seed, "predictions", arm.name, episode.id, run),
        run=run,
        settings=agent_settings(episode, settings),
        episode=episode,
        arm=arm,
        store=store,
        sightings=sightings if arm.reads_sightings else None,
        labels=labels if arm.reads_labels else None,
    )
    query = asked(episode, arm.withheld, run, categories)
    answer = function(arm.name, arm.agent)
    with failures(where := f"arms.{arm.name}.agent is {arm.agent!r}: {episode.id}: it"):
        answered = answer(query, context)
    match answered:
        case (outcome, Evidence() | None as evidence) if isinstance(outcome, Predicted):
            return outcome, evidence
    raise AgentError(f"{where} returned {answered!r:.80}; return (Answer(x, z), None), or another outcome of a prediction")


def sightings_of(arm: Arm, file: Path | None) -> dict[str, Sightings]:
    """The sightings by episode, for an arm that reads them. ValueError, in one line, where the file is not given."""
    if not arm.reads_sightings:
        return {}
    if file is None:
        raise ValueError(f"arms.{arm.name} is given its grounding or positions: it needs the file of sightings")
    return {record.episode: record for record in Sightings.read(file)}


def run(
    arm: Arm,
    episodes_file: Path,
    settings: StageSettings,
    output: Path,
    sightings_file: Path | None = None,
    visits: Path = VISITS,
    files: Mapping[str, Sequence[Path]] = {},
) -> None:
    """Write the predictions of an arm for all released episodes, run after run.

    sightings_file: of the episodes, for an arm that reads it. visits: directory of all scenes' recorded visits. files: what was
    perceived, by the workflow's names: under "maps", "maintained", "dualmap" and "detections" one file a scene, named after it,
    and likewise under "labels" and "scenes" for an arm that reads them, under "nouns" one. Prints how long it took from the files
    to the predictions.
    """
    began, worked = time.perf_counter(), time.process_time()
    episodes, sightings = Episode.load(episodes_file), sightings_of(arm, sightings_file)
    labels = {file.stem: read_labels(file) for file in files.get("labels", ())} if arm.reads_labels else {}
    wrong = arm.withheld is Withheld.NOUN_WRONG
    categories: dict[str, Collection[str]] = {file.stem: categories_in(file) for file in files.get("scenes", ()) if wrong}
    stores: dict[tuple[str, float], ObservationStore] = {}
    predictions = []
    for number in range(arm.runs):
        for episode in episodes:
            store = store_of(arm, episode, settings, visits, files, stores)
            seen, shown, things = sightings.get(episode.id), labels.get(episode.scene), categories.get(episode.scene, ())
            outcome, evidence = predict(arm, episode, settings, store, seen, number, shown, things)
            predictions.append(Prediction.of(episode.id, arm.name, number, outcome, evidence))
    output.write_text(lines(predictions), encoding="utf-8")
    took, worked = time.perf_counter() - began, time.process_time() - worked
    print(f"{arm.name}: {len(predictions)} predictions in {took:.2f} s, {worked:.2f} s of the processor", flush=True)


def store_of(
    arm: Arm,
    episode: Episode,
    settings: StageSettings,
    visits: Path,
    files: Mapping[str, Sequence[Path]],
    stores: dict[tuple[str, float], ObservationStore],
) -> ObservationStore:
    """The store of an episode's scene and camera, made where `stores` has none."""
    lens = episode.protocol.camera.field_of_view_deg
    key = episode.scene, lens
    if key not in stores:
        stores[key] = ObservationStore(arm, settings, lens, visits / episode.scene, of_scene(episode.scene, files))
    return stores[key]

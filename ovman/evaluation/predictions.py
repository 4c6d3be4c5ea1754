"""Stage `predictions`: the answers of a static arm to the released episodes, from the recorded observations. Pure."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from ovman import seeds
from ovman.agents.interface import Query, Relation
from ovman.evaluation.context import EpisodeContext, agent_settings
from ovman.evaluation.observations import VISITS, ObservationStore, store_opener
from ovman.evaluation.supervision import AgentError, load_agent, name_failures
from ovman.evaluation.words import tell
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS, nouns
from ovman.perception.labels import Labels, categories_of, read_labels
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Predicted, Prediction
from ovman.records.record import lines
from ovman.records.scene import Scene
from ovman.records.visit import Sightings
from ovman.settings import Arm, Settings, Withheld
from ovman.settings.arms import ArmJob

LABELS = "labels"
NO_NOUN = ""


def run(
    arm: ArmJob,
    settings: Settings,
    episodes_file: Path,
    output: Path,
    perceived: Mapping[str, Path] = {},
    sightings_file: Path | None = None,
    scene_files: Sequence[Path] = (),
) -> None:
    """Write the predictions of an arm for all episodes, run after run, and print how long they took.

    perceived: Directories with a file of each scene, by need and "labels", and the file "nouns". sightings_file: For an arm with
    oracle positions, or with oracle grounding by them. scene_files: For an arm that needs the scene or is told a wrong noun.
    """
    began, worked = time.perf_counter(), time.process_time()
    episodes, sightings = Episode.load(episodes_file), read_sightings(arm, sightings_file)
    labels: dict[str, Mapping[str, Labels]] = {}
    if arm.reads_labels and LABELS in perceived:
        labels = {file.stem: read_labels(file) for file in sorted(perceived[LABELS].glob("*.npz"))}
    open_store = store_opener(arm, settings, VISITS, {name: path for name, path in perceived.items() if name != LABELS})
    scenes = {scene.scene: scene for file in scene_files for scene in Scene.read(file)} if arm.reads_scenes else {}
    categories = {name: categories_of(scene).values() for name, scene in scenes.items()}
    predictions = []
    for number in range(arm.runs):
        for episode in episodes:
            store = open_store(episode.scene, episode.protocol.camera.field_of_view_deg)
            truth = sightings.get(episode.id), number, labels.get(episode.scene), categories.get(episode.scene, ())
            outcome, evidence = predict(arm, episode, settings, store, *truth, scenes.get(episode.scene))
            predictions.append(Prediction.of(episode.id, arm.name, number, outcome, evidence))
    output.write_text(lines(predictions), encoding="utf-8")
    took, worked = time.perf_counter() - began, time.process_time() - worked
    print(f"{arm.name}: {len(predictions)} predictions in {took:.2f} s, {worked:.2f} s of the processor", flush=True)


def predict(
    arm: Arm,
    episode: Episode,
    settings: Settings,
    store: ObservationStore,
    sightings: Sightings | None = None,
    run: int = 0,
    labels: Mapping[str, Labels] | None = None,
    categories: Collection[str] = (),
    scene: Scene | None = None,
) -> tuple[Predicted, Evidence | None]:
    """Return the answer of a static arm to the query of an episode, and the evidence for it.

    labels: Of the detections of the scene's visits, for an arm with oracle grounding by them. categories: Of the scene's
    instances, for an arm that is told a wrong noun. scene: For an arm that needs it. AgentError if the arm's function fails or
    returns no prediction.
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
        scene=scene,
    )
    asked = tell(query_of(episode, arm.withheld, run, categories), arm, episode)
    answer = load_agent(arm.name, arm.agent)
    with name_failures(where := f"arms.{arm.name}.agent is {arm.agent!r}: {episode.id}: it"):
        answered = answer(asked, context)
    match answered:
        case (outcome, Evidence() | None as evidence) if isinstance(outcome, Predicted):
            return outcome, evidence
    raise AgentError(f"{where} returned {answered!r:.80}; return (Answer(x, z), None), or another outcome of a prediction")


def read_sightings(arm: Arm, file: Path | None) -> dict[str, Sightings]:
    """Return the sightings by episode, for an arm that reads them. ValueError, in one line, if the file is not given."""
    if not arm.reads_sightings:
        return {}
    if file is None:
        raise ValueError(f"arms.{arm.name} is given its grounding or positions: it needs the file of sightings")
    return {record.episode: record for record in Sightings.read(file)}


def query_of(episode: Episode, withheld: Withheld | None, run: int, categories: Collection[str] = ()) -> Query:
    """Return the query that an arm is given, by what is withheld from it.

    Draws follow from the episode and the run, not from the arm: agents from which the same is withheld are asked the same. A
    relation is drawn from all six: one drawn from the others would say which one is wrong. A wrong noun names another of the
    scene's `categories` without a noun of the vocabulary in common with the right one; ValueError for a scene that has no other.
    """
    query = Query(episode.category, episode.relation)
    draws = seeds.generator(episode.provenance.seed, "withheld", str(withheld), episode.id, run)
    match withheld:
        case Withheld.NOUN:
            return Query(NO_NOUN, query.relation)
        case Withheld.NOUN_WRONG:
            own = set(nouns(query.category))
            others = sorted(other for other in {*categories} & SYNONYMS.keys() if not own & set(nouns(other)))
            if not others:
                raise ValueError(
                    f"{episode.id}: {episode.scene} has nothing but {noun(query.category)} to name; leave the arm out"
                )
            return Query(others[int(draws.integers(len(others)))], query.relation)
        case Withheld.RELATION:
            return Query(query.category, tuple(Relation)[int(draws.integers(len(Relation)))])
    return query

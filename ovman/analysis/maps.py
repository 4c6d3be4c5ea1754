"""The objects of the agents' maps: into how many of them each target falls, and how many DualMap's maps hold.

A detection shows the instance that its mask meets at the least overlap of `ovman.perception.labels`. A target falls into the
objects of a map that have a detection of it. It is missing from the grounded set of a visit if none of these objects is grounded.
Source: "fragments a moving object into several clusters", "when the target is missing from the grounded set".
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import numpy as np

from ovman.agents.dualmap.mapped import Mapped, read
from ovman.agents.interface import VISITS
from ovman.analysis.instances import read_of_scene, read_scenes, scene_files, shown_objects
from ovman.analysis.outcomes import ALL, Outcome, group_by, static_outcomes
from ovman.analysis.rows import Row, write_csv
from ovman.perception.clusters import Cluster
from ovman.perception.records import read_detections, read_maps
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Prediction
from ovman.records.scene import Scene
from ovman.records.task import Relation
from ovman.records.visit import tour_path
from ovman.settings import Settings

FRAGMENTS = (
    "arm relation n seen objects several grounded grounded_success grounded_wrong "
    "grounded_abstained missing missing_success missing_wrong missing_abstained"
)
DUALMAP = "scene memory run maps frames objects_mean objects_min objects_max"
VISIT, MAINTAINED = "two visits", "maintained map"


def write_fragments(
    episodes_file: Path,
    predictions_file: Path,
    scene_files: Sequence[Path],
    detections: Sequence[Path],
    maps: Sequence[Path],
    visits: Path,
    settings: Settings,
    output: Path,
) -> None:
    """Write the rows of `count_fragments` of the arm comparisons.memory.arm. ValueError for a prediction without evidence.

    Settings: comparisons.memory.arm, perception.detector.min_mask_px, success.radius_m.
    """
    episodes, predictions = Episode.load(episodes_file), Prediction.read(predictions_file)
    min_mask_px = settings.perception.detector.min_mask_px
    outcomes = static_outcomes(episodes, predictions, radius_m=settings.success.radius_m)
    judged = {outcome.episode: outcome for outcome in outcomes}
    evidence = {prediction.episode: prediction.evidence for prediction in predictions}
    targets = []
    for scene in read_scenes(scene_files):
        here = [episode for episode in episodes if episode.scene == scene.scene]
        objects = read_of_scene(maps, scene.scene, read_maps)
        detected, shown, of_visit = read_of_scene(detections, scene.scene, read_detections), {}, {}
        for name in {episode.visits[which] for episode in here for which in VISITS}:
            seen = detected[name]
            if seen.content not in shown:  # visits of equal content look the same
                shown[seen.content] = shown_objects(scene, tour_path(visits / scene.scene, name), seen, min_mask_px)
            of_visit[name] = objects_of_instances(scene, shown[seen.content], objects[name])
        for episode in here:
            grounds = evidence[episode.id]
            if grounds is None:
                raise ValueError(f"{predictions_file}: {episode.id} has no evidence; name an arm that says what it grounds")
            targets.append(find_target(episode, grounds, judged[episode.id], of_visit))
    write_csv(output, FRAGMENTS, count_fragments(settings.comparisons.memory.arm, targets))


def objects_of_instances(scene: Scene, shown: np.ndarray, objects: Sequence[Cluster]) -> dict[str, set[int]]:
    """Return the objects of a map that have a detection of each instance. shown: `shown_objects` of the map's detections."""
    found: dict[str, set[int]] = {one.id: set() for one in scene.objects}
    for number, one in enumerate(objects):
        for index in {*shown[one.members].tolist()} - {-1}:
            found[scene.objects[index].id].add(number)
    return found


@dataclass(frozen=True, slots=True)
class Target:
    """The target of an episode in the agent's maps.

    Attributes:
        objects: Into how many objects it falls in the visit that the answer belongs to.
        grounded: Whether one of its objects is in the grounded set of every visit in which it is present.
        became: "success", "wrong" for an answer that fails, or "abstained".
    """

    relation: Relation
    objects: int
    grounded: bool
    became: str


def find_target(
    episode: Episode, evidence: Evidence, outcome: Outcome, objects: Mapping[str, Mapping[str, Collection[int]]]
) -> Target:
    """Find the target of an episode in the maps that a prediction was made from. objects: By visit and instance."""
    sets = {"first": evidence.grounded_1, "second": evidence.grounded_2}
    worlds = {"first": episode.world_1, "second": episode.world_2}
    there = {which: objects[episode.visits[which]][episode.target] for which in VISITS if episode.target in worlds[which]}
    return Target(
        relation=episode.relation,
        objects=len(there["first" if episode.relation.past else "second"]),
        grounded=all({*found} & {*(sets[which] or ())} for which, found in there.items()),
        became="success" if outcome.success else "wrong" if outcome.outcome == "answered" else "abstained",
    )


def count_fragments(arm: str, targets: Sequence[Target]) -> list[Row]:
    """Count the targets of each relation, then of all.

    seen: targets that some detection shows in the visit that the answer belongs to; objects: into how many objects these fall
    in the mean; several: how many fall into more than one. Then what became of the predictions of grounded and of missing
    targets.
    """
    rows = []
    for relation, group in group_by(targets, "relation").items():
        seen = [one.objects for one in group if one.objects]
        became = Counter((one.grounded, one.became) for one in group)
        grounded = sum(one.grounded for one in group)
        row: Row = {"arm": arm, "relation": relation, "n": len(group), "seen": len(seen), "several": sum(n > 1 for n in seen)}
        row |= {"objects": sum(seen) / len(seen) if seen else None, "grounded": grounded, "missing": len(group) - grounded}
        for outcome in ("success", "wrong", "abstained"):
            row |= {f"grounded_{outcome}": became[True, outcome], f"missing_{outcome}": became[False, outcome]}
        rows.append(row)
    return rows


def write_dualmap(dualmap: Sequence[Path], output: Path) -> None:
    """Write how many keyframes and objects DualMap's maps have: over all, then per scene and run."""
    rows: list[Row] = []
    every: dict[str, list[Mapped]] = {VISIT: [], MAINTAINED: []}
    for file in scene_files(dualmap):
        for number, run in enumerate(read(file)):
            for memory, maps in ((VISIT, [*run.visits.values()]), (MAINTAINED, [*run.maintained.values()])):
                if maps:
                    rows.append(_count_objects(file.stem, memory, str(number), maps))
                    every[memory] += maps
    whole = [_count_objects(ALL, memory, ALL, maps) for memory, maps in every.items() if maps]
    write_csv(output, DUALMAP, [*whole, *rows])


def _count_objects(scene: str, memory: str, run: str, maps: Sequence[Mapped]) -> Row:
    counts = [len(mapped) for mapped in maps]
    frames = fmean(mapped.frames for mapped in maps)
    values = (scene, memory, run, len(maps), frames, fmean(counts), min(counts), max(counts))
    return dict(zip(DUALMAP.split(), values, strict=True))

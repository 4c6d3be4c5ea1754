"""The stage "fragments": into how many objects of a map each target falls, and what becomes of targets that are not grounded.

A detection shows the instance that its mask meets at the least overlap of `ovman.perception.overlap`. A target has fallen into
the objects of a map that have a detection of it. It is missing from the grounded set of a visit where none of these is grounded.
Source: "fragments a moving object into several clusters", "when the target is missing from the grounded set".
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ovman.agents.interface import VISITS
from ovman.analysis import frames
from ovman.analysis.instances import TrueScene, true_ids
from ovman.analysis.outcomes import Case, StaticOutcome, static_outcomes
from ovman.analysis.rates import ALL
from ovman.analysis.segmentation import segmented
from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, read_maps
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Prediction
from ovman.records.task import Relation
from ovman.records.visit import Visit
from ovman.settings import Settings


@dataclass(frozen=True, slots=True)
class Target:
    """The target of an episode in the agent's maps.

    objects: into how many objects it has fallen in the visit that the answer belongs to; grounded: whether one of its objects is
    in the grounded set of every visit in which it is present; outcome: of the prediction.
    """

    relation: Relation
    objects: int
    grounded: bool
    outcome: StaticOutcome

    @property
    def became(self) -> str:
        """What came of it: "success", "wrong" for an answer that fails, or "abstained"."""
        return "success" if self.outcome.success else "wrong" if self.outcome.outcome == "answered" else "abstained"


@dataclass(frozen=True, slots=True)
class Fragments:
    """The n targets of a relation, or of ``all``, in an arm's maps.

    seen: how many some detection shows in the visit that the answer belongs to; objects: into how many objects these fall in the
    mean, None without any; several: how many into more than one. grounded, missing: how many are in the grounded set of every
    visit that they are present in, and the others; then what became of the predictions of both.
    """

    arm: str
    relation: str
    n: int
    seen: int
    objects: float | None
    several: int
    grounded: int
    grounded_success: int
    grounded_wrong: int
    grounded_abstained: int
    missing: int
    missing_success: int
    missing_wrong: int
    missing_abstained: int


def fragments(arm: str, targets: Sequence[Target]) -> list[Fragments]:
    """A row for each relation that there are targets of, then one for all."""
    groups = [(str(relation), [one for one in targets if one.relation is relation]) for relation in Relation]
    return [_row(arm, relation, group) for relation, group in (*groups, (ALL, list(targets))) if group]


def _row(arm: str, relation: str, targets: Sequence[Target]) -> Fragments:
    seen = [one.objects for one in targets if one.objects]
    became = Counter((one.grounded, one.became) for one in targets)
    counts = {
        f"{name}_{outcome}": became[grounded, outcome]
        for grounded, name in ((True, "grounded"), (False, "missing"))
        for outcome in ("success", "wrong", "abstained")
    }
    grounded = sum(one.grounded for one in targets)
    return Fragments(
        arm=arm,
        relation=relation,
        n=len(targets),
        seen=len(seen),
        objects=sum(seen) / len(seen) if seen else None,
        several=sum(count > 1 for count in seen),
        grounded=grounded,
        missing=len(targets) - grounded,
        **counts,
    )


def members(detected: Detected, objects: Sequence[Cluster]) -> np.ndarray:
    """(N,) the object of a map that each detection of its tour belongs to. ValueError where the map is of another tour.

    An object's track has the places of its detections, and its views theirs.
    """
    of_place = {
        (int(view), float(x), float(z)): number
        for number, one in enumerate(objects)
        for view, (x, z) in zip(one.views, one.track, strict=True)
    }
    places = zip(detected.view.tolist(), detected.point[:, [0, 2]].astype(float).tolist(), strict=True)
    try:
        return np.array([of_place[view, x, z] for view, (x, z) in places], int)
    except KeyError:
        raise ValueError("a map lacks detections of its tour; make the stage maps again") from None


def shown(scene: TrueScene, visit: Visit, directory: Path, detected: Detected, min_mask_px: int) -> np.ndarray:
    """(N,) what each detection of a recorded tour shows, an index into the scene's objects, -1 for none of them."""
    masks, found = detected.masks(), np.full(len(detected), -1)
    for view in np.unique(detected.view):
        rows = np.flatnonzero(detected.view == view)
        ids = true_ids(scene, visit, directory, int(view))
        found[rows] = segmented(masks[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px).object
    return found


class SceneMaps:
    """What the maps of a scene's visits are made of. visits: directory of its recorded tours."""

    def __init__(
        self,
        scene: TrueScene,
        detections: Mapping[str, Detected],
        maps: Mapping[str, Sequence[Cluster]],
        visits: Path,
        min_mask_px: int,
    ) -> None:
        self._scene, self._detections, self._maps, self._visits = scene, detections, maps, visits
        self._min_mask_px, self._place = min_mask_px, {one.id: number for number, one in enumerate(scene.objects)}
        self._shown: dict[str, np.ndarray] = {}

    def objects_of(self, visit: str, instance: str) -> frozenset[int]:
        """The objects of a visit's map that have a detection of an instance. ValueError as ``members``."""
        detected = self._detections[visit]
        if detected.content not in self._shown:  # visits of equal content look the same
            where = self._visits / visit
            self._shown[detected.content] = shown(self._scene, Visit.load(where), where, detected, self._min_mask_px)
        rows = self._shown[detected.content] == self._place[instance]
        return frozenset(members(detected, self._maps[visit])[rows].tolist())


def target(episode: Episode, evidence: Evidence, outcome: StaticOutcome, scene: SceneMaps) -> Target:
    """The target of an episode in the maps that a prediction was made from."""
    sets = {"first": evidence.grounded_1, "second": evidence.grounded_2}
    worlds = {"first": episode.world_1, "second": episode.world_2}
    there = {
        which: scene.objects_of(episode.visits[which], episode.target) for which in VISITS if episode.target in worlds[which]
    }
    answers = "first" if episode.relation.past else "second"
    return Target(
        relation=episode.relation,
        objects=len(there[answers]),
        grounded=all(objects & set(sets[which] or ()) for which, objects in there.items()),
        outcome=outcome,
    )


def run(
    episodes_file: Path,
    predictions_file: Path,
    scenes: Sequence[Path],
    detections: Sequence[Path],
    maps: Sequence[Path],
    visits: Path,
    constants: Settings,
    output: Path,
) -> None:
    """Write the rows of ``fragments``. predictions_file: of comparisons.memory.arm; scenes, detections, maps: a file a scene.

    visits: directory of the recorded tours of all scenes. constants: perception.detector.min_mask_px, success.radius_m. Raises
    ValueError in one line for a prediction without evidence.
    """
    episodes, predictions = Episode.load(episodes_file), Prediction.read(predictions_file)
    cases = [Case.of(episode) for episode in episodes]
    outcomes = static_outcomes(cases, predictions, radius_m=constants.success.radius_m, samples=1, seed=0)
    judged = {outcome.episode: outcome for outcome in outcomes}
    evidence = {prediction.episode: prediction.evidence for prediction in predictions}
    files = {path.stem: (path, found, made) for path, found, made in zip(scenes, detections, maps, strict=True)}

    @cache
    def scene_of(name: str) -> SceneMaps:
        scene, found, made = files[name]
        min_mask_px = constants.perception.detector.min_mask_px
        return SceneMaps(TrueScene.load(scene), read_detections(found), read_maps(made), visits / name, min_mask_px)

    def targets() -> Iterator[Target]:
        for episode in episodes:
            grounds = evidence[episode.id]
            if grounds is None:
                raise ValueError(f"{predictions_file}: {episode.id} has no evidence; name an arm that says what it grounds")
            yield target(episode, grounds, judged[episode.id], scene_of(episode.scene))

    rows = fragments(constants.comparisons.memory.arm, list(targets()))
    frames.write(output, Fragments, rows)
    print(", ".join(f"{row.relation}: {row.objects or 0:.2f} objects a target" for row in rows), flush=True)

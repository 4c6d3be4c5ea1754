"""The value of cues of appearance in the cost of association: weights fitted on one split and tested on all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.agents.reference.association import distances
from ovman.agents.reference.reasoning import answer_two_visits
from ovman.analysis.cues import (
    CLIP,
    CUES,
    EXTENT,
    HISTOGRAM,
    MapObjects,
    MapsOfScenes,
    Pairs,
    Weights,
    disagreements,
    fit_weights,
    read_map_objects,
    separation,
)
from ovman.analysis.outcomes import ALL, RELATIONS, find_successes
from ovman.analysis.rows import Row, write_csv
from ovman.analysis.statistics import compare_paired, wilson_interval
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Prediction
from ovman.settings import Settings

APPEARANCE = (
    "pairs cues fitted_on split relation same different auroc clip histogram extent n successes rate low high wins losses p"
)
APART = "apart"
"""Pairs whose places are farther apart than tau: an object that stands still is known by its place, without a cue."""
READINGS = (ALL, APART)
"""The pairs of map objects that weights are fitted on, and that AUROC is of."""
VARIANTS: tuple[tuple[str, ...], ...] = ((CLIP,), (CLIP, HISTOGRAM), (CLIP, EXTENT), CUES)
"""The cues in the association cost of each variant; the first is the agent as it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """An episode with the maps of both visits, the objects that the noun means in them, and their disagreements by cue."""

    episode: Episode
    first: MapObjects
    second: MapObjects
    meant: Evidence
    unlike: Mapping[str, np.ndarray]


def write_appearance(
    episode_files: Sequence[Path],
    prediction_files: Sequence[Path],
    scene_files: Sequence[Path],
    detections: Sequence[Path],
    maps: Sequence[Path],
    visits: Path,
    settings: Settings,
    output: Path,
    workers: int = 1,
) -> None:
    """Write the rows of `compare_cues`. The files of episodes, named after their splits, and of predictions are in one order.

    Settings: appearance.*, association.*, admissibility.tau_m, success.radius_m, evaluation.confidence, camera.field_of_view_deg.
    """
    objects = read_map_objects(scene_files, detections, maps, visits, settings, workers)
    splits = {}
    for episodes, predictions in zip(episode_files, prediction_files, strict=True):
        meant = {one.episode: one.evidence for one in Prediction.read(predictions)}
        splits[episodes.stem] = [pose_question(one, meant.get(one.id), objects, settings) for one in Episode.load(episodes)]
    write_csv(output, APPEARANCE, compare_cues(splits, settings))


def pose_question(episode: Episode, meant: Evidence | None, objects: MapsOfScenes, settings: Settings) -> Question:
    """Join an episode with its maps. ValueError if the arm names no objects of both maps."""
    if meant is None or meant.grounded_1 is None:
        raise ValueError(f"appearance.agent is {settings.appearance.agent}, which names no objects of two maps for {episode.id}")
    first, second = (objects[episode.scene, episode.visits[which]] for which in ("first", "second"))
    return Question(episode, first, second, meant, disagreements(first, second, settings.appearance.least_extent_m))


def compare_cues(splits: Mapping[str, Sequence[Question]], settings: Settings) -> list[Row]:
    """Compute every row: by pairs and split the cues alone, then the variants by the split that they are fitted on.

    same, different: pairs of map objects of the queried category across the visits, of one instance and of two, and their AUROC;
    only for all relations. clip, histogram, extent: the weights. n to high: of the agent with this cost, None for a cue that is
    in no variant alone; wins, losses, p: against the agent as it is.
    """
    constants, tau_m = settings.appearance, settings.admissibility.tau_m
    base = {split: two_visit_successes(questions, None, settings) for split, questions in splits.items()}
    rows: list[Row] = []
    for reading in READINGS:
        pairs = {split: find_pairs(questions, tau_m if reading == APART else 0.0) for split, questions in splits.items()}
        for split, questions in splits.items():
            for cue in CUES:
                weights = Weights.on(cue)
                row = {"pairs": reading, "fitted_on": None, "split": split, **_separation_row(weights, pairs[split])}
                rows += _with_success(row, questions, base[split], base[split], settings) if cue == CLIP else [row]
        for fitted_on in splits:
            for cues in VARIANTS[1:]:
                weights = fit_weights(
                    pairs[fitted_on], cues, constants.weight_step, constants.least_pairs, constants.equal_scales
                )
                for split, questions in splits.items():
                    row = {"pairs": reading, "fitted_on": fitted_on, "split": split, **_separation_row(weights, pairs[split])}
                    won = two_visit_successes(questions, weights, settings)
                    rows += _with_success(row, questions, won, base[split], settings)
    return rows


def find_pairs(questions: Sequence[Question], apart_m: float) -> Pairs:
    """Return the pairs of map objects that the nouns mean, one of each visit, at least `apart_m` apart; each pair once.

    Objects that show no instance are left out.
    """
    unlike: dict[str, list[float]] = {cue: [] for cue in CUES}
    same: list[bool] = []
    met: set[frozenset[tuple[str, str, int]]] = set()
    for one in questions:
        gaps = distances(one.first.map.p, one.second.map.p)
        for i in one.meant.grounded_1 or ():
            for j in one.meant.grounded_2:
                here, there = one.first.instance[i], one.second.instance[j]
                visits, scene = one.episode.visits, one.episode.scene
                key = frozenset({(scene, visits.first, i), (scene, visits.second, j)})
                if here is None or there is None or gaps[i, j] < apart_m or key in met:
                    continue
                met.add(key)
                same.append(here == there)
                for cue in CUES:
                    unlike[cue].append(float(one.unlike[cue][i, j]))
    return Pairs({cue: np.array(values, np.float64) for cue, values in unlike.items()}, np.array(same, bool))


def two_visit_successes(questions: Sequence[Question], weights: Weights | None, settings: Settings) -> dict[str, bool]:
    """Tell which episodes the two-visit agent answers right with these weights in its cost, or with its own (None)."""
    predictions = []
    for one in questions:
        unlike = None if weights is None else weights.combine(one.unlike)
        first, second, meant = one.first.map, one.second.map, one.meant
        answer, _ = answer_two_visits(
            one.episode.relation, first, second, meant.grounded_1 or (), meant.grounded_2, settings, unlike
        )
        predictions.append(Prediction.of(one.episode.id, settings.appearance.agent, 0, answer))
    return find_successes([one.episode for one in questions], predictions, settings.success.radius_m)


def _separation_row(weights: Weights, pairs: Pairs) -> Row:
    same, different = pairs.counts
    return {
        "cues": " + ".join(weights.by_cue),
        "relation": ALL,
        "same": same,
        "different": different,
        "auroc": None if math.isnan(area := separation(pairs, weights)) else area,
        **{cue: weights.by_cue.get(cue, 0.0) for cue in CUES},
        **dict.fromkeys(("n", "successes", "rate", "low", "high", "wins", "losses", "p")),
    }


def _with_success(
    row: Row, questions: Sequence[Question], won: Mapping[str, bool], base: Mapping[str, bool], settings: Settings
) -> Iterator[Row]:
    """Yield the row with its success over all relations, then a row for each relation that the split has."""
    for relation in (ALL, *RELATIONS[:-1]):
        ids = [one.episode.id for one in questions if relation in (ALL, one.episode.relation)]
        if not ids:
            continue
        successes, n = sum(won[name] for name in ids), len(ids)
        wins, losses, p = compare_paired((won[k] for k in ids), (base[k] for k in ids))
        low, high = wilson_interval(successes, n, settings.evaluation.confidence)
        found = row | {"relation": relation, "n": n, "successes": successes, "rate": successes / n, "low": low, "high": high}
        found |= {} if relation == ALL else dict.fromkeys(("same", "different", "auroc"))
        yield found | {"wins": wins, "losses": losses, "p": p}

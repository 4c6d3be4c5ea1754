"""Stage `appearance`: what cues of appearance are worth in the cost of association, fitted on one split, tested on the others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ovman.agents.reference.association import distances
from ovman.agents.reference.reasoning import answer_two_visits
from ovman.analysis import frames
from ovman.analysis.cue_weights import Pairs, Weights, alone, fitted, separation
from ovman.analysis.map_objects import CLIP, CUES, EXTENT, HISTOGRAM, MapObjects, disagreements, read_map_objects
from ovman.analysis.outcomes import Case, static_outcomes
from ovman.analysis.rates import ALL
from ovman.analysis.statistics import mcnemar_exact, wilson_interval
from ovman.records.episode import Episode
from ovman.records.prediction import Evidence, Prediction
from ovman.records.task import Relation
from ovman.settings import Settings

APART = "apart"
"""Pairs whose places are farther apart than tau: where an instance stood still its place tells, and no cue is asked."""
READINGS = (ALL, APART)
"""Which pairs of map objects weights are fitted on, and AUROC is of."""
VARIANTS: tuple[tuple[str, ...], ...] = ((CLIP,), (CLIP, HISTOGRAM), (CLIP, EXTENT), CUES)
"""The cues in the association cost of each variant; the first is the agent as it is."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """pairs: ALL or APART; cues: joined by " + "; fitted_on: a split, None where nothing is fitted; split: tested on; relation:
    of the episodes, or "all".

    same, different: pairs of map objects of the queried category across the visits, of one instance and of two, and their auroc,
    None without either; only for all relations. clip, histogram, extent: shares of the weights. n, successes, rate, low, high: of
    the agent with this cost; wins, losses, p: against the agent as it is, by episode. None for a cue that is in no variant alone.
    """

    pairs: str
    cues: str
    fitted_on: str | None
    split: str
    relation: str
    same: int | None
    different: int | None
    auroc: float | None
    clip: float
    histogram: float
    extent: float
    n: int | None = None
    successes: int | None = None
    rate: float | None = None
    low: float | None = None
    high: float | None = None
    wins: int | None = None
    losses: int | None = None
    p: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """An episode with the maps of both visits, what the noun means in them, and how unlike their objects are by each cue."""

    episode: Episode
    first: MapObjects
    second: MapObjects
    meant: Evidence
    unlike: Mapping[str, np.ndarray]


def run(
    episodes_files: Sequence[Path],
    prediction_files: Sequence[Path],
    maps_files: Sequence[Path],
    cues_files: Sequence[Path],
    constants: Settings,
    output: Path,
) -> None:
    """Writes the rows of `appearances`.

    episodes_files: one a split, named after it; prediction_files: of the arm appearance.agent, in the same order. constants:
    appearance.*, association.*, admissibility.tau_m, success.radius_m, evaluation.confidence. Raises ValueError in one line.
    """
    objects = read_map_objects(maps_files, cues_files)
    splits = {}
    for episodes, predictions in zip(episodes_files, prediction_files, strict=True):
        meant = {one.episode: one.evidence for one in Prediction.read(predictions)}
        splits[episodes.stem] = [asked(one, meant.get(one.id), objects, constants) for one in Episode.load(episodes)]
    rows = appearances(splits, constants)
    frames.write(output, Appearance, rows)
    print(f"{len(rows)} rows of {', '.join(f'{len(some)} episodes of {name}' for name, some in splits.items())}", flush=True)


def asked(episode: Episode, meant: Evidence | None, objects: Mapping[tuple[str, str], MapObjects], constants: Settings) -> Asked:
    """An episode with its maps. ValueError where the arm names no objects of both maps."""
    if meant is None or meant.grounded_1 is None:
        raise ValueError(f"appearance.agent is {constants.appearance.agent}, which names no objects of two maps for {episode.id}")
    first, second = (objects[episode.scene, episode.visits[which]] for which in ("first", "second"))
    return Asked(episode, first, second, meant, disagreements(first, second, constants.appearance.least_extent_m))


def appearances(splits: Mapping[str, Sequence[Asked]], constants: Settings) -> list[Appearance]:
    """Every row: by reading of the pairs and split the cues alone, then the variants by the split that they are fitted on."""
    tau_m, fit_by = constants.admissibility.tau_m, constants.appearance
    pairs = {
        (name, reading): pairs_of(some, tau_m if reading == APART else 0.0)
        for name, some in splits.items()
        for reading in READINGS
    }
    base = {name: successes(some, None, constants) for name, some in splits.items()}
    rows: list[Appearance] = []
    for reading in READINGS:
        for name, some in splits.items():
            for cue in CUES:
                weights = alone(cue)
                rows.append(_row(reading, None, name, weights, pairs[name, reading]))
                if cue == CLIP:
                    rows[-1:] = _judged(rows[-1], some, base[name], base[name], constants.evaluation.confidence)
        for fit in splits:
            for cues in VARIANTS[1:]:
                made = fitted(pairs[fit, reading], cues, fit_by.weight_step, fit_by.least_pairs, fit_by.equal_scales)
                for name, some in splits.items():
                    row = _row(reading, fit, name, made, pairs[name, reading])
                    won = successes(some, made, constants)
                    rows += _judged(row, some, won, base[name], constants.evaluation.confidence)
    return rows


def pairs_of(asked: Sequence[Asked], apart_m: float) -> Pairs:
    """The pairs of map objects that the queried nouns mean, one of each visit, that are at least apart_m apart; each pair once.

    Of objects that show no instance nothing is known.
    """
    unlike: dict[str, list[float]] = {cue: [] for cue in CUES}
    same: list[bool] = []
    met: set[frozenset[tuple[str, str, int]]] = set()
    for one in asked:
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


def successes(asked: Sequence[Asked], weights: Weights | None, constants: Settings) -> dict[str, bool]:
    """Which episodes the two-visit agent answers right with this appearance in its cost, or with its own; by their ids."""
    predictions = []
    for one in asked:
        unlike = None if weights is None else weights.combined(one.unlike)
        first, second, meant = one.first.map, one.second.map, one.meant
        grounded = meant.grounded_1 or (), meant.grounded_2
        answer, _ = answer_two_visits(one.episode.relation, first, second, *grounded, constants, unlike)
        predictions.append(Prediction.of(one.episode.id, constants.appearance.agent, 0, answer))
    cases = [Case.of(one.episode) for one in asked]
    judged = static_outcomes(cases, predictions, radius_m=constants.success.radius_m, samples=1, seed=0)
    return {outcome.episode: outcome.success == 1.0 for outcome in judged}


def _row(reading: str, fit: str | None, split: str, weights: Weights, pairs: Pairs) -> Appearance:
    same, different = pairs.counts
    apart = separation(pairs, weights)
    clip, histogram, extent = (weights.by_cue.get(cue, 0.0) for cue in CUES)
    cues = " + ".join(weights.by_cue)
    return Appearance(
        reading, cues, fit, split, ALL, same, different, None if math.isnan(apart) else apart, clip, histogram, extent
    )


def _judged(
    row: Appearance, asked: Sequence[Asked], won: Mapping[str, bool], base: Mapping[str, bool], confidence: float
) -> list[Appearance]:
    """The row with its success over all relations, and rows of each relation that the split has."""
    groups = {ALL: list(asked)} | {
        str(relation): [one for one in asked if one.episode.relation is relation] for relation in Relation
    }
    rows = []
    for relation, group in groups.items():
        if not group:
            continue
        ids = [one.episode.id for one in group]
        count, n = sum(won[name] for name in ids), len(ids)
        wins, losses = sum(won[k] > base[k] for k in ids), sum(won[k] < base[k] for k in ids)
        low, high = wilson_interval(count, n, confidence)
        judged = replace(
            row,
            relation=relation,
            n=n,
            successes=count,
            rate=count / n,
            low=low,
            high=high,
            wins=wins,
            losses=losses,
            p=mcnemar_exact(wins, losses),
        )
        rows.append(judged if relation == ALL else replace(judged, same=None, different=None, auroc=None))
    return rows

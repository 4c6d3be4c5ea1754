"""Stage `predictions`: what the static arms answer to the released episodes, from the recorded observations. Pure.

What is handed over to a diagnostic arm is looked up here, from the trials; the arms proper get their maps and the noun.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.arms import Source, named
from ovman.agents.decision import DecisionConstants
from ovman.agents.grounding import grounded
from ovman.agents.handover import grounding_by_truth, recorded_positions
from ovman.agents.object_map import ObjectMap
from ovman.agents.prediction import Outcome, Prediction, write
from ovman.agents.reasoning import Evidence, ReferenceConstants, one_visit, two_visits
from ovman.agents.single_visit import single_visit
from ovman.agents.two_visits import AssociationConstants, answer
from ovman.language import noun
from ovman.perception.clusters import Cluster
from ovman.perception.records import read_maps, read_nouns
from ovman.sim.recorded import world_state
from ovman.task import Query, Relation
from ovman.task.record import read_records

VISITS = ("first", "second")


@dataclass(frozen=True, slots=True, eq=False)
class Perceived:
    """What perception made of a scene: the clusters of every visit by the visit's name, and noun phrases as unit vectors (K,)."""

    maps: Mapping[str, Sequence[Cluster]]
    nouns: Mapping[str, np.ndarray]

    def map(self, visit: str) -> ObjectMap:
        """The map of a visit. ValueError for a visit that there is none of."""
        if visit not in self.maps:
            raise ValueError(f"there is no map of the visit {visit!r}; make the stage maps again")
        return ObjectMap.of(self.maps[visit])

    def noun(self, phrase: str) -> np.ndarray:
        """The embedding (K,) of a noun phrase. ValueError for one that there is none of."""
        if phrase not in self.nouns:
            raise ValueError(f"there is no embedding of the noun {phrase!r}; make the stage nouns again")
        return self.nouns[phrase]


def read_perceived(maps_files: Sequence[Path], nouns_file: Path | None) -> dict[str, Perceived]:
    """What was perceived, by scene; nothing where there are no files."""
    if nouns_file is None:
        return {}
    nouns = read_nouns(nouns_file)
    return {file.stem: Perceived(read_maps(file), nouns) for file in maps_files}


def association_constants(constants: Any) -> AssociationConstants:
    """gamma and lambda of config.yaml."""
    return AssociationConstants(constants.association.gate_m, constants.association.feature_scale_m)


def decision_constants(constants: Any) -> DecisionConstants:
    """tau and tau_trk of config.yaml."""
    return DecisionConstants(tau_m=constants.admissibility.tau_m, track_spread_m=constants.association.track_spread_m)


def reference_constants(constants: Any) -> ReferenceConstants:
    """delta_g, gamma, lambda and tau of config.yaml."""
    return ReferenceConstants(constants.grounding.band, association_constants(constants), decision_constants(constants))


def predict(
    arm: str, trial: Mapping[str, Any], constants: Any, perceived: Perceived | None = None
) -> tuple[Outcome, Evidence | None]:
    """What a static arm answers to the query of a trial, given what was recorded of both visits, and from which evidence.

    perceived: what an arm with positions of its own saw of the scene; an arm with positions handed over has no use for it.
    """
    candidate = trial["candidate"]
    query = Query(candidate["category"], Relation(candidate["relation"]))
    if named(arm).positions is Source.HANDED:
        return _from_positions(arm, query, trial["measured"], constants), None
    if perceived is None:
        raise ValueError(f"{arm!r} answers from maps of its own, and there are none of {candidate['scene']}; make the stage maps")
    return _from_maps(arm, query, trial["measured"], constants, perceived)


def _from_positions(arm: str, query: Query, measured: Mapping[str, Any], constants: Any) -> Outcome:
    worlds = [world_state(measured["sightings"][v], query.category, constants.admissibility.minimum_mask_px) for v in VISITS]
    if arm == "positions_two_visits":
        return answer(query, *worlds, association_constants(constants), decision_constants(constants))
    if arm == "positions_single_visit":
        tracks = [k.track for k in worlds[1].category(query.category)]
        return single_visit(query.relation, tracks, _reachable(measured))
    raise ValueError(f"{arm!r} is not a static arm with positions handed over")


def _from_maps(
    arm: str, query: Query, measured: Mapping[str, Any], constants: Any, perceived: Perceived
) -> tuple[Outcome, Evidence]:
    maps = {v: perceived.map(measured["visits"][v]) for v in VISITS}
    if named(arm).grounding is Source.OWN:
        phrase = perceived.noun(noun(query.category))
        means = {v: grounded(maps[v].f, phrase, constants.grounding.band) for v in VISITS}
    else:
        least_px, radius_m = constants.admissibility.minimum_mask_px, constants.success.radius_m
        means = {
            v: grounding_by_truth(recorded_positions(measured["sightings"][v], least_px), maps[v].p, radius_m) for v in VISITS
        }
    if arm in ("two_visits", "grounding_two_visits"):
        return two_visits(
            query.relation, maps["first"], maps["second"], means["first"], means["second"], reference_constants(constants)
        )
    if arm in ("single_visit", "grounding_single_visit"):
        return one_visit(query.relation, maps["second"], means["second"], _reachable(measured))
    raise ValueError(f"{arm!r} is not a static arm with positions of its own")


def _reachable(measured: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Two corners of the box around what could be reached in the second visit."""
    return list(zip(*measured["reachable_box"].values(), strict=True))


def run(
    arm: str,
    episodes_file: Path,
    trials_files: Sequence[Path],
    constants: Any,
    output: Path,
    maps_files: Sequence[Path] = (),
    nouns_file: Path | None = None,
) -> None:
    """Write the predictions of an arm for all released episodes.

    maps_files, nouns_file: what was perceived, one file of maps a scene; none for an arm with positions handed over. Prints how
    long it took from the files to the predictions.
    """
    began, worked = time.perf_counter(), time.process_time()
    perceived = read_perceived(maps_files, nouns_file)
    trials = {t["candidate"]["id"]: t for file in trials_files for t in read_records(file)}
    predictions = []
    for episode in read_records(episodes_file):
        outcome, evidence = predict(arm, trials[episode["id"]], constants, perceived.get(episode["scene"]))
        predictions.append(Prediction(episode["id"], arm, 0, outcome, evidence))
    write(output, predictions)
    took, worked = time.perf_counter() - began, time.process_time() - worked
    print(f"{arm}: {len(predictions)} predictions in {took:.2f} s, {worked:.2f} s of the processor", flush=True)

"""Stage `predictions`: what the static arms answer to the released episodes, from the recorded observations. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.agents.decision import DecisionConstants
from ovman.agents.prediction import Outcome, Prediction, write
from ovman.agents.single_visit import single_visit
from ovman.agents.two_visits import AssociationConstants, answer
from ovman.sim.recorded import world_state
from ovman.task import Query, Relation
from ovman.task.record import read_records


def association_constants(constants: Any) -> AssociationConstants:
    """gamma and lambda of config.yaml."""
    return AssociationConstants(constants.association.gate_m, constants.association.feature_scale_m)


def decision_constants(constants: Any) -> DecisionConstants:
    """tau and tau_trk of config.yaml."""
    return DecisionConstants(tau_m=constants.admissibility.tau_m, track_spread_m=constants.association.track_spread_m)


def predict(arm: str, trial: Mapping[str, Any], constants: Any) -> Outcome:
    """What an arm with positions handed over answers to the query of a trial, given what was recorded of both visits."""
    candidate, measured = trial["candidate"], trial["measured"]
    query = Query(candidate["category"], Relation(candidate["relation"]))
    worlds = [
        world_state(measured["sightings"][v], query.category, constants.admissibility.minimum_mask_px)
        for v in ("first", "second")
    ]
    if arm == "positions_two_visits":
        return answer(query, *worlds, association_constants(constants), decision_constants(constants))
    if arm == "positions_single_visit":
        tracks = [k.track for k in worlds[1].category(query.category)]
        return single_visit(query.relation, tracks, list(zip(*measured["reachable_box"].values(), strict=True)))
    raise ValueError(f"{arm!r} is not a static arm with positions handed over")


def run(arm: str, episodes_file: Path, trials_files: Sequence[Path], constants: Any, output: Path) -> None:
    """Write the predictions of an arm for all released episodes."""
    trials = {t["candidate"]["id"]: t for file in trials_files for t in read_records(file)}
    names = [episode["id"] for episode in read_records(episodes_file)]
    write(output, [Prediction(name, arm, 0, predict(arm, trials[name], constants)) for name in names])
    print(f"{arm}: {len(names)} predictions", flush=True)

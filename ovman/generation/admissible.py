"""Stage `admissible`: the verdict on every trial and the first reason against it (Algorithm 1, lines 4, 6 to 8). Pure."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ovman.models.record import read_records
from ovman.models.settings import Settings
from ovman.sim.recorded import world_state
from ovman.task import Instance, Query, Rejection, Relation, WorldState, admissible

SCHEMA = "ovman-verdict/1"
BEYOND_MEASUREMENT = "beyond_measurement"
"""How a trial ends that no setting within the bounds of `measurement` would accept; the verdict names the threshold."""


def truth(entries: list[Mapping[str, Any]], mover: Mapping[str, Any] | None) -> WorldState:
    """The world state of a category as it was, whether or not it was recorded; a mover has its whole path as its track."""
    return WorldState(tuple(_instance(e, mover if mover and mover["instance"] == e["id"] else None) for e in entries))


def _instance(entry: Mapping[str, Any], mover: Mapping[str, Any] | None) -> Instance:
    if mover is None:
        return Instance(entry["id"], entry["category"], entry["x"], entry["z"])
    return Instance.tracked(entry["id"], entry["category"], tuple((p["x"], p["z"]) for p in mover["path"]))


def reasons(trial: Mapping[str, Any], constants: Settings) -> Iterator[Rejection]:
    """Everything that speaks against a trial, in the order of Algorithm 1."""
    candidate, measured = trial["candidate"], trial["measured"]
    relation = Relation(candidate["relation"])
    limits = constants.admissibility
    ended = measured["ended"]
    if ended is not None and ended != BEYOND_MEASUREMENT:
        yield Rejection(ended)
        return
    if any(metres < constants.candidates.delta_min_m for metres in _displacements(candidate, measured)):
        yield Rejection.DISPLACEMENT_BELOW_MINIMUM
    if any(metres < constants.candidates.spawn_clearance_m for metres in measured["spawn_clearance_m"].values()):
        yield Rejection.SPAWN_TOO_CLOSE
    if measured["spawn_free_moves"] == 0:
        yield Rejection.SPAWN_IMMOBILE
    if measured["answer_to_navigable_m"] > limits.validity_radius_m:
        yield Rejection.ANSWER_UNREACHABLE
    if relation.current and max((measured["visible_px"] or {"0": 0}).values()) < constants.success.visible_px:
        yield Rejection.ANSWER_NOT_VISIBLE
    if "sightings" not in measured:
        return
    category = candidate["category"]
    changed = frozenset(a["instance"] for a in candidate["first"] + candidate["second"])
    first = world_state(measured["sightings"]["first"], category, limits.min_mask_px)
    second = world_state(measured["sightings"]["second"], category, limits.min_mask_px)
    if not all(_recorded(k, relation, first, second) for k in changed):
        yield Rejection.CHANGED_INSTANCE_NOT_RECORDED
    query = Query(category, relation)
    for world_1, world_2 in ((first, second), (truth(measured["world_1"], None), truth(measured["world_2"], measured["mover"]))):
        against = admissible(world_1, world_2, query, changed, constants, candidate["target"])
        if against is not None:
            yield against.reason
    if any(metres > limits.drift_tolerance_m for metres in measured["drift_m"].values()):
        yield Rejection.DRIFTED


def _displacements(candidate: Mapping[str, Any], measured: Mapping[str, Any]) -> list[float]:
    displaced = {a["instance"] for a in candidate["second"] if a["kind"] == "displace"}
    return [metres for k, metres in measured["displacement_m"].items() if k in displaced]


def _recorded(instance: str, relation: Relation, first: WorldState, second: WorldState) -> bool:
    """Whether a changed instance is recorded in the tour, or tours, that define the relation."""
    if relation is Relation.APPEARED or relation is Relation.MOVING:
        return instance in second.ids
    if relation is Relation.REMOVED:
        return instance in first.ids
    return instance in first.ids and instance in second.ids


def verdict(trial: Mapping[str, Any], constants: Settings) -> dict[str, Any]:
    """The verdict on a trial: "rejected" is null or the first reason, "reasons" are all of them."""
    against = [r.value for r in reasons(trial, constants)]
    return {
        "schema": SCHEMA,
        "id": trial["candidate"]["id"],
        "relation": trial["candidate"]["relation"],
        "rejected": against[0] if against else None,
        "reasons": against,
    }


def run(trials_file: Path, constants: Settings, output: Path) -> None:
    """Write the verdict on every trial of a scene."""
    verdicts = [verdict(trial, constants) for trial in read_records(trials_file)]
    output.write_text("".join(json.dumps(v, separators=(",", ":")) + "\n" for v in verdicts))
    print(f"{trials_file.stem}: {sum(v['rejected'] is None for v in verdicts)} of {len(verdicts)} admissible", flush=True)

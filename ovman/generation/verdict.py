"""Stage `admissible`: the verdict on every trial and the reasons against it (Algorithm 1, lines 4 and 6 to 8). Pure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ovman.models.candidate import Candidate
from ovman.models.query import Query
from ovman.models.record import lines
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.settings import Settings
from ovman.models.trial import Trial, TrialMeasurement, Verdict
from ovman.models.world_state import WorldState
from ovman.task import admissible
from ovman.task.world import recorded_world, true_world


def reasons(trial: Trial, constants: Settings) -> Iterator[Rejection]:
    """Every reason against a trial, in the order of Algorithm 1.

    A trial that ended beyond the bounds of `measurement` is judged by the thresholds like any other, as far as it was measured.
    """
    measured = trial.measured
    if isinstance(measured.ended, Rejection):
        yield measured.ended
        return
    yield from _against_geometry(trial.candidate, measured, constants)
    if measured.sightings is not None:
        yield from _against_observations(trial.candidate, measured, constants)


def _against_geometry(candidate: Candidate, measured: TrialMeasurement, constants: Settings) -> Iterator[Rejection]:
    displaced = {a.instance for a in candidate.second if a.kind == "displace"}
    displacement_m = [metres for k, metres in (measured.displacement_m or {}).items() if k in displaced]
    if any(metres < constants.candidates.delta_min_m for metres in displacement_m):
        yield Rejection.DISPLACEMENT_BELOW_MINIMUM
    if any(metres < constants.candidates.spawn_clearance_m for metres in (measured.spawn_clearance_m or {}).values()):
        yield Rejection.SPAWN_TOO_CLOSE
    if measured.spawn_free_moves == 0:
        yield Rejection.SPAWN_IMMOBILE
    if measured.answer_to_navigable_m is None:
        raise ValueError(f"{candidate.id}: the trial did not end early, but was not measured; run `trials` again")
    if measured.answer_to_navigable_m > constants.admissibility.validity_radius_m:
        yield Rejection.ANSWER_UNREACHABLE
    if candidate.relation.current and max((measured.visible_px or {0: 0}).values()) < constants.success.visible_px:
        yield Rejection.ANSWER_NOT_VISIBLE


def _against_observations(candidate: Candidate, measured: TrialMeasurement, constants: Settings) -> Iterator[Rejection]:
    assert measured.sightings is not None and measured.world_1 is not None and measured.world_2 is not None
    limits, relation = constants.admissibility, candidate.relation
    changed = frozenset(a.instance for a in candidate.first + candidate.second)
    first = recorded_world(measured.sightings.first, candidate.category, limits.min_mask_px)
    second = recorded_world(measured.sightings.second, candidate.category, limits.min_mask_px)
    if not all(_recorded(k, relation, first, second) for k in changed):
        yield Rejection.CHANGED_INSTANCE_NOT_RECORDED
    query = Query(candidate.category, relation)
    for world_1, world_2 in ((first, second), (measured.world_1, true_world(measured.world_2, measured.mover))):
        against = admissible(world_1, world_2, query, changed, constants, candidate.target)
        if against is not None:
            yield against.reason
    if any(metres > limits.drift_tolerance_m for metres in (measured.drift_m or {}).values()):
        yield Rejection.DRIFTED


def _recorded(instance: str, relation: Relation, first: WorldState, second: WorldState) -> bool:
    """Whether a changed instance is recorded in the tour, or tours, that define the relation."""
    if relation is Relation.APPEARED or relation is Relation.MOVING:
        return instance in second.ids
    if relation is Relation.REMOVED:
        return instance in first.ids
    return instance in first.ids and instance in second.ids


def verdict(trial: Trial, constants: Settings) -> Verdict:
    """The verdict on a trial."""
    against = tuple(reasons(trial, constants))
    return Verdict(
        id=trial.candidate.id,
        relation=trial.candidate.relation,
        rejected=against[0] if against else None,
        reasons=against,
    )


def run(trials_file: Path, constants: Settings, output: Path) -> None:
    """Write the verdict on every trial of a scene."""
    verdicts = [verdict(trial, constants) for trial in Trial.read(trials_file)]
    output.write_text(lines(verdicts), encoding="utf-8")
    print(f"{trials_file.stem}: {sum(v.rejected is None for v in verdicts)} of {len(verdicts)} admissible", flush=True)

"""Stage `admissible`: the verdict on every trial and the reasons against it (Algorithm 1, lines 4 and 6 to 8). Pure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from ovman.generation.crossed import FEWEST
from ovman.records.geometry import floor_point
from ovman.records.record import lines
from ovman.records.task import Query, Rejection, Relation, rivals
from ovman.records.trial import Candidate, Trial, TrialMeasurement, Verdict
from ovman.settings import Settings
from ovman.task import admissible, recorded_world, true_world


def reasons(trial: Trial, constants: Settings) -> Iterator[Rejection]:
    """Yield every reason against a trial, in the order of Algorithm 1.

    A trial that ended beyond the bounds of `measurement` is judged by the thresholds like any other, as far as it was measured.
    """
    measured = trial.measured
    if isinstance(measured.ended, Rejection):
        yield measured.ended
        return
    yield from against_geometry(trial.candidate, measured, constants)
    if measured.sightings is not None:
        yield from against_observations(trial.candidate, measured, constants)
        yield from against_drift(measured, constants)


def against_geometry(candidate: Candidate, measured: TrialMeasurement, constants: Settings) -> Iterator[Rejection]:
    """Reasons of lines 3 and 4 of Algorithm 1. ValueError for a trial that was not measured so far."""
    displaced = {a.instance for a in candidate.second if a.kind == "displace"}
    displacement_m = [metres for k, metres in (measured.displacement_m or {}).items() if k in displaced]
    if any(metres < constants.candidates.delta_min_m for metres in displacement_m):
        yield Rejection.DISPLACEMENT_BELOW_MINIMUM
    if any(metres < constants.candidates.spawn_clearance_m for metres in (measured.spawn_clearance_m or {}).values()):
        yield Rejection.SPAWN_TOO_CLOSE
    if candidate.pair is not None and _is_at_answer(candidate, measured, constants.success.radius_m):
        yield Rejection.SPAWN_AT_ANSWER
    if measured.spawn_free_moves == 0:
        yield Rejection.SPAWN_IMMOBILE
    if measured.answer_to_navigable_m is None:
        raise ValueError(f"{candidate.id}: the trial did not end early, but was not measured; run `trials` again")
    if measured.answer_to_navigable_m > constants.admissibility.validity_radius_m:
        yield Rejection.ANSWER_UNREACHABLE
    if candidate.relation.current and max((measured.visible_px or {0: 0}).values()) < constants.success.visible_px:
        yield Rejection.ANSWER_NOT_VISIBLE


def against_observations(candidate: Candidate, measured: TrialMeasurement, constants: Settings) -> Iterator[Rejection]:
    """Reasons of line 6 of Algorithm 1, for a trial whose tours were recorded."""
    assert measured.sightings is not None and measured.world_1 is not None and measured.world_2 is not None
    limits, relation = constants.admissibility, candidate.relation
    query = Query(candidate.category, relation)
    crossed = candidate.pair is not None
    if crossed and _is_rival_near(candidate, measured, constants):
        yield Rejection.RIVAL_NEAR
    changed = frozenset(a.instance for a in candidate.first + candidate.second if a.instance not in candidate.others)
    first = recorded_world(measured.sightings.first, candidate.category, limits.min_mask_px)
    second = recorded_world(measured.sightings.second, candidate.category, limits.min_mask_px)
    if not all(_is_recorded(candidate, k, k in first, k in second) for k in changed):
        yield Rejection.CHANGED_INSTANCE_NOT_RECORDED
    if crossed and len(first if relation.past else second) < FEWEST:
        yield Rejection.FEW_RECORDED
    target = candidate.target
    # Otherwise nothing that is recorded of a mover tells it from standing instances.
    if relation is Relation.MOVING and not (target in second and second[target].extent_m > limits.mover_spread_m):
        yield Rejection.MOTION_NOT_RECORDED
    for world_1, world_2 in ((first, second), (measured.world_1, true_world(measured.world_2, measured.movers))):
        against = admissible(world_1, world_2, query, changed, constants, candidate.target)
        if against is not None:
            yield against.reason


def against_drift(measured: TrialMeasurement, constants: Settings) -> Iterator[Rejection]:
    """Yield the reason of line 7 of Algorithm 1."""
    if any(metres > constants.admissibility.drift_tolerance_m for metres in (measured.drift_m or {}).values()):
        yield Rejection.DRIFTED


def _is_at_answer(candidate: Candidate, measured: TrialMeasurement, beyond_m: float) -> bool:
    """Return whether the spawn is within `beyond_m` of the answer, of nu(answer), or of the target's box if it is present.

    Visibility of the target does not matter: an agent can turn on the spot to see it.
    """
    if candidate.spawn is None:
        return False
    spawn = candidate.spawn.x, candidate.spawn.z
    away_m = [math.dist(spawn, point) for point in (measured.answer, measured.nearest_navigable) if point is not None]
    return min([*away_m, math.inf if measured.spawn_to_box_m is None else measured.spawn_to_box_m]) <= beyond_m


def _is_recorded(candidate: Candidate, instance: str, in_first: bool, in_second: bool) -> bool:
    """Return whether a changed instance, seen in the first tour and in the second or not, is seen where its change shows."""
    if any(alteration.instance == instance for alteration in candidate.first):
        return in_second
    kind = next(alteration.kind for alteration in candidate.second if alteration.instance == instance)
    return (in_first or kind == "motion") and (in_second or kind == "disable")


def _is_rival_near(candidate: Candidate, measured: TrialMeasurement, constants: Settings) -> bool:
    """Return whether a rival is near the answer, or nearer to its navigable cell than the answer (exclusive success)."""
    terms = constants.splits[candidate.split].crossed
    assert terms is not None and measured.answer is not None and measured.nearest_navigable is not None
    assert measured.changed is not None and measured.world_1 is not None and measured.world_2 is not None
    before = {k: floor_point(two.before) for k, two in measured.changed.items()}
    after = {k: floor_point(two.after) for k, two in measured.changed.items()}
    query, worlds = Query(candidate.category, candidate.relation), (measured.world_1, measured.world_2)
    places = rivals(query, candidate.target, *worlds, (before, after), candidate.stable)
    answer, goal = measured.answer, measured.nearest_navigable
    return any(math.dist(at, answer) < terms.apart_m or math.dist(goal, at) <= math.dist(goal, answer) for at in places)


def verdict(trial: Trial, constants: Settings) -> Verdict:
    """Return the verdict on a trial."""
    against = tuple(reasons(trial, constants))
    return Verdict(
        id=trial.candidate.id, relation=trial.candidate.relation, rejected=against[0] if against else None, reasons=against
    )


def run(trials_file: Path, constants: Settings, output: Path) -> None:
    """Write the verdict on every trial of a scene."""
    verdicts = [verdict(trial, constants) for trial in Trial.read(trials_file)]
    output.write_text(lines(verdicts), encoding="utf-8")
    print(f"{trials_file.stem}: {sum(v.rejected is None for v in verdicts)} of {len(verdicts)} admissible", flush=True)

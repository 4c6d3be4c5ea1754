"""Stage `episodes`: judges the certification runs, releases the split, and counts the rejections. Pure.

Source: Algorithm 1, lines 9 to 12.
"""

from __future__ import annotations

import csv
import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from ovman import seeds
from ovman.evaluation.scores import is_success
from ovman.generation.selection import select_crossed, select_in_turn
from ovman.language import noun, sentence
from ovman.records.episode import Episode, Protocol, Provenance
from ovman.records.record import lines
from ovman.records.scene import Alteration, Change
from ovman.records.task import CERTIFIED, DRAWN, RELEASED, Rejection, Relation
from ovman.records.trial import Certification, CertificationRun, OracleRun, Trial, Verdict
from ovman.records.visit import Sightings
from ovman.settings import MAIN, Settings
from ovman.settings.benchmark import Success

AUDIT = ("relation", "stage", "reason", "count")
T = TypeVar("T")


class ShortSplitError(ValueError):
    """Fewer episodes were certified than the settings of the split ask for; one line with the counts and the remedies."""

    says_all = True


def rejection(verdict: Verdict, runs: Sequence[OracleRun], success: Success, exclusive: bool = False) -> Rejection | None:
    """Return why a trial is not certified; None if it is: admissible, feasible, and completed in every certification run.

    exclusive: as for `ovman.task.success`.
    """
    if verdict.rejected is not None:
        return verdict.rejected
    feasible, *certified = (is_success(run, verdict.relation, success, exclusive) for run in runs)
    if not feasible:
        return Rejection.FEASIBILITY_FAILED
    return None if all(certified) else Rejection.CERTIFICATION_FAILED


def episode(trial: Trial, runs: Sequence[OracleRun], settings: Settings) -> Episode:
    """Return the episode of a certified trial. ValueError for a trial that ended early."""
    candidate, measured = trial.candidate, trial.measured
    relation, word = candidate.relation, noun(candidate.category)
    world_1, world_2 = known(measured.world_1), known(measured.world_2)
    return Episode(
        id=candidate.id,
        pair=candidate.pair,
        split=candidate.split,
        backend=settings.benchmark.backend,
        scene=candidate.scene,
        relation=relation,
        category=candidate.category,
        noun=word,
        sentence=sentence(relation, word),
        target=candidate.target,
        distractor=candidate.distractor,
        changes=tuple(
            _change(trial, alteration, first)
            for first, alterations in ((True, candidate.first), (False, candidate.second))
            for alteration in alterations
        ),
        tours=candidate.tours,
        visits=known(measured.visits),
        movers=tuple(mover.start for mover in measured.movers),
        spawn=known(candidate.spawn),
        answer=known(measured.answer),
        nearest_navigable=known(measured.nearest_navigable),
        shortest_path_m=known(measured.shortest_path_m),
        reachable_box=known(measured.reachable_box),
        instances_in_category=max(len(world_1), len(world_2)),
        world_1=world_1,
        world_2=world_2,
        drift_m=known(measured.drift_m),
        certification=tuple(_certified(run, relation, settings.success, candidate.rules.exclusive) for run in runs),
        protocol=Protocol(camera=settings.camera, primitives=settings.primitives, mover=settings.mover, success=settings.success),
        stable=candidate.stable,
        rules=candidate.rules,
        provenance=Provenance(seed=settings.benchmark.seed, trial=hashlib.sha256(trial.to_line().encode()).hexdigest()[:24]),
    )


def known(value: T | None) -> T:
    """Return a measurement that a certified trial has. ValueError for one that ended before it."""
    if value is None:
        raise ValueError("the trial ended early: it has no episode")
    return value


def sightings(trial: Trial) -> Sightings:
    """Return what the tours of a trial truly recorded, for diagnostic arms."""
    return Sightings(episode=trial.candidate.id, sightings=known(trial.measured.sightings))


def _certified(run: OracleRun, relation: Relation, success: Success, exclusive: bool) -> CertificationRun:
    terms = {name: getattr(run, name) for name in CertificationRun.model_fields if name != "success"}
    return CertificationRun(**terms, success=is_success(run, relation, success, exclusive))


def _change(trial: Trial, alteration: Alteration, first: bool) -> Change:
    """Return what happened to an instance between the visits. An instance that is gone in the first visit is "enable"."""
    candidate, measured, instance = trial.candidate, trial.measured, alteration.instance
    where, paths = known(measured.changed)[instance], {mover.instance: mover.path for mover in measured.movers}
    return Change(
        instance=instance,
        category=candidate.others.get(instance, candidate.category),
        kind="enable" if first else alteration.kind,
        before=where.before,
        after=where.after,
        path=paths[instance] if alteration.kind == "motion" else None,
        placement=alteration.placement,
        height_m=alteration.height_m,
        yaw_deg=alteration.yaw_deg,
        roam=alteration.roam,
    )


def run(
    trials_file: Path,
    admissible_file: Path,
    certified_file: Path,
    settings: Settings,
    episodes_out: Path,
    sightings_out: Path,
    rejections_out: Path,
    split: str = MAIN,
) -> None:
    """Write the released episodes of a split, their sightings and the audit of rejections.

    ShortSplitError where a relation has fewer certified episodes than the split asks for, unless the settings allow that.
    """
    trials = {trial.candidate.id: trial for trial in Trial.read(trials_file)}
    verdicts = {verdict.id: verdict for verdict in Verdict.read(admissible_file)}
    runs = {record.id: record.runs for record in Certification.read(certified_file)}
    rejections = {
        k: rejection(verdicts[k], runs.get(k, ()), settings.success, trial.candidate.rules.exclusive)
        for k, trial in trials.items()
    }
    relation_of = {k: trial.candidate.relation for k, trial in trials.items()}
    certified = [k for k, against in rejections.items() if against is None]
    crossed = settings.splits[split].crossed
    if crossed is None:
        released = _select(split, settings, trials, certified)
    else:
        released = select_crossed((trials[k] for k in certified), *crossed.queries)
        rejections |= dict.fromkeys(set(certified) - set(released), Rejection.NOT_CROSSED)
        print(f"{split}: {len(released)} released of {len(certified)} certified", flush=True)
    order = {scene: i for i, scene in enumerate(dict.fromkeys(trial.candidate.scene for trial in trials.values()))}
    released.sort(key=lambda k: (order[trials[k].candidate.scene], list(Relation).index(relation_of[k]), k))
    episodes_out.write_text(lines(episode(trials[k], runs[k], settings) for k in released), encoding="utf-8")
    sightings_out.write_text(lines(sightings(trials[k]) for k in released), encoding="utf-8")
    with rejections_out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(AUDIT)
        writer.writerows(count_candidates(rejections, relation_of, released))


def _select(split: str, settings: Settings, trials: Mapping[str, Trial], certified: Sequence[str]) -> list[str]:
    """Return the ids that a split releases, relation by relation.

    ShortSplitError if a relation has fewer certified episodes than the split asks for, unless the settings allow that.
    """
    relation_of = {k: trial.candidate.relation for k, trial in trials.items()}
    terms, where = settings.splits[split], f"splits.{split}.episodes"
    names = ("split", *terms.stream)
    released: list[str] = []
    short: list[str] = []
    for relation in Relation:
        pool: dict[str, list[str]] = {}
        for k in certified:
            if relation_of[k] is relation:
                pool.setdefault(trials[k].candidate.scene, []).append(k)
        wanted = getattr(terms.episodes, relation.value)
        chosen = select_in_turn(pool, wanted, seeds.generator(settings.benchmark.seed, *names, relation.value))
        there = sum(map(len, pool.values()))
        print(f"{split}, {relation.value}: {len(chosen)} released of {there} certified, {wanted} wanted", flush=True)
        if len(chosen) < wanted and not settings.benchmark.allow_short_split:
            short.append(f"{relation.value} {there} of {wanted}")
        released += chosen
    if short:
        remedy = f"raise splits.{split}.draws, lower {where}, or set benchmark.allow_short_split to true"
        raise ShortSplitError(f"{where} asks for more episodes than were certified ({', '.join(short)}); {remedy}")
    return released


def count_candidates(
    rejections: Mapping[str, Rejection | None], relation_of: Mapping[str, Relation], released: Iterable[str]
) -> list[tuple[str, str, str, int]]:
    """Count candidates per relation, stage and reason: drawn, rejected, certified and released. Rows of AUDIT.

    rejections, relation_of: by the id of a trial; released: ids of the trials that became episodes.
    """
    released = set(released)
    rows = []
    for relation in Relation:
        ids = [k for k in rejections if relation_of[k] is relation]
        counts = Counter(r for k in ids if (r := rejections[k]) is not None)
        rows.append((relation.value, DRAWN, "", len(ids)))
        rows += [(relation.value, r.stage.value, r.value, counts[r]) for r in Rejection if counts[r]]
        rows.append((relation.value, CERTIFIED, "", len(ids) - counts.total()))
        rows.append((relation.value, RELEASED, "", sum(k in released for k in ids)))
    return rows

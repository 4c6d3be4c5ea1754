"""Stage `certified`: the oracle agent runs every admissible trial, once for feasibility, then to certify. Measured only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.interface import Query as Asked
from ovman.agents.interface import Visit
from ovman.agents.oracle import Oracle
from ovman.agents.pilot import Pilot
from ovman.cache import Cache, digest
from ovman.env import Env, Terms, alias
from ovman.processes import Units, map_items
from ovman.records.geometry import Point, Spawn, floor_point
from ovman.records.record import lines
from ovman.records.run import Measured
from ovman.records.scene import Alteration, MoverStart
from ovman.records.task import Query, Relation, rivals
from ovman.records.trial import Certification, OracleRun, Trial, TrialMeasurement, Verdict
from ovman.runner import drive
from ovman.settings import Settings
from ovman.settings.splits import Rules
from ovman.sim.session import Session


@dataclass(frozen=True)
class TrialRun:
    """The part of a complete trial that a run depends on; a released episode has the same."""

    query: Query
    target: str
    spawn: Spawn
    answer: Point
    nearest_navigable: Point
    movers: tuple[MoverStart, ...]
    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    stable: Mapping[str, Point]
    rules: Rules
    measured: TrialMeasurement

    @staticmethod
    def of(trial: Trial) -> TrialRun:
        """Return what a run of an admissible trial depends on."""
        candidate, measured = trial.candidate, trial.measured
        assert candidate.spawn is not None and measured.answer is not None and measured.nearest_navigable is not None
        return TrialRun(
            Query(candidate.category, candidate.relation),
            candidate.target,
            candidate.spawn,
            measured.answer,
            measured.nearest_navigable,
            tuple(mover.start for mover in measured.movers),
            candidate.first,
            candidate.second,
            candidate.stable,
            candidate.rules,
            measured,
        )

    @property
    def gone(self) -> frozenset[str]:
        """Ids of the instances that are absent from visit 2."""
        return frozenset(alteration.instance for alteration in self.second if alteration.kind == "disable")

    def rivals(self, now: Mapping[str, Point] = {}) -> tuple[Point, ...]:
        """Return the places that are wrong answers if success is exclusive, none if not. now: Present places of movers."""
        changed, world_1, world_2 = self.measured.changed, self.measured.world_1, self.measured.world_2
        if not self.rules.exclusive or changed is None or world_1 is None or world_2 is None:
            return ()
        before = {instance: floor_point(one.before) for instance, one in changed.items()}
        after = {instance: floor_point(one.after) for instance, one in changed.items()}
        return rivals(self.query, self.target, world_1, world_2, (before, after), self.stable, now)

    def alterations(self, visit: str) -> tuple[Alteration, ...]:
        """Return the differences from the untouched scene in the visit "first" or "second"."""
        return self.first if visit == "first" else self.second


def oracle_run(session: Session, trial: Trial, seed: int, constants: Settings) -> Measured:
    """One run of the oracle agent on an admissible trial under `seed`, which orders equal paths and drives the movers."""
    episode = TrialRun.of(trial)
    assert trial.measured.visits is not None
    paths, mover = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])
    name_of = partial(alias, trial.measured.visits.second)
    moving = episode.query.relation is Relation.MOVING
    pilot = Pilot(constants.primitives, paths, episode.rules.grid == "first")
    agent = Oracle(pilot, episode.answer, name_of(episode.target) if moving else None)
    second = trial.candidate.tours.second
    sensors = None if second.sensors is None else second.sensors.model_copy(update={"seed": seed})
    env = Env(session, constants)
    env.reset(episode, Terms(mover, light=second.light, sensors=sensors, name_of=name_of), looks=False)
    drive(env, agent, lambda which, reachable: Visit((), reachable), Asked(episode.query.category, episode.query.relation))
    return env.measured


def certify(session: Session, trial: Trial, constants: Settings) -> Certification:
    """Return the measured runs of a trial: run 0 is the feasibility run, the others certify."""
    name = trial.candidate.id
    runs = []
    for number in range(1 + constants.admissibility.runs):
        seed = seeds.integer(constants.benchmark.seed, "certification", name, number)
        runs.append(OracleRun(run=number, seed=seed, **dict(oracle_run(session, trial, seed, constants))))
    return Certification(id=name, runs=tuple(runs))


def run(admissible_file: Path, trials_file: Path, settings: Settings, output: Path, cache: Cache, workers: int = 1) -> None:
    """Certify the admissible trials and write the runs to `output`, in the order of the verdicts.

    A scene whose certifications are all in the cache starts no simulator.
    """
    trials = {trial.candidate.id: trial for trial in Trial.read(trials_file)}
    by_scene: dict[str, list[Trial]] = {}
    for verdict in Verdict.read(admissible_file):
        if verdict.rejected is None:
            by_scene.setdefault(trials[verdict.id].candidate.scene, []).append(trials[verdict.id])
    certify_all = partial(_certify_scene, settings=settings, cache=cache)
    output.write_text("".join(map_items(certify_all, [lines(one) for one in by_scene.values()], workers)), encoding="utf-8")


def _certify_scene(trial_lines: str, settings: Settings, cache: Cache) -> str:
    """Return the certifications of trials of one scene, as lines."""
    trials = [Trial.parse(line) for line in trial_lines.splitlines()]
    done, units = [], Units(len(trials))
    with Session(trials[0].candidate.scene, settings) as session:

        def measure(trial: Trial) -> dict[str, Any]:
            return session.with_restarts(lambda: certify(session, trial, settings).to_json())

        for trial in trials:
            found = cache.get_or_compute(digest(trial.to_json(), settings.constants()), partial(measure, trial))
            done.append(Certification.from_json(found))
            units.done(f"{trial.candidate.id}: {', '.join(run.outcome for run in done[-1].runs)}")
    return lines(done)

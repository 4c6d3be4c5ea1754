"""Stage `certified`: the oracle agent runs every admissible trial, once for feasibility, then to certify. Measured only."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import Query, Relation, Visit
from ovman.agents.oracle import Oracle
from ovman.agents.pilot import Pilot
from ovman.evaluation.rollout import alias, roll_out
from ovman.models.change import Alteration, MoverStart
from ovman.models.geometry import Spawn
from ovman.models.record import read_records
from ovman.sim.session import Session
from ovman.workflow import seeds
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

SCHEMA = "ovman-certification/1"


class TrialRun:
    """A measured trial as a run of the oracle sees it."""

    def __init__(self, trial: Mapping[str, Any]) -> None:
        candidate, measured = trial["candidate"], trial["measured"]
        self.query = Query(candidate["category"], Relation(candidate["relation"]))
        self.target, self.spawn = str(candidate["target"]), Spawn.from_json(candidate["spawn"])
        self.answer = measured["answer"]["x"], measured["answer"]["z"]
        self.nearest_navigable = measured["nearest_navigable"]["x"], measured["nearest_navigable"]["z"]
        self.mover = None if measured["mover"] is None else MoverStart.from_json(measured["mover"])
        self._second = tuple(Alteration.from_json(record) for record in candidate["second"])

    @property
    def gone(self) -> frozenset[str]:
        """Ids of the instances that are absent from visit 2."""
        return frozenset(alteration.instance for alteration in self._second if alteration.kind == "disable")

    def alterations(self, visit: str) -> tuple[Alteration, ...]:
        """What differs from the untouched scene in visit 2."""
        return self._second


def oracle_run(session: Session, trial: Mapping[str, Any], seed: int, constants: StageSettings) -> dict[str, Any]:
    """One run of the oracle agent on a trial under `seed`, which orders equal paths and drives the mover."""
    episode = TrialRun(trial)
    paths, mover = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])
    visit = trial["measured"]["visits"]["second"]

    def name_of(instance: str) -> str:
        return alias(visit, instance)

    moving = episode.query.relation is Relation.MOVING
    agent = Oracle(Pilot(constants.primitives, paths), episode.answer, name_of(episode.target) if moving else None)
    run = roll_out(session, episode, agent, None, lambda cells: Visit((), cells), name_of, mover, constants)
    return {"seed": seed} | run.to_json()


def certify(session: Session, trial: Mapping[str, Any], constants: StageSettings) -> dict[str, Any]:
    """The measured runs of a trial: run 0 is the feasibility run, the others certify."""
    name = trial["candidate"]["id"]
    runs = [
        {"run": r} | oracle_run(session, trial, seeds.integer(constants.benchmark.seed, "certification", name, r), constants)
        for r in range(1 + constants.admissibility.runs)
    ]
    return {"schema": SCHEMA, "id": name, "runs": runs}


def run(admissible_file: Path, trials_file: Path, constants: StageSettings, output: Path, journal: Path) -> None:
    """Certify the admissible trials of a scene; `journal` keeps finished ones, and no simulator starts where all are there."""
    trials = {t["candidate"]["id"]: t for t in read_records(trials_file)}
    admitted = [v["id"] for v in read_records(admissible_file) if v["rejected"] is None]
    kept = Journal(journal)
    lines = []
    with Session(trials_file.stem, constants) as session:
        for name in admitted:
            record = kept.unit(
                digest(trials[name], constants.canonical),
                lambda name=name: session.surviving(lambda: certify(session, trials[name], constants)),
            )
            lines.append(json.dumps(record, separators=(",", ":")) + "\n")
            print(f"{name}: {', '.join(r['outcome'] for r in record['runs'])}", flush=True)
    output.write_text("".join(lines))

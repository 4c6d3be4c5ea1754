"""Stage `certified`: the oracle agent runs every admissible trial, once for feasibility, then to certify. Measured only."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.oracle import Oracle
from ovman.agents.pilot import Pilot
from ovman.evaluation.assignment import Assignment
from ovman.evaluation.rollout import execute, handed
from ovman.models.record import read_records
from ovman.sim.session import Session
from ovman.task import Relation
from ovman.workflow import seeds
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

SCHEMA = "ovman-certification/1"


def oracle_run(session: Session, trial: Mapping[str, Any], seed: int, constants: StageSettings) -> dict[str, Any]:
    """One run of the oracle agent on a trial under `seed`, which orders equal paths and drives the mover."""
    assignment = Assignment.of(trial)
    paths, mover = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])
    visit = trial["measured"]["visits"]["second"]

    def name_of(instance: str) -> str:
        return handed(visit, instance)

    moving = assignment.relation is Relation.MOVING
    agent = Oracle(Pilot(constants.primitives, paths), assignment.answer, name_of(assignment.target) if moving else None)
    return {"seed": seed} | execute(session, assignment, agent, None, lambda cells: Visit((), cells), name_of, mover, constants)


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

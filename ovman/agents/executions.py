"""Stage `executions`: the embodied arms run the released episodes of a scene, measured at the stop. Nothing is judged here."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.agent import CameraPose, Observation, Sighting, Visit
from ovman.agents.embodied import Assignment, execute, handed
from ovman.agents.oracle import Oracle
from ovman.agents.pilot import Pilot
from ovman.agents.predictions import association_constants, decision_constants
from ovman.agents.two_visits import TwoVisits
from ovman.journal import Journal, digest
from ovman.navigation import Primitives
from ovman.sim.session import Session
from ovman.task import Relation
from ovman.task.record import read_records

SCHEMA = "ovman-run/1"


def _tour(visit: str, sightings: Sequence[Mapping[str, Any]], category: str, minimum_px: int, reachable: np.ndarray) -> Visit:
    """A recorded visit as an agent with handed positions is given it: which instances each view recorded, and where."""
    views: dict[int, list[Sighting]] = {}
    for seen in sightings:
        if seen["px"] >= minimum_px:
            views.setdefault(seen["view"], []).append(Sighting(handed(visit, seen["instance"]), category, seen["x"], seen["z"]))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)


def execution(session: Session, arm: str, seed: int, trial: Mapping[str, Any], constants: Any) -> dict[str, Any]:
    """One embodied run of an arm on a trial: the measured part of an "ovman-run/1" record."""
    assignment, measured = Assignment.of(trial), trial["measured"]
    name = trial["candidate"]["id"]
    pilot = Pilot(Primitives.of(constants), seeds.generator(constants.benchmark.seed, "paths", arm, name, seed))
    visits = measured["visits"]

    def name_of(instance: str) -> str:
        return handed(visits["second"], instance)

    def tour(which: str, reachable: np.ndarray) -> Visit:
        return _tour(
            visits[which], measured["sightings"][which], assignment.category, constants.admissibility.minimum_mask_px, reachable
        )

    if arm == "oracle_check":
        moving = assignment.relation is Relation.MOVING
        agent: Any = Oracle(pilot, assignment.answer, name_of(assignment.target) if moving else None)
    elif arm == "two_visits_oracle_positions":
        agent = TwoVisits(pilot, association_constants(constants), decision_constants(constants))
    else:
        raise ValueError(f"{arm!r} is not an embodied arm with positions handed over")
    mover = seeds.generator(constants.benchmark.seed, "mover", arm, name, seed)
    nothing = np.empty((0, 2))
    run = execute(
        session, assignment, agent, tour("first", nothing), lambda cells: tour("second", cells), name_of, mover, constants
    )
    return {"schema": SCHEMA, "episode": name, "arm": arm, "seed": seed} | run


def run(
    arm: str, scene: str, episodes_file: Path, trials_file: Path, constants: Any, outputs: Mapping[int, Path], journal: Path
) -> None:
    """Run an arm on the episodes of a scene under every seed of `outputs` (seed -> file); `journal` keeps finished runs."""
    trials = {t["candidate"]["id"]: t for t in read_records(trials_file)}
    names = [e["id"] for e in read_records(episodes_file) if e["scene"] == scene]
    kept = Journal(journal)
    with Session(scene, constants) as session:
        for seed, output in outputs.items():
            lines = []
            for name in names:
                key = digest(arm, seed, trials[name], constants.canonical)
                record = kept.unit(
                    key,
                    lambda name=name, seed=seed: session.surviving(
                        lambda: execution(session, arm, seed, trials[name], constants)
                    ),
                )
                lines.append(json.dumps(record, separators=(",", ":")) + "\n")
                print(f"{name} {arm} seed {seed}: {record['outcome']} after {record['actions']} actions", flush=True)
            output.parent.mkdir(parents=True, exist_ok=True)
            output.write_text("".join(lines))

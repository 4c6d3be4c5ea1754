"""Stage `executions`: the embodied arms run the released episodes of a scene, measured at the stop. Nothing is judged here."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.agent import Agent, CameraPose, Observation, Sighting, Visit
from ovman.agents.arms import Source, named
from ovman.agents.embodied import Assignment, execute, handed
from ovman.agents.mapper import KeptMaps
from ovman.agents.oracle import Oracle
from ovman.agents.pilot import Pilot
from ovman.agents.prediction import outcome_json
from ovman.agents.predictions import (
    Perceived,
    association_constants,
    decision_constants,
    predict,
    read_perceived,
    reference_constants,
)
from ovman.agents.reference import ReferenceAgent, SingleVisitAgent
from ovman.agents.tours import content, recorded
from ovman.agents.two_visits import TwoVisits
from ovman.journal import Journal, digest
from ovman.navigation import Primitives
from ovman.sim.session import Session
from ovman.task import Relation
from ovman.task.record import read_records

SCHEMA = "ovman-run/1"


Tour = Callable[[str, np.ndarray], Visit]
"""A visit as an agent is given it: "first" or "second", and the positions (K, 2) in metres that can be reached in it."""


class Eyes:
    """What an arm with positions of its own sees with in a scene: recorded tours, and the maps that were made of them.

    perceived: maps by the names of the visits. Names tell what was changed, so an agent finds its maps by what the tours show.
    """

    def __init__(self, perceived: Perceived, visits: Path, field_of_view_deg: float) -> None:
        self.perceived, self._visits, self._field_of_view_deg = perceived, visits, field_of_view_deg
        self.mapper = KeptMaps({content(visits / name, field_of_view_deg): clusters for name, clusters in perceived.maps.items()})

    def tour(self, visits: Mapping[str, str]) -> Tour:
        """The tours of an episode, given the names of its visits."""
        return lambda which, reachable: recorded(self._visits / visits[which], self._field_of_view_deg, reachable)


def _tour(visit: str, sightings: Sequence[Mapping[str, Any]], category: str, minimum_px: int, reachable: np.ndarray) -> Visit:
    """A recorded visit as an agent with handed positions is given it: which instances each view recorded, and where."""
    views: dict[int, list[Sighting]] = {}
    for seen in sightings:
        if seen["px"] >= minimum_px:
            views.setdefault(seen["view"], []).append(Sighting(handed(visit, seen["instance"]), category, seen["x"], seen["z"]))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)


def execution(
    session: Session, arm: str, seed: int, trial: Mapping[str, Any], constants: Any, eyes: Eyes | None = None
) -> dict[str, Any]:
    """One embodied run of an arm on a trial: the measured part of an "ovman-run/1" record.

    eyes: what an arm with positions of its own sees with; an arm with positions handed over has no use for them.
    """
    assignment, name = Assignment.of(trial), trial["candidate"]["id"]
    pilot = Pilot(Primitives.of(constants), seeds.generator(constants.benchmark.seed, "paths", arm, name, seed))
    if named(arm).positions is Source.HANDED:
        agent, tour, name_of = _handed(arm, pilot, trial["measured"], assignment, constants)
    else:
        if eyes is None:
            raise ValueError(f"{arm!r} answers from maps of its own: give it eyes")
        draws = seeds.generator(constants.benchmark.seed, "picks", arm, name, seed)
        agent, tour, name_of = _own(arm, pilot, draws, constants, eyes), eyes.tour(trial["measured"]["visits"]), None
    mover = seeds.generator(constants.benchmark.seed, "mover", arm, name, seed)
    nothing = np.empty((0, 2))
    run = execute(
        session, assignment, agent, tour("first", nothing), lambda cells: tour("second", cells), name_of, mover, constants
    )
    return {"schema": SCHEMA, "episode": name, "arm": arm, "seed": seed} | run


def _handed(
    arm: str, pilot: Pilot, measured: Mapping[str, Any], assignment: Assignment, constants: Any
) -> tuple[Agent, Tour, Callable[[str], str]]:
    """An agent that is handed positions or the answer, its tours, and how instances are called in the positions it gets."""
    visits = measured["visits"]

    def name_of(instance: str) -> str:
        return handed(visits["second"], instance)

    def tour(which: str, reachable: np.ndarray) -> Visit:
        return _tour(
            visits[which], measured["sightings"][which], assignment.category, constants.admissibility.minimum_mask_px, reachable
        )

    if arm == "oracle_check":
        moving = assignment.relation is Relation.MOVING
        return Oracle(pilot, assignment.answer, name_of(assignment.target) if moving else None), tour, name_of
    if arm == "two_visits_oracle_positions":
        return TwoVisits(pilot, association_constants(constants), decision_constants(constants)), tour, name_of
    raise ValueError(f"{arm!r} is not an embodied arm with positions handed over")


def _own(arm: str, pilot: Pilot, draws: np.random.Generator, constants: Any, eyes: Eyes) -> Agent:
    """The reference agent, with eyes and words of its own."""
    given = pilot, eyes.mapper, eyes.perceived.noun, reference_constants(constants)
    if arm == "two_visits_embodied":
        return ReferenceAgent(*given)
    if arm == "single_visit_embodied":
        return SingleVisitAgent(*given, draws)
    raise ValueError(f"{arm!r} is not an embodied arm with positions of its own")


DECIDING = ("association.", "grounding.", "admissibility.")
"""Constants that say what an agent answers, and not what becomes of it on its way there."""


def unit(arm: str, seed: int, trial: Mapping[str, Any], constants: Any, perceived: Perceived | None) -> str:
    """Key of a run in the journal: all that it depends on. Of perception and of the constants of the decision that is the answer.

    So a threshold of the agent that changes none of its answers starts no simulator.
    """
    stage = json.loads(constants.canonical)
    stage["constants"] = {name: value for name, value in stage["constants"].items() if not name.startswith(DECIDING)}
    drives_to = named(arm).executes
    answered = None if drives_to is None else outcome_json(predict(drives_to, trial, constants, perceived)[0])
    return digest(arm, seed, trial, answered, stage)


def run(
    arm: str,
    scene: str,
    episodes_file: Path,
    trials_file: Path,
    constants: Any,
    outputs: Mapping[int, Path],
    journal: Path,
    visits: Path | None = None,
    maps_file: Path | None = None,
    nouns_file: Path | None = None,
) -> None:
    """Run an arm on the episodes of a scene under every seed of `outputs` (seed -> file); `journal` keeps finished runs.

    visits, maps_file, nouns_file: the scene's recorded visits and what was perceived in them, for an arm with positions of its
    own.
    """
    trials = {t["candidate"]["id"]: t for t in read_records(trials_file)}
    names = [e["id"] for e in read_records(episodes_file) if e["scene"] == scene]
    perceived = None if maps_file is None else read_perceived([maps_file], nouns_file)[scene]
    eyes = None if perceived is None or visits is None else Eyes(perceived, visits, constants.camera.field_of_view_deg)
    kept = Journal(journal)
    with Session(scene, constants) as session:
        for seed, output in outputs.items():
            lines = []
            for name in names:
                record = kept.unit(
                    unit(arm, seed, trials[name], constants, perceived),
                    lambda name=name, seed=seed: session.surviving(
                        lambda: execution(session, arm, seed, trials[name], constants, eyes)
                    ),
                )
                lines.append(json.dumps(record, separators=(",", ":")) + "\n")
                print(f"{name} {arm} seed {seed}: {record['outcome']} after {record['actions']} actions", flush=True)
            output.parent.mkdir(parents=True, exist_ok=True)
            output.write_text("".join(lines))

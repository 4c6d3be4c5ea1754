"""Stage `executions`: the embodied arms run the released episodes of a scene, measured at the stop. Nothing is judged here."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS, CameraPose, Observation, Sighting, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.assignment import assignment_of
from ovman.evaluation.context import Given, Told
from ovman.evaluation.observation_store import Senses, of_scene
from ovman.evaluation.prediction import outcome_json
from ovman.evaluation.predictions import predict
from ovman.evaluation.rollout import Terms, execute, handed
from ovman.evaluation.supervision import Supervised, failures, function
from ovman.language import noun
from ovman.models.record import read_records
from ovman.models.settings import Source
from ovman.models.settings.arms import ArmJob
from ovman.models.trial import Trial
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from ovman.task import Relation
from ovman.workflow import seeds
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

SCHEMA = "ovman-run/1"

Tour = Callable[[str, np.ndarray], Visit]
"""A visit as an agent is given it: "first" or "second", and the positions (K, 2) in metres that can be reached in it."""


def _tour(visit: str, sightings: Sequence[Mapping[str, Any]], category: str, min_mask_px: int, reachable: np.ndarray) -> Visit:
    """A recorded visit as an agent with handed positions is given it: which instances each view recorded, and where."""
    views: dict[int, list[Sighting]] = {}
    for seen in sightings:
        if seen["px"] >= min_mask_px:
            views.setdefault(seen["view"], []).append(Sighting(handed(visit, seen["instance"]), category, seen["x"], seen["z"]))
    nowhere = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)
    return Visit(tuple(Observation(None, None, nowhere, 0.0, True, tuple(views[v])) for v in sorted(views)), reachable)


def execution(
    session: Session, arm: ArmJob, seed: int, trial: Mapping[str, Any], constants: StageSettings, senses: Senses
) -> dict[str, Any]:
    """One embodied run of an arm on a trial: the measured part of an "ovman-run/1" record.

    senses: of the trial's scene. AgentError, in one line, where the agent fails.
    """
    assignment, name, measured = assignment_of(Trial.from_json(trial)), trial["candidate"]["id"], trial["measured"]

    def draws(of: str) -> np.random.Generator:
        return seeds.generator(constants.benchmark.seed, of, arm.name, name, seed)

    visits = measured["visits"]
    name_of: Callable[[str], str] | None = None
    if arm.positions is Source.HANDED:

        def name_of(instance: str) -> str:
            return handed(visits["second"], instance)

        def tour(which: str, reachable: np.ndarray) -> Visit:
            min_mask_px = constants.admissibility.min_mask_px
            return _tour(visits[which], measured["sightings"][which], assignment.category, min_mask_px, reachable)

    else:

        def tour(which: str, reachable: np.ndarray) -> Visit:
            return senses.visit(visits[which], reachable)

    told = None
    if arm.answer is Source.HANDED:
        moving = assignment.relation is Relation.MOVING
        told = Told(assignment.answer, handed(visits["second"], assignment.target) if moving else None)
    given = Given(draws("picks"), constants, Pilot(constants.primitives, draws("paths")), senses, told)
    made = function(arm.name, arm.agent)
    with failures(f"arms.{arm.name}.agent is {arm.agent!r}: it"):
        agent = made(given)
    run = execute(
        session,
        assignment,
        Supervised(agent, arm, f"{name}, seed {seed}"),
        tour("first", np.empty((0, 2))),
        lambda cells: tour("second", cells),
        name_of,
        draws("mover"),
        constants,
        Terms(arm.budget, arm.marks, arm.any_instance),
        seeds.integer(constants.benchmark.seed, "actuation", arm.name, name, seed) if session.embodiment.noisy else None,
    )
    return {"schema": SCHEMA, "episode": name, "arm": arm.name, "seed": seed} | run.to_json()


DECIDING = ("admissibility.",)
"""Constants that say what an agent is handed, and not what becomes of it on its way."""


def unit(arm: ArmJob, seed: int, trial: Mapping[str, Any], constants: StageSettings, senses: Senses) -> str:
    """Key of a run in the journal: all that it depends on.

    Of an arm that executes another one's answer, that answer stands for perception and for the constants of the decision, so
    that a threshold of the agent that changes none of its answers starts no simulator.
    """
    stage = json.loads(constants.canonical)
    executed = stage["arm"].pop("executed", None)
    if executed is None:
        visits = [trial["measured"]["visits"][which] for which in VISITS]
        seen = senses.seen(visits, noun(trial["candidate"]["category"]))
        return digest(seed, trial, seen, stage)
    answered = predict(ArmJob.model_validate(executed), trial, constants, senses)[0]
    of_agent = set(stage.pop("of_agent"))
    stage["constants"] = {k: v for k, v in stage["constants"].items() if k not in of_agent and not k.startswith(DECIDING)}
    stage["agent"] = stage["agent"][:1]
    return digest(seed, trial, outcome_json(answered), stage)


def run(
    arm: ArmJob,
    scene: str,
    episodes_file: Path,
    trials_file: Path,
    constants: StageSettings,
    outputs: Mapping[int, Path],
    journal: Path,
    visits: Path = Path("results", "visits"),
    files: Mapping[str, Sequence[Path]] = {},
) -> None:
    """Run an arm on the episodes of a scene under every seed of `outputs` (seed -> file); `journal` keeps finished runs.

    visits: directory of all scenes' recorded visits. files: what was perceived, as for `ovman.evaluation.predictions.run`.
    """
    trials = {t["candidate"]["id"]: t for t in read_records(trials_file)}
    names = [e["id"] for e in read_records(episodes_file) if e["scene"] == scene]
    senses = Senses(arm, constants, visits / scene, of_scene(scene, files))
    kept = Journal(journal)
    with Session(scene, constants, Embodiment.named(arm.embodiment, constants)) as session:
        lines: dict[int, list[str]] = {seed: [] for seed in outputs}
        for name in names:  # all seeds of one: the simulator keeps the last few worlds
            for seed in outputs:
                record = kept.unit(
                    unit(arm, seed, trials[name], constants, senses),
                    lambda name=name, seed=seed: session.with_restarts(
                        lambda: execution(session, arm, seed, trials[name], constants, senses)
                    ),
                )
                lines[seed].append(json.dumps(record, separators=(",", ":")) + "\n")
                print(f"{name} {arm.name} seed {seed}: {record['outcome']} after {record['actions']} actions", flush=True)
    for seed, output in outputs.items():
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text("".join(lines[seed]))

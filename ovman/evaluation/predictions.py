"""Stage `predictions`: what the static arms answer to the released episodes, from the recorded observations. Pure.

What is handed over to a diagnostic arm is looked up behind `Recorded`, from the trials; the others get their maps and the noun.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.reference.reasoning import Evidence
from ovman.evaluation.context import Recorded
from ovman.evaluation.observation_store import Senses, of_scene
from ovman.evaluation.prediction import Outcome, Prediction, write
from ovman.evaluation.supervision import AgentError, failures, function
from ovman.models.record import read_records
from ovman.models.settings import Arm, Settings, Source
from ovman.task import Query, Relation
from ovman.workflow import seeds


def predict(
    arm: Arm, trial: Mapping[str, Any], constants: Settings, senses: Senses, run: int = 0
) -> tuple[Outcome, Evidence | None]:
    """What a static arm answers to the query of a trial, given what was recorded of both visits, and from which evidence.

    senses: of the trial's scene; run: 0 for the first of the arm's runs. AgentError, in one line, where the arm's function fails.
    """
    candidate, measured = trial["candidate"], trial["measured"]
    recorded = Recorded(
        rng=seeds.generator(constants.benchmark.seed, "predictions", arm.name, candidate["id"], run),
        run=run,
        constants=constants,
        reachable=np.array(list(zip(*measured["reachable_box"].values(), strict=True))),
        visits=measured["visits"],
        category=candidate["category"],
        arm=arm,
        senses=senses,
        sightings=measured["sightings"] if Source.HANDED in (arm.grounding, arm.positions) else None,
    )
    answer = function(arm.name, arm.agent)
    with failures(where := f"arms.{arm.name}.agent is {arm.agent!r}: {candidate['id']}: it"):
        answered = answer(Query(candidate["category"], Relation(candidate["relation"])), recorded)
    match answered:
        case (outcome, Evidence() | None as evidence) if isinstance(outcome, Outcome):
            return outcome, evidence
    raise AgentError(f"{where} returned {answered!r:.80}; return (Answer(x, z), None), or another outcome of a prediction")


def run(
    arm: Arm,
    episodes_file: Path,
    trials_files: Sequence[Path],
    constants: Settings,
    output: Path,
    visits: Path = Path("results", "visits"),
    files: Mapping[str, Sequence[Path]] = {},
) -> None:
    """Write the predictions of an arm for all released episodes, run after run.

    visits: directory of all scenes' recorded visits. files: what was perceived, by the workflow's names for it: under "maps" and
    "dualmap" one file a scene, named after it, under "nouns" one; none for an arm with positions handed over. Prints how long it
    took from the files to the predictions.
    """
    began, worked = time.perf_counter(), time.process_time()
    trials = {t["candidate"]["id"]: t for file in trials_files for t in read_records(file)}
    episodes = list(read_records(episodes_file))
    scenes = dict.fromkeys(episode["scene"] for episode in episodes)
    senses = {scene: Senses(arm, constants, visits / scene, of_scene(scene, files)) for scene in scenes}
    predictions = []
    for number in range(arm.runs):
        for episode in episodes:
            outcome, evidence = predict(arm, trials[episode["id"]], constants, senses[episode["scene"]], number)
            predictions.append(Prediction(episode["id"], arm.name, number, outcome, evidence))
    write(output, predictions)
    took, worked = time.perf_counter() - began, time.process_time() - worked
    print(f"{arm.name}: {len(predictions)} predictions in {took:.2f} s, {worked:.2f} s of the processor", flush=True)

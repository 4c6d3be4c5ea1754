"""An arm that executes another one's answers is offered them: it drives as if it had decided, and looks at nothing."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.controls import depth_difference, pixel_difference
from ovman.agents.dynamem.agent import DynamemAgent as dynamem
from ovman.agents.interface import (
    Abstention,
    AbstentionReason,
    Action,
    Agent,
    AgentContext,
    Answer,
    CameraPose,
    Observation,
    Query,
    Visit,
)
from ovman.agents.pilot import Executor, GoalAgent, Pilot
from ovman.cache import Cache
from ovman.evaluation import rollouts
from ovman.evaluation.context import RolloutContext
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.recorded_tours import load_visit
from ovman.processes import WorkerDied
from ovman.records.prediction import Prediction, as_recorded
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.records.task import Relation
from ovman.records.visit import TourError
from ovman.sim import controller
from tests.arms import CONFIG
from tests.episodes import SIGHTINGS, of_scene
from tests.runs import job

CHOSEN = of_scene("FloorPlan429")[:3]
SIDE, STEP_M = 5, CONFIG.primitives.step_m
FLOOR = np.array([(i * STEP_M, j * STEP_M) for i in range(SIDE) for j in range(SIDE)])
NOWHERE = Path("no such directory")
metres = st.floats(-0.5, SIDE * STEP_M, allow_nan=False)
outcomes = st.one_of(
    st.builds(Answer, metres, metres, st.none() | st.floats(0, 1)), st.builds(Abstention, st.sampled_from(AbstentionReason))
)


class Deciding(GoalAgent):
    """An agent that is offered nothing, or ignores it: it finds the answer itself."""

    def __init__(self, context: AgentContext, outcome: Answer | Abstention) -> None:
        super().__init__(context)
        self._outcome = outcome

    def decide(self, query: Query) -> Answer | Abstention:
        return as_recorded(self._outcome)


def trace(agent: Agent) -> list[Action]:
    """What an agent does on an empty floor, where it gets where it wants to."""
    agent.familiarise(Visit((), FLOOR))
    agent.revisit(Visit((), FLOOR))
    agent.ask(Query("Chair", Relation.MOVED))
    x, z, yaw_deg, done = 0.0, 0.0, 0.0, []
    while len(done) < 100 and done[-1:] not in ([Action.STOP], [Action.ABSTAIN]):
        done.append(agent.act(Observation(None, None, CameraPose(x, 1.5, z, yaw_deg, 0.0), 90.0)))
        if done[-1] is Action.MOVE_AHEAD:
            x, z = x + STEP_M * np.sin(np.radians(yaw_deg)), z + STEP_M * np.cos(np.radians(yaw_deg))
        turn = {Action.ROTATE_LEFT: -1, Action.ROTATE_RIGHT: 1}.get(done[-1], 0) * CONFIG.primitives.turn_deg
        yaw_deg = (yaw_deg + turn) % 360
    return done


@given(outcomes)
def test_an_answer_with_the_digits_of_its_record_is_the_recorded_one(outcome):
    record = Prediction.parse(Prediction.of("e", "arm", 0, outcome).to_line())
    assert record.outcome == as_recorded(outcome) == as_recorded(as_recorded(outcome))


@given(outcomes, st.integers(0, 20))
def test_what_drives_to_the_offered_answer_does_what_decides_itself(outcome, seed):
    offered = Prediction.parse(Prediction.of("e", "arm", 0, outcome).to_line()).outcome
    pilots = [Pilot(CONFIG.primitives, np.random.default_rng(seed)) for _ in range(2)]
    taking = Executor(SimpleNamespace(pilot=pilots[0], answered=offered))
    deciding = Deciding(SimpleNamespace(pilot=pilots[1]), outcome)
    done = trace(taking)
    assert done == trace(deciding) and (done == [Action.ABSTAIN]) == isinstance(outcome, Abstention)


def context(answered: Answer | Abstention | None) -> RolloutContext:
    """Without an observation to look at."""
    arm, settings = job("two_visits_embodied")
    pilot, store = Pilot(CONFIG.primitives, np.random.default_rng(0)), ObservationStore(arm, settings, 90.0, NOWHERE)
    inputs = store.mapper, store.detections_in, store.load_artifact, store.noun, store.networks
    return RolloutContext(np.random.default_rng(0), settings, pilot, *inputs, None, answered)


TAKING = (dynamem, depth_difference, pixel_difference)


@pytest.mark.parametrize("make", TAKING)
def test_the_agents_that_execute_one_answer_take_it_and_look_at_nothing(make):
    agent = make(context(Answer(STEP_M, STEP_M)))
    assert isinstance(agent, Agent) and agent.looks is False
    assert trace(agent)[-1] is Action.STOP
    assert trace(make(context(Abstention(AbstentionReason.NO_MOTION)))) == [Action.ABSTAIN]


PLACE = Answer(0.123456789, 0.987654321)


def static(query: Query, context: object) -> tuple[Answer, None]:
    return PLACE, None


def ignoring(context: AgentContext) -> Deciding:
    return Deciding(context, PLACE)


def taking(context: AgentContext) -> GoalAgent:
    return ignoring(context) if context.answered is None else Executor(context)


def offered_alone(context: AgentContext) -> GoalAgent:
    assert context.answered is not None, "nothing is offered"
    return Executor(context)


def rollouts_of(directory: Path, agent: str, predictions: Path | None) -> tuple[bytes, set[str]]:
    """Return the rollouts of an arm of this module that executes `static` and needs nothing, and their keys in the cache."""
    arm, settings = job("two_visits_embodied")
    executed = arm.executed.model_copy(update={"agent": f"{__name__}:static", "needs": (), "constants": ()})
    arm = arm.model_copy(update={"agent": f"{__name__}:{agent}", "needs": (), "constants": (), "executed": executed})
    name = f"{agent}{'_offered' if predictions else ''}"
    cache, output = Cache(directory / name), directory / f"{name}.jsonl"
    rollouts.run(arm, settings, directory / "episodes.jsonl", [0], output, cache, {}, None, predictions, NOWHERE)
    return output.read_bytes(), {path.parent.name + path.stem for path in cache.directory.rglob("*.json")}


@pytest.fixture
def directory(tmp_path) -> Path:
    """A folder with episodes of a scene."""
    (tmp_path / "episodes.jsonl").write_text(lines(CHOSEN))
    return tmp_path


@pytest.fixture
def predictions(directory) -> Path:
    """The answers of `static`, as the workflow's predictions have them."""
    file = directory / "static.jsonl"
    file.write_text(lines(Prediction.of(episode.id, "static", 0, PLACE) for episode in CHOSEN))
    return file


def test_a_scene_is_run_alike_with_the_offer_without_it_and_by_an_agent_that_ignores_it(directory, predictions):
    decided, offered = (rollouts_of(directory, "taking", file) for file in (None, predictions))
    assert len(offered[1]) == len(CHOSEN) and b'"trace"' in decided[0]
    for agent, file in (("taking", predictions), ("offered_alone", predictions), ("ignoring", predictions), ("ignoring", None)):
        assert rollouts_of(directory, agent, file)[0] == decided[0]


def test_an_arm_that_takes_the_offer_opens_no_tour_and_nothing_that_was_made_of_it(directory, predictions):
    arm, settings = job("dynamem_current_embodied")
    output = directory / "runs.jsonl"
    rollouts.run(
        arm, settings, directory / "episodes.jsonl", [0], output, Cache(directory / "cache"), {}, None, predictions, NOWHERE
    )
    assert {run.episode: run.outcome for run in Rollout.read(output)} == {one.id: "stopped" for one in CHOSEN}
    visit = load_visit(NOWHERE, 90.0, FLOOR)
    assert visit.reachable is FLOOR
    for first_use in (lambda: visit.content, lambda: len(visit.observations)):
        with pytest.raises(TourError, match="no such directory"):
            first_use()


def test_a_run_is_keyed_by_the_offered_answer(directory, predictions):
    before = rollouts_of(directory, "taking", predictions)[1]
    *others, last = predictions.read_text().splitlines(keepends=True)
    changed = json.loads(last) | {"x": 0.2}
    predictions.write_text("".join(others) + json.dumps(changed) + "\n")
    after = rollouts_of(directory, "taking", predictions)[1]
    assert before < after and len(after) == len(before) + 1


@pytest.fixture
def started(monkeypatch) -> list[str]:
    """The scenes on which this process started simulators."""
    scenes: list[str] = []
    start = controller.start
    monkeypatch.setattr(controller, "start", lambda *how: scenes.append(how[1]) or start(*how))
    return scenes


def test_rows_are_seed_by_seed_whatever_the_workers_and_finished_runs_start_no_simulator(tmp_path, started):
    arm, settings = job("oracle_check")
    episodes = [episode for scene in ("FloorPlan318", "FloorPlan7") for episode in of_scene(scene)[:1]]
    (tmp_path / "episodes.jsonl").write_text(lines(episodes))

    def run(name: str, workers: int) -> bytes:
        output, cache = tmp_path / f"{name}.jsonl", Cache(tmp_path / name)
        rollouts.run(arm, settings, tmp_path / "episodes.jsonl", [1, 0], output, cache, sightings_file=SIGHTINGS, workers=workers)
        return output.read_bytes()

    alone = run("alone", 1)
    assert started == ["FloorPlan318", "FloorPlan7"]
    rows = [(row.seed, row.episode) for row in Rollout.read(tmp_path / "alone.jsonl")]
    assert rows == [(seed, episode.id) for seed in (1, 0) for episode in episodes]
    assert run("alone", 1) == run("shared", 2) == alone and len(started) == 2


def test_an_agent_that_ends_its_process_is_named_in_the_log(tmp_path, capfd):
    arm, settings = job("oracle_check")
    arm = arm.model_copy(update={"agent": f"{__name__}:deadly"})
    episodes = [of_scene(scene)[0] for scene in ("FloorPlan318", "FloorPlan7")]
    (tmp_path / "episodes.jsonl").write_text(lines(episodes))
    with pytest.raises(WorkerDied, match=r"^oracle_check: a worker process was killed; the log's last lines name its work; "):
        rollouts.run(
            arm, settings, tmp_path / "episodes.jsonl", [0], tmp_path / "out.jsonl", Cache(tmp_path / "cache"), workers=2
        )
    assert f"{episodes[0].id} oracle_check: under seeds 0" in capfd.readouterr().out


def deadly(context: AgentContext) -> None:
    os._exit(9)

"""A released episode is brought about, toured, asked, run and judged from its record, with no other file at hand."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.predictions import predict
from ovman.evaluation.scores import score_rollout
from ovman.evaluation.tours import record_tour
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Rollout, Score
from ovman.records.task import Relation
from ovman.records.visit import Sighting, Sightings, VisitPair
from ovman.runner import Run, open_session, run_episode
from tests.arms import CONFIG
from tests.episodes import DATA, EPISODES, ROOT, SIGHTINGS
from tests.runs import job

SCENE = "FloorPlan318"
MEASURED_PX = CONFIG.measurement.min_mask_px
"""Smallest mask of the released sightings."""


@pytest.fixture
def alone(tmp_path, monkeypatch) -> Path:
    """An empty working directory with the file of episodes."""
    shutil.copy(EPISODES, tmp_path / "episodes.jsonl")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def runs(arm: str, episodes: list[Episode], sightings: dict[str, Sightings]) -> list[Rollout]:
    of_arm, settings = job(arm)
    with open_session(episodes[0], of_arm, settings) as session:
        return [run_episode(session, Run(one, of_arm, 0, settings, sightings=sightings.get(one.id))) for one in episodes]


def traced(runs):
    """The runs, each of which has a trace of all its actions."""
    for run in runs:
        assert len(run.trace.rstrip("SA")) == run.actions and run.trace.endswith("S") == (run.outcome == "stopped")
    return runs


def one_of_each_relation() -> list[Episode]:
    """The first episode of each relation in the scene."""
    episodes = [episode for episode in Episode.load(Path("episodes.jsonl")) if episode.scene == SCENE]
    return [next(episode for episode in episodes if episode.relation is relation) for relation in Relation]


def released(arm: str, episodes: list[Episode]) -> list[Score]:
    of = {run.episode: run for run in Score.read(DATA / "scores" / "main" / f"{arm}.jsonl") if run.seed == 0}
    return [of[episode.id] for episode in episodes]


def test_the_oracle_runs_an_episode_from_its_record_as_it_was_released(alone):
    episodes = one_of_each_relation()
    made = [score_rollout(run, episode) for run, episode in zip(runs("oracle_check", episodes, {}), episodes, strict=True)]
    assert traced(made) == released("oracle_check", episodes)
    assert [path.name for path in alone.iterdir()] == ["episodes.jsonl"]


def test_an_arm_that_is_given_positions_needs_the_sightings_and_nothing_else(alone):
    episodes = [episode for episode in one_of_each_relation() if episode.relation in (Relation.FORMER, Relation.MOVING)]
    with pytest.raises(ValueError, match=f"two_visits_oracle_positions is given positions: it needs the sightings of {SCENE}"):
        runs("two_visits_oracle_positions", episodes, {})
    shutil.copy(SIGHTINGS, alone / "sightings.jsonl")
    seen = {record.episode: record for record in Sightings.read(Path("sightings.jsonl"))}
    made = runs("two_visits_oracle_positions", episodes, seen)
    scored = [score_rollout(run, episode) for run, episode in zip(made, episodes, strict=True)]
    assert traced(scored) == released("two_visits_oracle_positions", episodes)


def test_the_page_on_agents_runs_an_episode(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    page = (ROOT / "docs" / "agents.md").read_text()
    code = re.search(r"```python\n(.*?)```", page[page.index("## One episode from Python") :], re.DOTALL)[1]
    exec(compile(code, "agents.md", "exec"), {})
    assert capsys.readouterr().out.splitlines()[-1] == "True"


def test_a_tour_that_is_recorded_from_an_episode_shows_what_was_released(alone):
    episodes = Episode.load(Path("episodes.jsonl"))
    episode = next(one for one in episodes if (one.scene, one.relation) == (SCENE, Relation.MOVING))
    with open_session(episode, *job("oracle_check")) as session:
        first, second = (record_tour(session, episode, which, alone, MEASURED_PX) for which in ("first", "second"))
    seen = Sightings(
        episode=episode.id,
        sightings=VisitPair[tuple[Sighting, ...]](
            first=first.sightings(episode.category), second=second.sightings(episode.category)
        ),
    )
    assert seen == next(record for record in Sightings.read(SIGHTINGS) if record.episode == episode.id)
    assert tuple(mover.start for mover in second.movers) == episode.movers
    for arm in ("positions_single_visit", "positions_two_visits"):
        of_arm, settings = job(arm)
        outcome, _ = predict(of_arm, episode, settings, ObservationStore(of_arm, settings, 90.0, alone), seen)
        (answered,) = [p for p in Prediction.read(DATA / "predictions" / "main" / f"{arm}.jsonl") if p.episode == episode.id]
        assert Prediction.of(episode.id, arm, 0, outcome) == answered

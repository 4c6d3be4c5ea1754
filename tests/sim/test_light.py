"""The light of a visit: the same in its tour and in the runs that start in its world, and gone with the visit."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from ovman.agents.interface import Action
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.records.tour import Light
from ovman.sim import visit
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import World
from tests.episodes import of_scene
from tests.runs import run_agent

SCENE = "FloorPlan16"
DIM, TINTED = Light(brightness=0.6, hue=0.1, saturation=0.3), Light(brightness=0.6, hue=0.7, saturation=0.3)


class FirstGlance:
    """Keeps the first picture that it sees, and stops."""

    def familiarise(self, visit):
        pass

    revisit = ask = familiarise

    def act(self, observation):
        self.rgb = observation.rgb.copy()
        return Action.STOP


@pytest.fixture(scope="module")
def episode() -> Episode:
    return next(one for one in of_scene(SCENE) if one.relation is not Relation.MOVING)


@pytest.fixture(scope="module")
def session(episode):
    with Session(SCENE, episode.settings) as session:
        yield session


def toured(session: Session, episode: Episode, directory: Path, light: Light | None) -> np.ndarray:
    """What the second visit's tour shows at the spawn."""
    alterations, spawn = episode.alterations("second"), episode.spawn
    world = World(session, alterations, episode.protocol.mover, np.random.default_rng(0))
    views = [AgentPose(spawn.x, spawn.z, spawn.yaw_deg)]
    visit.record(session, world, "second", alterations, views, 50, directory, "", light)
    return cv2.imread(str(directory / "00_rgb.png"))[..., ::-1]


def run(session: Session, episode: Episode, light: Light | None) -> np.ndarray:
    """What a run shows at the spawn."""
    agent = FirstGlance()
    run_agent(session, episode, agent, light=light)
    return agent.rgb


def test_a_run_meets_the_light_of_its_tour_and_the_next_visit_its_own(session, episode, tmp_path):
    other = DIM.model_copy(update={"materials": 7})
    lights = {"plain": None, "dim": DIM, "tinted": TINTED, "other materials": other, "dim again": DIM, "plain again": None}
    in_tour = {name: toured(session, episode, tmp_path / name, light) for name, light in lights.items()}
    in_run = {name: run(session, episode, light) for name, light in lights.items()}
    for name in lights:
        assert np.array_equal(in_tour[name], in_run[name]), name
    assert np.array_equal(in_tour["plain"], in_tour["plain again"])
    assert np.array_equal(in_tour["dim"], in_tour["dim again"])
    assert len({picture.tobytes() for picture in in_tour.values()}) == 4

"""The home in which a chair was moved, and a pilot that remembers where agents send it."""

from __future__ import annotations

import pytest

from ovman.agents.interface import Action
from tests.agents import moved_chair


@pytest.fixture(scope="session")
def home(tmp_path_factory):
    return moved_chair.home(tmp_path_factory)


class Wheels:
    """A pilot that is nowhere."""

    def __init__(self):
        self.goals = []

    def set_out(self, reachable, relation):
        self.told = reachable, relation

    def act(self, observation, goal):
        self.goals.append(goal)
        return Action.STOP


@pytest.fixture
def wheels():
    return Wheels()

"""An engine that is killed under a session: noticed at once, another one started, the work done as if nothing had happened."""

from __future__ import annotations

import signal
import threading
import time

import pytest

from ovman.sim.session import DEATHS, Session, SimulatorDied
from tests.arms import CONFIG

SCENE = "FloorPlan429"
NOTICED_S = 5.0


@pytest.fixture
def session():
    with Session(SCENE, CONFIG) as made:
        made.reset()
        yield made


def engine(session):
    return session._controller.server.unity_proc


def kill(session):
    engine(session).kill()


def test_death_between_two_actions_is_noticed_and_nothing_is_left(session):
    process = engine(session)
    kill(session)
    begun = time.monotonic()
    with pytest.raises(SimulatorDied, match="Pass"):
        for _ in range(3):
            session.step("Pass")
    assert time.monotonic() - begun < NOTICED_S
    assert process.poll() is not None and session._controller is None
    session.reset()
    assert session.step("Pass")


def test_death_during_an_action(session):
    """The engine is stopped first, so that it dies with an answer outstanding."""
    process = engine(session)
    process.send_signal(signal.SIGSTOP)
    threading.Timer(0.3, process.kill).start()
    with pytest.raises(SimulatorDied):
        session.step("Pass", image=True)


def test_a_mistake_is_no_death(session):
    with pytest.raises(ValueError, match="Invalid action"):
        session.step("NoSuchAction")
    assert session.step("Pass")
    with pytest.raises(ValueError, match="not contained in build"), Session("FloorPlan999", CONFIG) as other:
        other.reset()


def test_one_death_after_the_other_is_no_accident(session):
    tries = []

    def work():
        session.reset()
        tries.append(1)
        kill(session)
        session.step("Pass")

    with pytest.raises(SimulatorDied):
        session.with_restarts(work)
    assert len(tries) == DEATHS

"""A function that an arm names, and what is said where it or its agent fails: one line with the key, the place and the remedy."""

from __future__ import annotations

import sys

import pytest

from ovman.agents.interface import Action, Agent
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.predictions import predict
from ovman.evaluation.supervision import AgentError, SupervisedAgent, load_agent
from ovman.settings import Arm, Kind
from ovman.settings.arms import ArmJob
from tests.arms import BY_NAME
from tests.episodes import released
from tests.runs import job

MODULE = """
def whole(query, context):
    return context.rng.random()

def broken(query, context):
    return 1 / 0

number = 3
"""
EPISODE = released()[0]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """A module and a package outside of the project."""
    (tmp_path / "elsewhere_a").mkdir()
    (tmp_path / "elsewhere_a" / "__init__.py").write_text("")
    (tmp_path / "elsewhere_a" / "deep.py").write_text(MODULE)
    (tmp_path / "elsewhere_b.py").write_text("import not_there_at_all\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    load_agent.cache_clear()
    yield
    for name in [name for name in sys.modules if name.startswith("elsewhere_")]:
        del sys.modules[name]


def said(caught) -> str:
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("agent", "line"),
    [
        ("elsewhere_c.d:f", "importing elsewhere_c.d raised ModuleNotFoundError"),
        ("elsewhere_a.deep:part", "elsewhere_a.deep has no function part; name one that it has"),
        ("elsewhere_a.deep:number", "elsewhere_a.deep has no function number"),
        ("elsewhere_b:f", "importing elsewhere_b raised ModuleNotFoundError in elsewhere_b.py, line 1: No module named"),
    ],
)
def test_what_is_not_there_is_one_line(agent, line):
    with pytest.raises(AgentError) as caught:
        load_agent("mine", agent)
    assert line in said(caught)


def static(function_name: str, **fields) -> Arm:
    return ArmJob(name="mine", kind=Kind.STATIC, agent=f"elsewhere_a.deep:{function_name}", **fields)


def predicted(arm: Arm, tmp_path):
    view = job("two_visits")[1]
    return predict(arm, EPISODE, view, ObservationStore(arm, view, 90.0, tmp_path))


def test_a_static_function_that_raises_or_answers_nonsense_is_one_line_with_the_episode(tmp_path):
    with pytest.raises(AgentError) as caught:
        predicted(static("broken"), tmp_path)
    line = f"{EPISODE.id}: it raised ZeroDivisionError in deep.py, line 6: division by zero; mend the agent"
    assert line in said(caught)
    with pytest.raises(AgentError, match=f"{EPISODE.id}: it returned 0.*return .Answer"):
        predicted(static("whole"), tmp_path)


@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("context.map('first')", r"arms.mine is given no maps; write needs: \[maps\] in its entry"),
        ("context.networks()", r"arms.mine is given no networks; write needs: \[networks\] in its entry"),
        ("context.world('first')", "arms.mine finds its positions itself; a diagnostic arm says positions: handed in its entry"),
        ("context.true_detections('first')", "arms.mine finds its positions itself; a diagnostic arm says positions: handed"),
        ("context.true_objects('first', ())", "arms.mine finds its grounding itself; a diagnostic arm says grounding: handed"),
        ("context.settings.maps.cluster_radius_m", "was not given 'maps.cluster_radius_m'"),
        ("context.noun('chair')", r"arms.mine is given no networks"),
    ],
)
def test_what_an_entry_does_not_ask_for_is_refused_with_what_to_write(body, line, tmp_path):
    (tmp_path / "elsewhere_d.py").write_text(f"def ask(query, context):\n    return {body}\n")
    with pytest.raises(AgentError, match=line):
        predicted(ArmJob(name="mine", kind=Kind.STATIC, agent="elsewhere_d:ask"), tmp_path)


class Wrong:
    """Raises in one of its methods, or acts in words."""

    def __init__(self, wrong: str) -> None:
        self.wrong = wrong

    def __getattr__(self, method: str):
        if method not in ("familiarise", "revisit", "ask", "act"):
            raise AttributeError(method)
        if method == self.wrong:
            return lambda given: {}["chair"]
        return lambda given: "MoveAhead" if self.wrong == "words" else Action.STOP


def driven(agent) -> Action:
    supervised = SupervisedAgent(agent, BY_NAME["oracle_check"], "FloorPlan1/moved/0000, seed 2")
    assert isinstance(supervised, Agent)
    for method in (supervised.familiarise, supervised.revisit, supervised.ask):
        method(None)
    return supervised.act(None)


@pytest.mark.parametrize("method", ["familiarise", "revisit", "ask", "act"])
def test_an_agent_that_raises_is_one_line_with_arm_episode_and_seed(method, capsys):
    with pytest.raises(AgentError) as caught:
        driven(Wrong(method))
    where = "arms.oracle_check.agent is 'ovman.agents.oracle:agent': FloorPlan1/moved/0000, seed 2"
    assert said(caught).startswith(f"{where}: {method} raised KeyError in test_factory.py, line ")
    assert "Traceback" in capsys.readouterr().err


def test_an_agent_acts_in_actions_and_has_all_methods():
    assert driven(Wrong("")) is Action.STOP
    with pytest.raises(AgentError, match="act returned 'MoveAhead'; return an ovman.agents.interface.Action"):
        driven(Wrong("words"))
    with pytest.raises(AgentError, match="object has no method familiarise"):
        driven(object())

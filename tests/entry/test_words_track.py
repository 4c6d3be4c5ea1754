"""Evaluations in the words track: no agent gets a category or a relation, wherever it runs, and the manifest says the track."""

from __future__ import annotations

import json
import sys
from dataclasses import fields, is_dataclass
from types import BuiltinFunctionType, FunctionType, MethodType

import numpy as np
import pytest

from ovman.entry.manifest import Manifest
from ovman.remote.connection import Connection
from ovman.settings.arms import Track
from ovman_client import Instruction, Server
from tests.entry.evaluations import SCENE, command
from tests.episodes import of_scene
from tests.runs import Quiet

SPY = """
from ovman.agents.interface import Action

GIVEN = []

class Spy:
    def __init__(self, context): GIVEN.append(context)
    def familiarise(self, visit): GIVEN.append(visit)
    revisit = ask = familiarise
    def act(self, observation):
        GIVEN.append(observation)
        return Action.STOP
"""


def texts(value, met=None):
    """All texts in a value, with the names of attributes and keys. Functions and arrays are not looked into."""
    met = set() if met is None else met
    if isinstance(value, str):
        return {value}
    if id(value) in met or isinstance(value, (FunctionType, MethodType, BuiltinFunctionType, np.ndarray, type)):
        return set()
    met.add(id(value))
    inner = []
    if isinstance(value, dict):
        inner = [*value, *value.values()]
    elif isinstance(value, (list, tuple, set, frozenset)):
        inner = value
    elif is_dataclass(value):
        inner = [text for field in fields(value) for text in (field.name, getattr(value, field.name))]
    elif hasattr(value, "__dict__"):
        inner = [*vars(value), *vars(value).values()]
    return {text for one in inner for text in texts(one, met)}


def check(given):
    """No key, attribute or value is a category, a relation, or a name that has one."""
    said = texts(given)
    assert not said & {"category", "relation"}
    for episode in of_scene(SCENE):
        names = {episode.category, str(episode.relation), episode.id, episode.target, episode.scene}
        assert not {text for text in said if text in names}


def evaluate(out, tours, *options):
    return command("eval", "--out", out, "--cache", tours, "--split", "main", "--scenes", SCENE, "--seeds", "0", *options)


def test_an_agent_in_the_process_gets_a_sentence_and_its_phrase(tmp_path, tours, monkeypatch, capsys):
    (tmp_path / "spy_in_words.py").write_text(SPY)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    options = ["--agent", "spy_in_words:Spy", "--in-process"]
    assert evaluate(tmp_path / "out", tours, *options, "--track", "words") == 0
    given = sys.modules["spy_in_words"].GIVEN
    check(given)
    assert {"sentence", "phrase", "pose"} <= texts(given)
    (manifest,) = Manifest.read(tmp_path / "out" / "manifest.json")
    assert manifest.track is Track.WORDS
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["track"] == "words"
    assert "words track" in (tmp_path / "out" / "summary.md").read_text()
    capsys.readouterr()
    assert evaluate(tmp_path / "out", tours, *options) == 1
    said = capsys.readouterr().err
    assert "track is words, not paper" in said and said.count("\n") == 1


def test_a_remote_agent_gets_a_sentence_and_its_phrase(tmp_path, tours, monkeypatch):
    said, asked, ask = [], [], Connection.ask

    def overheard(line, message, limit_s):
        said.append(message)
        return ask(line, message, limit_s)

    monkeypatch.setattr(Connection, "ask", overheard)

    class Agent(Quiet):
        def __init__(self, context):
            pass

        def ask(self, query):
            asked.append(query)

        def act(self, observation):
            return "Stop"

    with Server(Agent, "spy", port=0) as server:
        assert evaluate(tmp_path / "out", tours, "--server", server.url, "--name", "spy", "--track", "words") == 0
    check(said)
    assert {type(one) for one in asked} == {Instruction} and len(asked) == len(of_scene(SCENE))
    assert all(one.phrase in one.sentence for one in asked)


@pytest.mark.parametrize("options, part", [
    (["--agent", "mine:Mine", "--track", "speech"], "speech"),
    (["--arm", "two_visits_oracle_positions", "--track", "words"], "--arm"),
    (["--arm", "oracle_check", "--track", "words"], "--track: oracle_check is told what a sentence means"),
])  # fmt: skip
def test_a_track_that_cannot_be_is_one_line(tmp_path, tours, capsys, options, part):
    assert evaluate(tmp_path / "out", tours, *options) != 0
    said = capsys.readouterr().err
    assert part in said and said.strip().count("\n") == 0

"""Messages to an agent name no episode to an agent that has a table of all episodes."""

from __future__ import annotations

import json
from itertools import groupby

import pytest

from ovman.entry.evaluation import list_shuffled
from ovman.entry.manifest import read_manifest
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.remote.agent import begin_message
from ovman.remote.connection import Connection
from ovman.runner import AGENT_DRAWS, Run
from ovman_client.interface import Action
from ovman_client.server import Server
from tests.entry.evaluations import SCENE, SECOND_SCENE, command
from tests.episodes import of_scene, released
from tests.runs import Quiet, job

CHOSEN = [*of_scene(SCENE)[:2], *of_scene(SECOND_SCENE)[:2]]


class Drawing(Quiet):
    """A few actions that it draws."""

    looks = False

    def __init__(self, context):
        self.rng, self.left = context.rng, 6

    def act(self, observation):
        self.left -= 1
        ways = [Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT]
        return ways[self.rng.integers(3)] if self.left else Action.STOP


@pytest.fixture(scope="module")
def evaluate(tmp_path_factory, tours):
    """Evaluates with these options; returns the messages to the agent, and the folder."""
    episodes = tmp_path_factory.mktemp("episodes") / "some.jsonl"
    episodes.write_text("".join(one.to_line() for one in CHOSEN))

    def evaluate(*options, out=None):
        said, ask = [], Connection.ask
        out = out or tmp_path_factory.mktemp("evaluations") / "out"
        with pytest.MonkeyPatch.context() as patch, Server(Drawing, "drawing", port=0) as server:
            patch.setattr(Connection, "ask", lambda line, message, limit_s: said.append(message) or ask(line, message, limit_s))
            which = ["--server", server.url, "--name", "drawing", "--episodes", episodes, "--cache", tours]
            assert command("eval", *which, "--out", out, "--seeds", "0", *options) == 0
        return said, out, episodes

    return evaluate


def words(said):
    return [message["words"] for message in said if message["type"] == "begin"]


def contents(said):
    return [message["visit"]["content"] for message in said if message["type"] in ("familiarise", "revisit")]


def test_words_and_digests_are_in_no_table_and_the_nonce_is_kept(evaluate):
    arm, settings = job("two_visits_embodied")
    arm = arm.model_copy(update={"name": "drawing"})
    table = [{draws: Run(one, arm, 0, settings).words(draws) for draws in AGENT_DRAWS} for one in CHOSEN]
    plain, bare, _ = evaluate("--nonce", "")
    assert words(plain) == table and read_manifest(bare).nonce is None  # before: the agent's table is right
    said, out, episodes = evaluate()
    other, _, _ = evaluate()
    nonce = read_manifest(out).nonce
    assert nonce and len(nonce) == 32
    assert not [one for one in words(said) if one in table or one in words(other)]
    assert not {*contents(said)} & ({*contents(plain)} | {*contents(other)})
    assert len({*contents(said)}) == len({*contents(plain)})  # tours that look the same have equal digests still
    assert nonce not in json.dumps(said, default=lambda data: "")
    assert command("verify", out, "--episodes", episodes) == 0
    again, same, _ = evaluate("--nonce", nonce)
    assert words(again) == words(said) and contents(again) == contents(said)
    assert Score.read(same / "runs.jsonl") == Score.read(out / "runs.jsonl")


def test_an_evaluation_that_goes_on_keeps_its_nonce(evaluate):
    _, out, _ = evaluate()
    nonce = read_manifest(out).nonce
    said, _, _ = evaluate("--seeds", "1", out=out)
    assert read_manifest(out).nonce == nonce and len(words(said)) == len(CHOSEN)


def test_episodes_come_in_an_order_of_the_evaluation_over_all_scenes():
    episodes = released()
    orders = [[Episode.parse(line).id for part in list_shuffled(episodes, nonce) for line in part] for nonce in ("a", "b")]
    assert sorted(orders[0]) == sorted(orders[1]) == sorted(one.id for one in episodes)
    assert orders[0] != orders[1] != [one.id for one in episodes]
    scenes = [name.partition("/")[0] for name in orders[0]]
    assert max(len(list(group)) for _, group in groupby(scenes)) < 8


def test_draws_of_the_agent_differ_by_run_and_not_by_arm():
    (arm, settings), episode = job("two_visits_embodied"), CHOSEN[0]
    one = begin_message(Run(episode, arm, 0, settings, nonce="a"))
    assert one == begin_message(Run(episode, arm, 0, settings, nonce="a"))
    others = [Run(episode, arm, 1, settings, nonce="a"), Run(CHOSEN[1], arm, 0, settings, nonce="a")]
    others.append(Run(episode, arm, 0, settings, nonce="b"))
    assert all(begin_message(other)["words"] != one["words"] for other in others)

"""The example of a language model: a server that speaks the protocol answers well, badly or never, and `ovman eval` scores it."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from ovman.language import noun
from ovman.records.episode import Episode
from ovman.records.run import Score
from tests.entry.evaluations import command
from tests.episodes import DATA, ROOT

KEY, MODEL, TIMEOUT_S = "sk-secret", "stub", 1.0
PAST = ("former", "removed")
TOKENS = 4300
"""Per query, as the example says."""


def reply_with(call, content=None):
    """A chat completion with one call of a tool, or none."""
    calls = [] if call is None else [{"id": "call_1", "type": "function", "function": call}]
    message = {"role": "assistant", "content": content, "refusal": None, **({"tool_calls": calls} if calls else {})}
    choice = {"index": 0, "message": message, "logprobs": None, "finish_reason": "tool_calls" if calls else "stop"}
    usage = {"prompt_tokens": 1, "completion_tokens": 1, "total_tokens": 2}
    return {"id": "chatcmpl-1", "object": "chat.completion", "created": 1, "model": MODEL, "choices": [choice], "usage": usage}


def call_of(name, arguments):
    """A call of a tool as the protocol has it: the arguments are a text."""
    return {"name": name, "arguments": arguments if isinstance(arguments, str) else json.dumps(arguments)}


BAD = [
    (200, b"<html>gateway</html>"),
    (200, b'{"object": "chat.completion", "choices": []}'),
    (200, reply_with(None, "I would go to the chair.")),
    (200, reply_with(call_of("go_to", '{"visit": 1, '))),
    (200, reply_with(call_of("go_to", {"visit": 1, "object": 999}))),
    (200, reply_with(call_of("go_to_place", '{"x": NaN, "z": 0}'))),
    (200, reply_with(call_of("go_to", '{"visit": 1, "object": 1e999}'))),
    (200, reply_with(call_of("go_to_place", ["x", "z"]))),
    (200, reply_with(call_of("open_door", {}))),
    (429, {"error": {"message": "Rate limit reached", "type": "requests", "code": "rate_limit_exceeded"}}),
    None,
]
"""Answers that name no place; None is silence."""


def listed(body):
    """The objects of a request."""
    (message,) = body["messages"]
    return [json.loads(line) for line in message["content"].splitlines() if line.startswith("{")]


def asked(body):
    """The relation and the noun of a request."""
    return re.search(r"^relation: (\w+), noun: (.+)$", body["messages"][0]["content"], re.MULTILINE).groups()


def choose(body):
    """Pick in the right visit the object with the likeliest name and change; for STABLE, without a change."""
    relation, word = asked(body)

    def rate(one):
        change = max(one["gone"] or 0.0, one["moving"] or 0.0) if relation == "moving" else one["gone"] or 0.0
        return (one["names"].get(word, 0.0) + 0.02) * ((1 - change if relation == "stable" else change) + 0.02)

    best = max((one for one in listed(body) if one["visit"] == (1 if relation in PAST else 2)), key=rate)
    return reply_with(call_of("go_to", {"visit": best["visit"], "object": best["object"]}))


class Endpoint(ThreadingHTTPServer):
    """Chat completions on a free port. `answer`: from a request to (status, reply) or None; `bodies`: the requests."""

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.bodies, self.answer, self.closing = [], None, threading.Event()


class Handler(BaseHTTPRequestHandler):
    def do_POST(self):
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        assert self.path == "/v1/chat/completions" and self.headers["Authorization"] == f"Bearer {KEY}"
        assert self.headers["Content-Type"] == "application/json"
        self.server.bodies.append(body)
        answer = self.server.answer(body)
        if answer is None:
            self.server.closing.wait(20 * TIMEOUT_S)
            return
        status, reply = answer
        data = reply if isinstance(reply, bytes) else json.dumps(reply).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def endpoint():
    with Endpoint() as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.closing.set()
        server.shutdown()


@pytest.fixture(scope="module")
def agent(endpoint, tmp_path_factory):
    """`ovman serve` with the example: its address, and the file of its standard error."""
    log = tmp_path_factory.mktemp("agent") / "log"
    given = {"OPENAI_BASE_URL": f"http://127.0.0.1:{endpoint.server_port}/v1/", "OPENAI_MODEL": MODEL, "OPENAI_API_KEY": KEY}
    options = [
        "--agent",
        "language_model:LanguageModel",
        "--needs",
        "maps",
        "detections",
        "--path",
        ROOT / "examples",
        "--port",
        "0",
    ]
    with (
        log.open("wb") as output,
        subprocess.Popen(
            [sys.executable, "-m", "ovman.cli", "serve", *map(str, options)],
            cwd=ROOT,
            stderr=output,
            env={**os.environ, **given, "OPENAI_TIMEOUT": str(TIMEOUT_S)},
        ) as process,
    ):
        try:
            while not (address := re.search(r"listens on (ws://\S+)", log.read_text())):
                assert process.poll() is None, log.read_text()
            yield address[1], log
        finally:
            process.kill()


@pytest.fixture(scope="module")
def asked_episodes(tmp_path_factory):
    """The queries about the first world pair of everyday, and their file."""
    every = Episode.load(DATA / "episodes" / "everyday.jsonl")
    episodes = [one for one in every if one.pair == every[0].pair]
    path = tmp_path_factory.mktemp("pair") / "pair.jsonl"
    path.write_text("".join(one.to_line() for one in episodes))
    return episodes, path


def evaluate(agent, path, tours, out):
    """The judged runs. Both evaluations show the same tours under the same names, so they are detected in once."""
    options = ["--server", agent[0], "--name", "language_model", "--episodes", path, "--seeds", "0", "--nonce", ""]
    assert command("eval", "--out", out, "--cache", tours, *options) == 0
    return Score.read(out / "runs.jsonl")


def test_answers_of_no_use_are_asked_for_twice_and_end_in_an_abstention(agent, endpoint, asked_episodes, tours, tmp_path):
    """Comes first: an answer that names a place is kept for equal requests."""
    episodes, path = asked_episodes
    kinds = {(one.relation, one.noun): BAD[number % len(BAD)] for number, one in enumerate(episodes)}
    endpoint.answer = lambda body: kinds[asked(body)]
    runs = evaluate(agent, path, tours, tmp_path / "out")
    assert [run.outcome for run in runs] == ["abstained"] * len(episodes) and len(endpoint.bodies) == 2 * len(episodes)
    said = [line for line in agent[1].read_text().splitlines() if "abstains after two tries" in line]
    assert len(said) == len(episodes) and "Traceback" not in agent[1].read_text()
    assert all(f"{one.sentence}: abstains" in " ".join(said) for one in episodes)


def test_a_model_that_picks_sensibly_beats_a_random_pick(agent, endpoint, asked_episodes, tours, tmp_path):
    episodes, path = asked_episodes
    endpoint.bodies.clear()
    endpoint.answer = lambda body: (200, choose(body))
    runs = evaluate(agent, path, tours, tmp_path / "out")
    assert len(endpoint.bodies) == len(episodes)
    bodies = {asked(body): body for body in endpoint.bodies}
    near = []
    for one in episodes:
        objects = listed(bodies[one.relation, noun(one.category)])
        near.append(sum(math.dist((k["x"], k["z"]), one.answer) <= 1 for k in objects) / len(objects))
    success, random_pick = sum(run.success for run in runs) / len(runs), sum(near) / len(near)
    assert success >= 0.5 and success >= random_pick + 0.3
    assert sum(len(json.dumps(body)) for body in endpoint.bodies) / len(runs) / 4 < 2 * TOKENS
    body = endpoint.bodies[0]
    assert (body["temperature"], body["seed"], body["model"]) == (0, 0, MODEL)

"""`ovman eval` of agents in processes of their own: the same runs, nothing but observations and the query, and no harm done."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from ovman.agents.interface import Action
from ovman.cli import main
from ovman.entry.manifest import Manifest, Where
from ovman.models.relation import Relation
from ovman.models.run import Score
from ovman.models.settings import MAIN
from ovman.remote.line import Line
from ovman_client import Action as ClientAction
from ovman_client import Server
from tests.arms import CONFIG
from tests.entry.test_eval import ARM, SCENE, lines
from tests.episodes import DATA, ROOT, of_scene, released
from tests.remote.plain_agent import PlainServer


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def evaluated(out, cache, *options):
    return main(["eval", "--out", str(out), "--cache", str(cache), "--seeds", "0", *options])


@pytest.fixture(scope="module")
def beside(tmp_path_factory, cache):
    """The evaluation of an arm in the evaluator's process."""
    out = tmp_path_factory.mktemp("beside") / "out"
    assert evaluated(out, cache, "--arm", ARM, "--split", MAIN, "--scenes", SCENE) == 0
    return out


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Writes a module of a user's into the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return lambda name, text: (tmp_path / f"{name}.py").write_text(text)


def served(arm):
    """A process that serves an arm, and its port."""
    command = [sys.executable, "-m", "ovman.cli", "serve", "--arm", arm, "--port", "0"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    found = re.search(r"listens on ws://127.0.0.1:(\d+)", process.stderr.readline())
    return process, int(found[1])


def test_a_served_arm_makes_the_runs_that_it_makes_beside_the_evaluator(beside, tmp_path, cache):
    process, port = served(ARM)
    try:
        options = ["--arm", ARM, "--server", f"ws://127.0.0.1:{port}", "--split", MAIN, "--scenes", SCENE]
        assert evaluated(tmp_path / "out", cache, *options) == 0
    finally:
        process.kill()
        process.wait()
    for name in ("runs.jsonl", "summary.json"):
        assert (tmp_path / "out" / name).read_bytes() == (beside / name).read_bytes()
    assert Manifest.read(tmp_path / "out" / "manifest.json")[0].where is Where.SERVER
    assert Manifest.read(beside / "manifest.json")[0].where is Where.EVALUATOR


def test_the_reference_agent_makes_its_maps_of_what_comes_over_the_line(tmp_path, cache):
    """It runs in a process of its own, and its runs are those that the workflow made of stored detections."""
    arm = next(name for name, arm in CONFIG.arms.items() if arm.executes == CONFIG.comparisons.agent)
    assert evaluated(tmp_path / "out", cache, "--arm", arm, "--split", MAIN, "--scenes", SCENE) == 0
    runs = [run.model_copy(update={"trace": None}) for run in Score.read(tmp_path / "out" / "runs.jsonl")]
    wanted = Score.read(DATA / "runs" / arm / "seed0" / f"{SCENE}.jsonl")
    assert [(run.episode, run.outcome, run.success) for run in runs] == [
        (run.episode, run.outcome, run.success) for run in wanted
    ]
    assert Manifest.read(tmp_path / "out" / "manifest.json")[0].where is Where.PROCESS


def texts(value):
    """All texts of a message, keys among them."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from texts(key)
            yield from texts(inner)
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from texts(inner)


def test_nothing_goes_over_the_line_but_observations_and_the_query(tmp_path, cache, monkeypatch):
    """Each text is a word of the protocol, the category or a digest; no number is the answer. Of an episode of each relation."""
    chosen = [next(one for one in released() if one.relation is relation) for relation in Relation]
    (tmp_path / "six.jsonl").write_text("".join(one.to_line() for one in chosen))
    said, ask = [], Line.ask

    def overheard(line, message, limit_s):
        said.append(message)
        return ask(line, message, limit_s)

    monkeypatch.setattr(Line, "ask", overheard)
    actions = iter([ClientAction.MOVE_AHEAD, ClientAction.ROTATE_LEFT, ClientAction.STOP] * len(chosen))

    class Agent:
        def __init__(self, context):
            pass

        def familiarise(self, visit):
            pass

        revisit = ask = familiarise

        def act(self, observation):
            assert observation.rgb.dtype == "u1" and observation.depth.shape == observation.rgb.shape[:2]
            return next(actions)

    with Server(Agent, "three", port=0) as server:
        options = ["--server", f"ws://127.0.0.1:{server.port}", "--name", "three", "--episodes", str(tmp_path / "six.jsonl")]
        assert evaluated(tmp_path / "out", cache, *options) == 0
    protocol = (ROOT / "docs" / "protocol.md").read_text()
    words = set(re.findall(r"[A-Za-z0-9_|<./-]+", protocol))
    digests = re.compile(r"[0-9a-f]{64}")
    spoken = {text for message in said for text in texts(message)}
    assert {text for text in spoken if text not in words and not digests.fullmatch(text)} <= {one.category for one in chosen}
    runs = {}
    for message in said:
        if message["type"] == "begin":
            runs[len(runs)] = []
        if runs:
            runs[len(runs) - 1].append(message)
    assert len(runs) == len(chosen)
    for episode, messages in zip(chosen, runs.values(), strict=True):
        everything = json.dumps(messages, default=lambda data: "")
        hidden = [
            episode.id,
            episode.scene,
            episode.target,
            episode.visits.first,
            episode.visits.second,
            *(one.instance for one in episode.alterations("second")),
        ]
        assert not [name for name in hidden if name in everything]
        assert not {repr(value) for value in episode.answer} & set(re.findall(r"-?\d+\.\d+", everything))
        assert [message["type"] for message in messages] == ["begin", "familiarise", "revisit", "ask", "act", "act", "act"]


def test_an_agent_can_be_written_from_the_document_alone(tmp_path, cache):
    (tmp_path / "one.jsonl").write_text(of_scene(SCENE)[0].to_line())
    moves = iter(["RotateLeft", "MoveAhead", "Stop"])

    def answer(message):
        if message["type"] == "hello":
            return {"type": "welcome", "protocol": message["protocol"], "agent": "plain"}
        if message["type"] == "ask":
            return {"type": "done", "looks": False}
        return {"type": "action", "action": next(moves)} if message["type"] == "act" else {"type": "done"}

    with PlainServer(answer) as server:
        options = ["--server", f"ws://127.0.0.1:{server.port}", "--name", "plain", "--episodes", str(tmp_path / "one.jsonl")]
        assert evaluated(tmp_path / "out", cache, *options) == 0
    (run,) = Score.read(tmp_path / "out" / "runs.jsonl")
    assert (run.trace, run.outcome) == ("LFS", "stopped")
    tour = next(message["visit"] for message in server.messages if message["type"] == "familiarise")
    rgb, depth = (tour["observations"][0][name] for name in ("rgb", "depth"))
    assert len(rgb["data"]) == rgb["shape"][0] * rgb["shape"][1] * 3 and len(depth["data"]) * 3 == len(rgb["data"]) * 4
    assert all(message["observation"]["rgb"] is None for message in server.messages if message["type"] == "act")


SNOOP = """
import gc, os, sys
from pathlib import Path

def found():
    frame, seen = sys._getframe(), []
    while frame is not None:
        seen += [frame.f_code.co_filename, *map(str, frame.f_locals)]
        frame = frame.f_back
    kinds = {type(one).__name__ for one in gc.get_objects()}
    opened = [os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd") if os.path.exists(f"/proc/self/fd/{n}")]
    return {
        "frames": [name for name in seen if "evaluation.py" in name or "rollout" in name or name in ("episode", "attempt")],
        "objects": sorted(kinds & {"Episode", "Attempt", "Session", "Journal", "Release"}),
        "here": os.listdir("."),
        "files": [name for name in opened if name.endswith((".jsonl", ".png"))],
        "variables": [name for name in os.environ if "SECRET" in name],
        "arguments": [one for one in sys.argv[1:] if "episodes" in one or "main" in one],
    }

class Agent:
    looks = False
    def __init__(self, context): pass
    def familiarise(self, visit): pass
    def revisit(self, visit): pass
    def ask(self, query): pass
    def act(self, observation):
        raise LookupError({name: what for name, what in found().items() if what})
"""


def test_an_agent_that_looks_around_finds_no_truth(tmp_path, cache, module, monkeypatch, capsys):
    monkeypatch.setenv("MY_SECRET", "answer")
    module("snoop", SNOOP)
    assert evaluated(tmp_path / "out", cache, "--agent", "snoop:Agent", "--needs", "--split", MAIN, "--scenes", SCENE) == 1
    assert "act raised LookupError in snoop.py, line 28: {}; mend the agent" in capsys.readouterr().err


ILL = """
import os, time
from ovman.agents.interface import Action

class Agent:
    looks = False
    def __init__(self, context): pass
    def familiarise(self, visit): pass
    def revisit(self, visit): pass
    def ask(self, query): self.relation = query.relation
    def act(self, observation):
        if self.relation != "moved":
            return Action.STOP
        WHAT
"""
ILLS = {
    "dies": ("os._exit(3)", "act: the agent is gone"),
    "is killed": ("os.kill(os.getpid(), 9)", "act: the agent is gone"),
    "hangs": ("time.sleep(1000)", "act: no answer within 2 s"),
    "eats": ("self.eaten = [bytes(10**8) for _ in range(10**3)]", "act raised MemoryError"),
    "writes": ("open('large', 'wb').write(bytes(2 * 10**8))", "act raised OSError|act: the agent is gone"),
    "exits": ("raise SystemExit(0)", "act raised SystemExit"),
    "is no action": ("return 7", "act raised TypeError in server.py, line \\\\d+: act returned 7"),
}


@pytest.mark.parametrize(("what", "said"), ILLS.values(), ids=ILLS.keys())
def test_an_ill_agent_costs_its_own_episode(tmp_path, cache, module, capsys, what, said):
    text = (ROOT / "config.yaml").read_text()
    for key, value in {"act_s": "2.0", "memory_gb": "3.0", "file_gb": "0.1"}.items():
        text = re.sub(rf"^  {key}: \S+", f"  {key}: {value}", text, flags=re.MULTILINE)
    (tmp_path / "config.yaml").write_text(text)
    module("ill", ILL.replace("WHAT", what))
    options = ["--agent", "ill:Agent", "--needs", "--split", MAIN, "--scenes", SCENE, "--config", "config.yaml"]
    assert evaluated(tmp_path / "out", cache, *options, "--failures", "abstain") == 0
    by_relation = {run.episode.split("/")[1]: run for run in Score.read(tmp_path / "out" / "runs.jsonl")}
    assert (by_relation["moved"].outcome, by_relation["moved"].trace) == ("abstained", "A")
    assert by_relation["stable"].outcome == "stopped"
    (noted,) = map(json.loads, lines(tmp_path / "out" / "failures.jsonl"))
    assert re.search(said.replace("\\\\", "\\"), noted["error"]) and noted["episode"].startswith(f"{SCENE}/moved")
    assert "counted as an abstention" in capsys.readouterr().out


def test_a_server_that_is_killed_and_comes_back_loses_nothing(beside, tmp_path, cache):
    """Killed before its first answer to `act`; the one that is dialled again makes the run from its beginning."""
    process, port = served(ARM)
    killed, dialled = threading.Event(), Line.__init__

    def again(line, url, connect_s):
        if killed.is_set() and process.poll() is not None:
            other, at = served(ARM)
            others.append(other)
            url = f"ws://127.0.0.1:{at}"
        dialled(line, url, connect_s)

    others, asked = [], Line.ask

    def ask(line, message, limit_s):
        if message["type"] == "act" and not killed.is_set():
            killed.set()
            process.kill()
            process.wait()
        return asked(line, message, limit_s)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Line, "__init__", again)
        patch.setattr(Line, "ask", ask)
        try:
            options = ["--arm", ARM, "--server", f"ws://127.0.0.1:{port}", "--split", MAIN, "--scenes", SCENE]
            assert evaluated(tmp_path / "out", cache, *options) == 0
        finally:
            for one in others:
                one.kill()
                one.wait()
    assert killed.is_set() and len(others) == 1
    assert (tmp_path / "out" / "runs.jsonl").read_bytes() == (beside / "runs.jsonl").read_bytes()


def test_the_agents_process_ends_with_an_evaluator_that_is_killed(tmp_path, cache, module):
    module("sleeper", ILL.replace("WHAT", "open('/proc/self/fd/2', 'w').write(f'pid {os.getpid()}\\\\n'); time.sleep(100)"))
    command = [sys.executable, "-m", "ovman.cli", "eval", "--out", str(tmp_path / "out"), "--cache", str(cache), "--seeds", "0"]
    options = ["--agent", "sleeper:Agent", "--needs", "--split", MAIN, "--scenes", SCENE]
    log = tmp_path / "out" / "agent.log"
    with subprocess.Popen([*command, *options], cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        until = time.monotonic() + 60
        while not (log.exists() and "pid" in log.read_text()) and time.monotonic() < until:
            time.sleep(0.1)
        agent = int(re.search(r"pid (\d+)", log.read_text())[1])
        assert Path(f"/proc/{agent}").exists()
        os.kill(process.pid, signal.SIGKILL)
    until = time.monotonic() + 10
    while alive(agent) and time.monotonic() < until:
        time.sleep(0.05)
    assert not alive(agent)


def alive(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


def test_letters_and_words_of_actions_are_the_same_on_both_sides():
    assert {action.value for action in Action} == {action.value for action in ClientAction}

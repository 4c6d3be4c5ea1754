"""`ovman eval` of agents in processes of their own: the same runs, nothing but observations and the query, and no harm done."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ovman.entry.evaluation import list_shuffled
from ovman.entry.manifest import Manifest, Where
from ovman.leaderboard.standing import first_attempts
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.remote.connection import Connection
from ovman.settings import MAIN
from ovman_client import Action as ClientAction
from ovman_client import Server
from tests.arms import CONFIG
from tests.entry.evaluations import DEPTH, SCENE, SECOND_SCENE, command, lines, moving
from tests.episodes import DATA, ROOT, of_scene
from tests.isolation import LEVELS
from tests.runs import Quiet


def evaluated(out, tours, *options):
    return command("eval", "--out", out, "--cache", tours, "--seeds", "0", *options)


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Writes a module of a user's into the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return lambda name, text: (tmp_path / f"{name}.py").write_text(text)


def served(arm):
    """A process that serves an arm, and its address."""
    command = [sys.executable, "-m", "ovman.cli", "serve", "--arm", arm, "--port", "0"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    return process, re.search(r"listens on (ws://\S+)", process.stderr.readline())[1]


@pytest.mark.parametrize("level", LEVELS)
def test_the_reference_agent_makes_its_maps_of_what_comes_over_the_line(tmp_path, tours, level):
    """Its run in another process is the one that the workflow made of stored detections."""
    arm = next(name for name, arm in CONFIG.arms.items() if arm.executes == CONFIG.comparisons.agent)
    episode = of_scene(SCENE)[0]
    (tmp_path / "one.jsonl").write_text(episode.to_line())
    options = ["--arm", arm, "--episodes", tmp_path / "one.jsonl", "--isolation", level]
    assert evaluated(tmp_path / "out", tours, *options) == 0
    (run,) = Score.read(tmp_path / "out" / "runs.jsonl")
    released = Score.read(DATA / "scores" / MAIN / f"{arm}.jsonl")
    (wanted,) = (run for run in released if run.seed == 0 and run.episode == episode.id)
    assert (run.outcome, run.success) == (wanted.outcome, wanted.success)
    assert Manifest.read(tmp_path / "out" / "manifest.json")[0].where is Where.PROCESS


def texts(value):
    """All texts of a message, keys among them."""
    if isinstance(value, dict):
        value = [*value, *value.values()]
    if isinstance(value, (list, tuple)):
        return {text for inner in value for text in texts(inner)}
    return {value} if isinstance(value, str) else set()


def test_nothing_goes_over_the_line_but_observations_and_the_query(tmp_path, tours, monkeypatch):
    """Each text is a word of the protocol, of the query or a digest; no number is the answer."""
    chosen = [moving(), *of_scene(SCENE), next(one for one in of_scene(SECOND_SCENE) if one.relation is Relation.REMOVED)]
    (tmp_path / "some.jsonl").write_text("".join(one.to_line() for one in chosen))
    said, ask = [], Connection.ask

    def overheard(line, message, limit_s):
        said.append(message)
        return ask(line, message, limit_s)

    monkeypatch.setattr(Connection, "ask", overheard)
    actions = iter([ClientAction.MOVE_AHEAD, ClientAction.ROTATE_LEFT, ClientAction.STOP] * len(chosen))

    class Agent(Quiet):
        def __init__(self, context):
            pass

        def act(self, observation):
            assert observation.rgb.dtype == "u1" and observation.depth.shape == observation.rgb.shape[:2]
            return next(actions)

    with Server(Agent, "three", port=0) as server:
        options = ["--server", server.url, "--name", "three", "--episodes", str(tmp_path / "some.jsonl"), "--nonce", "any"]
        assert evaluated(tmp_path / "out", tours, *options) == 0
    protocol = (ROOT / "docs" / "protocol.md").read_text()
    words = set(re.findall(r"[A-Za-z0-9_|<./-]+", protocol))
    digests = re.compile(r"[0-9a-f]{64}")
    spoken = texts(said)
    asked = {text for one in chosen for text in (one.category, one.noun, one.sentence)}
    assert {text for text in spoken if text not in words and not digests.fullmatch(text)} <= asked
    chosen = [Episode.parse(line) for part in list_shuffled(chosen, "any") for line in part]
    begins = [number for number, message in enumerate(said) if message["type"] == "begin"]
    runs = [said[begin:end] for begin, end in zip(begins, [*begins[1:], None], strict=True)]
    for episode, messages in zip(chosen, runs, strict=True):
        everything = json.dumps(messages, default=lambda data: "")
        changed = [one.instance for one in episode.alterations("second")]
        hidden = [episode.id, episode.scene, episode.target, episode.visits.first, episode.visits.second, *changed]
        assert not [name for name in hidden if name in everything]
        assert not {repr(value) for value in episode.answer} & set(re.findall(r"-?\d+\.\d+", everything))
        assert [message["type"] for message in messages] == ["begin", "familiarise", "revisit", "ask", "act", "act", "act"]


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
        "frames": [name for name in seen if "evaluation.py" in name or "runner.py" in name or name in ("episode", "env")],
        "objects": sorted(kinds & {"Episode", "Run", "Env", "Session", "Cache", "Release"}),
        "here": os.listdir("."),
        "files": [name for name in opened if name.endswith((".jsonl", ".png"))],
        "variables": [name for name in os.environ if "SECRET" in name],
        "arguments": [one for one in sys.argv[1:] if "episodes" in one or one == "main"],
    }

class Agent:
    looks = False
    def __init__(self, context): pass
    familiarise = revisit = ask = lambda self, given: None
    def act(self, observation):
        raise LookupError({name: what for name, what in found().items() if what})
"""


def test_an_agent_that_looks_around_finds_no_truth(tmp_path, tours, module, monkeypatch, capsys):
    monkeypatch.setenv("MY_SECRET", "answer")
    module("snoop", SNOOP)
    assert evaluated(tmp_path / "out", tours, "--agent", "snoop:Agent", "--needs", "--split", MAIN, "--scenes", SCENE) == 1
    assert "act raised LookupError in snoop.py, line 26: {}; mend the agent; " in capsys.readouterr().err


ILL = """
import os, time
from ovman.agents.interface import Action

class Agent:
    looks = False
    def __init__(self, context): pass
    familiarise = revisit = lambda self, visit: None
    def ask(self, query): self.asked = str(query.relation), query.category
    def act(self, observation):
        exec(ILLS.get(self.asked, ""))
        return Action.STOP
"""
ILLS = {
    "os._exit(3)": "act: the agent is gone",
    "time.sleep(1000)": "act: no answer within 2 s",
    "self.eaten = [bytes(10**8) for _ in range(10**3)]": "act raised MemoryError",
}


def test_an_ill_agent_costs_its_own_episode(tmp_path, tours, module, capsys):
    """After every illness another process is asked the next episode, and is well in the last."""
    second = {one.relation: one for one in of_scene(SECOND_SCENE)}
    chosen = [*of_scene(SCENE)[:2], second[Relation.MOVED], second[Relation.REMOVED]]
    episodes = [((str(one.relation), one.category), one) for one in chosen]
    ills = {asked: what for (asked, _), what in zip(episodes, ILLS, strict=False)}
    assert len(episodes) == len(ills) + 1
    module("ill", f"ILLS = {ills!r}\n{ILL}")
    (tmp_path / "some.jsonl").write_text("".join(one.to_line() for _, one in episodes))
    text = (ROOT / "config.yaml").read_text()
    for key, value in {"act_s": "2.0", "memory_gb": "3.0"}.items():
        text = re.sub(rf"^  {key}: \S+", f"  {key}: {value}", text, flags=re.MULTILINE)
    (tmp_path / "config.yaml").write_text(text)
    shutil.copytree(ROOT / "config", tmp_path / "config")
    options = ["--agent", "ill:Agent", "--needs", "--episodes", "some.jsonl", "--config", "config.yaml"]
    assert evaluated(tmp_path / "out", tours, *options, "--failures", "abstain") == 0
    runs = {run.episode: run for run in Score.read(tmp_path / "out" / "runs.jsonl")}
    noted = {one["episode"]: one["error"] for one in map(json.loads, lines(tmp_path / "out" / "failures.jsonl"))}
    assert noted.keys() == {one.id for asked, one in episodes if asked in ills}
    for asked, one in episodes:
        assert (runs[one.id].outcome, runs[one.id].trace) == (("abstained", "A") if asked in ills else ("stopped", "S"))
        assert ILLS.get(ills.get(asked, ""), "") in noted.get(one.id, "")
    assert capsys.readouterr().out.count("counted as an abstention") == len(ILLS)


@pytest.mark.parametrize("kind", ["ask", pytest.param("act", marks=pytest.mark.soak)])
def test_a_server_that_is_killed_and_comes_back(depth_first_seed, tmp_path, tours, kind, capsys):
    """Before it has seen its drive, the run begins again by itself. After that it has failed, and the next attempt is counted."""
    process, url = served(DEPTH)
    servers, dialled, asked = [process], Connection.__init__, Connection.ask

    def again(line, _, *others):
        if servers[-1].poll() is not None:
            servers.append(served(DEPTH))
            servers[-1], addresses[-1] = servers[-1]
        dialled(line, addresses[-1], *others)

    def ask(line, message, limit_s):
        if message["type"] == kind and len(servers) == 1:
            process.kill()
            process.wait()
        return asked(line, message, limit_s)

    addresses, out = [url], tmp_path / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Connection, "__init__", again)
        patch.setattr(Connection, "ask", ask)
        try:
            options = ["--arm", DEPTH, "--server", url, "--split", MAIN, "--scenes", SCENE, "--nonce", ""]
            statuses = [evaluated(out, tours, *options)]
            if statuses[0] != 0:
                assert capsys.readouterr().err.count("\n") == 1
                statuses.append(evaluated(out, tours, *options))
        finally:
            for one in servers:
                one.kill()
                one.wait()
    assert statuses == ([0] if kind == "ask" else [1, 0]) and len(servers) == 2
    assert (out / "runs.jsonl").read_bytes() == (depth_first_seed / "runs.jsonl").read_bytes()
    (manifest,) = Manifest.read(out / "manifest.json")
    assert manifest.where is Where.SERVER and Manifest.read(depth_first_seed / "manifest.json")[0].where is Where.EVALUATOR
    first = Score.read(out / "runs.jsonl")[0].episode
    assert [(one.episode, one.seed, one.attempts) for one in manifest.repeated] == ([] if kind == "ask" else [(first, 0, 2)])


PEEKS = """
import os
from pathlib import Path
from ovman.agents.interface import Action

NOTES, EVALUATOR = (Path(__file__).with_name(name) for name in ("notes", "evaluator"))

class Agent:
    def __init__(self, context): pass
    familiarise = revisit = lambda self, visit: None
    def ask(self, query): self.left = 3
    def act(self, observation):
        self.left -= 1
        if self.left == 0 and not NOTES.exists():
            child = os.fork()
            if child == 0:
                __import__("time").sleep(100)
            NOTES.write_text(f"{os.getpid()} {child}")
            os.kill(int(EVALUATOR.read_text()), 9)
        return Action.STOP if NOTES.exists() else Action.ROTATE_LEFT
"""


def test_no_attempt_after_the_first_is_free(tmp_path, tours, module):
    """An agent looks round, keeps notes and kills the evaluator; it ends with it, and so does what it started."""
    module("peeks", PEEKS)
    (tmp_path / "one.jsonl").write_text(of_scene(SCENE)[0].to_line())
    out = tmp_path / "out"
    options = ["--agent", "peeks:Agent", "--needs", "--episodes", "one.jsonl", "--isolation", "none"]
    run = [sys.executable, "-m", "ovman.cli", "eval", "--out", str(out), "--cache", str(tours), "--seeds", "0", *options]
    with subprocess.Popen(run, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        (tmp_path / "evaluator").write_text(str(process.pid))
        _, said = process.communicate()
    assert process.returncode == -signal.SIGKILL and not (out / "runs.jsonl").exists(), said
    agents, until = [int(one) for one in (tmp_path / "notes").read_text().split()], time.monotonic() + 10
    while any(map(alive, agents)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, agents))
    assert evaluated(out, tours, *options) == 0
    ((manifest,), (run,)) = Manifest.read(out / "manifest.json"), Score.read(out / "runs.jsonl")
    assert run.trace == "S" and [one.attempts for one in manifest.repeated] == [2]
    assert json.loads((out / "summary.json").read_text())["repeated"][0]["attempts"] == 2
    assert "TAKEN AGAIN" in (out / "summary.md").read_text()
    (first,) = first_attempts([run.model_copy(update={"success": True, "spl": 1.0})], manifest)
    assert (first.success, first.spl) == (False, 0.0)


def alive(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False

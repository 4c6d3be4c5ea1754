"""An isolated agent reaches no answer, no other process and no network, and what it can do without isolation is refused."""

from __future__ import annotations

import inspect
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from ovman.entry.manifest import Manifest
from ovman.records.run import Score
from ovman.remote.agent import AgentEndpoint, AgentProcess
from ovman.remote.isolation import Isolation, choose_isolation, find_packages
from ovman.settings.benchmark import Remote
from tests.arms import CONFIG
from tests.entry.evaluations import SCENE, command
from tests.episodes import DATA, ROOT, of_scene
from tests.isolation import LEVELS
from tests.remote import attacks
from tests.remote.test_process import mentioning

MEMORY_GB = 1.0
LIMITS = Remote(connect_s=60.0, tour_s=60.0, act_s=60.0, memory_gb=MEMORY_GB)
ATTACKS = [name for name, attack in vars(attacks).items() if inspect.isfunction(attack) and name not in ("called", "main")]
PRIVILEGED = {
    *("makes_a_device", "makes_a_user_namespace", "opens_a_ring"),
    *("traces_a_process", "takes_a_descriptor_of_a_process", "reads_through_a_hard_link"),
}
"""Attacks that a hardened kernel, or the lack of privilege, refuses anyway."""


@pytest.fixture
def facts(tmp_path, monkeypatch):
    """A victim, listeners, a cache and a working directory with an earlier evaluation; what attacks plant is removed."""
    names = ("here", "here/earlier", "cache/tours", "place", "out")
    for name in names:
        (tmp_path / name).mkdir(parents=True)
    secret, mark = tmp_path / "out" / "secret", f"ovman-attack-{os.getpid()}"
    for path in (secret, tmp_path / "here/earlier/runs.jsonl", tmp_path / "cache/tours/ids.png", tmp_path / "out/journal"):
        path.write_text("answer")
    temporary = Path("/tmp", f"{mark}-temporary")
    temporary.write_text("answer")
    (tmp_path / "place").chmod(0o700)
    monkeypatch.chdir(tmp_path / "here")
    pth = Path(sysconfig.get_path("purelib"), f"{mark}.pth")
    with ExitStack() as stack:
        tcp = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        udp = stack.enter_context(socket.socket(type=socket.SOCK_DGRAM))
        udp.bind(("127.0.0.1", 0))
        sockets = {"unix": str(temporary) + "-u", "datagrams": str(temporary) + "-d", "abstract": f"\0{mark}"}
        for name, kind in (("unix", socket.SOCK_STREAM), ("abstract", socket.SOCK_STREAM), ("datagrams", socket.SOCK_DGRAM)):
            listener = stack.enter_context(socket.socket(socket.AF_UNIX, kind))
            listener.bind(sockets[name])
            if kind == socket.SOCK_STREAM:
                listener.listen()
        victim = subprocess.Popen(["sleep", "300"], env={"SECRET": "answer"}, stdin=stack.enter_context(secret.open()))
        yield {
            "data": str(DATA),
            "cache": str(tmp_path / "cache"),
            "here": str(tmp_path / "here"),
            "checkout": str(ROOT),
            "secret": str(secret),
            "place": str(tmp_path / "place"),
            "journal": str(tmp_path / "out/journal"),
            "temporary": temporary.name,
            "planted": mark,
            "pth": pth.name,
            "packages": str(pth.parent),
            "victim": victim.pid,
            "tcp": tcp.getsockname()[1],
            "udp": udp.getsockname()[1],
            "key": os.getpid(),
            **sockets,
            "abstract": mark,
            "memory": int(MEMORY_GB * 1e9),
            "tmp": Path("/tmp").stat().st_ino,
        }
        victim.kill()
        victim.wait()
    for path in (
        temporary,
        sockets["unix"],
        sockets["datagrams"],
        f"/tmp/{mark}",
        f"/dev/shm/{mark}",
        pth,
        ROOT / "ovman" / pth.name,
    ):
        Path(path).unlink(missing_ok=True)
    for process in mentioning(mark):
        os.kill(process, signal.SIGKILL)
    if shutil.which("ipcrm"):
        subprocess.run(["ipcrm", "-M", str(os.getpid())], capture_output=True)


def attack(level, name, facts, log):
    """Return the last line that an attack says at a level of isolation."""
    script, hidden = Path(attacks.__file__), (Path(facts["cache"], "tours"), Path(facts["secret"]).parent, DATA)
    program = (str(script), name, json.dumps(facts))
    process = AgentProcess(AgentEndpoint(LIMITS, None, program, log, level, readable=(script,), hidden=hidden))
    process.end()
    return log.read_text().strip().splitlines()[-1]


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_succeeds_without_isolation_and_is_refused_with_it(name, level, facts, tmp_path):
    """The isolated attack comes first, so that it finds nothing that the control has changed."""
    isolated = attack(level, name, facts, tmp_path / "isolated.log")
    control = attack(Isolation.NONE, name, facts, tmp_path / "control.log")
    if name in PRIVILEGED and control.startswith("REFUSED"):
        pytest.skip(f"refused here without isolation, too: {control}")
    assert control.startswith("GOT ")
    assert isolated.startswith("REFUSED ")


LOOK = """
import os, sys
places = [f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd")]
print([os.readlink(place) for place in places if os.path.lexists(place)], flush=True)
os.write(int(sys.argv[-1]), b"x")
sys.stdin.read()
"""


@pytest.mark.parametrize("level", [Isolation.NONE, *LEVELS])
def test_an_agent_has_no_descriptor_but_its_own(level, facts, tmp_path):
    """Not even of a file that the evaluator lets its children have."""
    with Path(facts["secret"]).open() as opened:
        os.set_inheritable(opened.fileno(), True)
        script = tmp_path / "here" / "look.py"
        script.write_text(LOOK)
        AgentProcess(AgentEndpoint(LIMITS, None, (str(script),), tmp_path / "log", level, readable=(script,))).end()
    said = (tmp_path / "log").read_text()
    assert "pipe" in said and "secret" not in said and said.count("socket") == 1


@pytest.mark.parametrize("level", LEVELS)
def test_nothing_is_left_when_the_evaluator_is_killed(level, facts, tmp_path):
    evaluator = (
        "import os, sys; from pathlib import Path; from tests.remote.test_isolation import *;"
        "facts = json.loads(sys.argv[2]); script = Path(attacks.__file__);"
        "program = (str(script), 'makes_a_user_namespace', sys.argv[2]);"
        "AgentProcess(AgentEndpoint(LIMITS, None, program, Path(sys.argv[3]), Isolation(sys.argv[1]), readable=(script,)));"
        "os.kill(os.getpid(), 9)"
    )
    told = [sys.executable, "-c", evaluator, level, json.dumps(facts), str(tmp_path / "log")]
    killed = subprocess.run(told, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert killed.returncode == -signal.SIGKILL and (tmp_path / "log").read_text().startswith("REFUSED")
    until = time.monotonic() + 10
    while mentioning(facts["planted"]) and time.monotonic() < until:
        time.sleep(0.05)
    assert not mentioning(facts["planted"])


SIMPLE = """
import helper
from pathlib import Path
from ovman.agents.interface import Action

class Agent:
    looks = False
    def __init__(self, context): self.rng = context.rng
    familiarise = revisit = ask = lambda self, given: None
    def act(self, observation):
        {act}
        return Action.STOP
"""


@pytest.fixture
def evaluated(tmp_path, tours, monkeypatch):
    """Evaluates an agent that does something, in a folder of its own, on one episode."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "one.jsonl").write_text(of_scene(SCENE)[0].to_line())
    (tmp_path / "helper.py").touch()

    def evaluate(act, level, *options):
        (tmp_path / "simple.py").write_text(SIMPLE.format(act=act))
        asked = ["--agent", "simple:Agent", "--needs", "--episodes", "one.jsonl", "--seeds", "0", "--cache", tours]
        return command("eval", *asked, "--out", tmp_path / f"out-{level}", "--isolation", level, *options)

    return evaluate


@pytest.mark.parametrize("level", LEVELS)
def test_an_evaluation_hides_its_episodes_and_itself(level, evaluated, tmp_path, capsys):
    """Its file of episodes lies next to the agent, whose other modules it finds."""
    for name in ("one.jsonl", f"out-{level}/manifest.json"):
        act = f"Path({str(tmp_path / name)!r}).read_text(); 1 / 0"
        assert evaluated(act, level) == 1
        assert "raised PermissionError" in (said := capsys.readouterr().err) or "raised FileNotFoundError" in said
        assert f"isolated by {level}" in said
    assert evaluated(act.replace(level, "none"), Isolation.NONE) == 1
    assert "raised ZeroDivisionError" in capsys.readouterr().err


@pytest.mark.parametrize("level", LEVELS)
def test_the_level_is_where_a_score_is_read(level, evaluated, tmp_path, capsys):
    (tmp_path / "weights").write_text("7")
    act = "assert Path(__file__).with_name('weights').read_text() == '7'"
    assert evaluated(act, level, "--readable", "weights") == 0
    assert f"isolated by {level}" in capsys.readouterr().out
    out = tmp_path / f"out-{level}"
    assert Manifest.read(out / "manifest.json")[0].isolation is level
    assert json.loads((out / "summary.json").read_text())["isolation"] == level
    assert Score.read(out / "runs.jsonl")[0].trace == "S"
    assert command("verify", out, "--episodes", tmp_path / "one.jsonl") == 0
    assert f"isolated by {level}" in capsys.readouterr().out
    out.rename(tmp_path / "out-none")
    assert evaluated(act, Isolation.NONE) == 1
    assert f"isolation is {level}, not none" in capsys.readouterr().err


def test_the_evaluator_imports_nothing_of_the_agents_folder(evaluated, tmp_path):
    assert evaluated("pass", Isolation.NONE) == 0
    assert str(tmp_path) not in sys.path
    assert evaluated("pass", "auto", "--in-process") == 0
    assert str(tmp_path) in sys.path


@pytest.mark.parametrize("path", ["one.jsonl", ".", "nowhere", str(DATA / "episodes")])
def test_what_has_answers_cannot_be_made_readable(path, evaluated, capsys):
    assert evaluated("pass", "auto", "--readable", path) == 1
    assert capsys.readouterr().err.startswith("ovman eval: --readable: ")


TRY = """
import os, sys

def reads(name):
    try:
        return bool(open(f"{sys.argv[1]}/{name}").read())
    except OSError:
        return False

print([reads(name) for name in ("data/main.jsonl", "leaderboard/entry", "models/net")], flush=True)
os.write(int(sys.argv[-1]), b"x")
sys.stdin.read()
"""


@pytest.mark.parametrize("level", LEVELS)
def test_the_answers_of_a_wheel_are_hidden_but_not_its_networks(level, tmp_path, monkeypatch):
    """They lie inside the installed package, whose other files an agent needs."""
    shipped = tmp_path / "installed" / "ovman" / "shipped"
    for name in ("data/main.jsonl", "leaderboard/entry", "models/net"):
        (shipped / name).parent.mkdir(parents=True)
        (shipped / name).write_text("x")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    script = tmp_path / "here" / "look.py"
    script.write_text(TRY)
    said = []
    for where in (Isolation.NONE, level):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "path", [*sys.path, str(tmp_path / "installed")])
            endpoint = AgentEndpoint(LIMITS, None, (str(script), str(shipped)), tmp_path / where, where, readable=(script,))
            AgentProcess(endpoint).end()
        said.append((tmp_path / where).read_text().strip())
    assert said == ["[True, True, True]", "[False, False, True]"]


def test_seeds_stay_with_the_evaluator(tmp_path, monkeypatch):
    """Whoever has the seed of a private draw can draw it again."""
    from ovman.remote.isolation import write_settings
    from ovman.settings.config import load

    text = (ROOT / "config.yaml").read_text().replace("  seed: 0  ", "  seed: 987654321  ", 1)
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "config.yaml").write_text(text)
    shutil.copytree(ROOT / "config", tmp_path / "own" / "config")
    assert load(tmp_path / "own" / "config.yaml").benchmark.seed == 987654321
    write_settings(tmp_path / "own" / "config.yaml", tmp_path / "config.yaml")
    assert "987654321" not in (tmp_path / "config.yaml").read_text()
    assert load(tmp_path / "config.yaml").remote == CONFIG.remote


def test_a_package_is_readable_and_a_module_alone_without_its_folder(tmp_path, monkeypatch):
    (tmp_path / "package").mkdir()
    for name in ("package/__init__.py", "alone.py"):
        (tmp_path / name).touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert [*find_packages(["package.inner", "alone", "sys", "absent"])] == [tmp_path / "package", tmp_path / "alone.py"]


def test_the_strongest_level_is_chosen_and_an_absent_one_refused(monkeypatch):
    monkeypatch.setattr("ovman.remote.isolation.unavailable", lambda level: "no" if level is Isolation.BUBBLEWRAP else None)
    assert choose_isolation("auto") is Isolation.LANDLOCK
    with pytest.raises(ValueError, match="^--isolation bubblewrap: no$"):
        choose_isolation("bubblewrap")
    monkeypatch.setattr("ovman.remote.isolation.unavailable", lambda level: None if level is Isolation.NONE else "no")
    assert choose_isolation("auto") is Isolation.NONE

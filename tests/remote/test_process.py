"""An agent's process has folders and variables of its own, ends with what it started, and says why it did not start."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from ovman.evaluation.supervision import AgentError
from ovman.remote.agent import AgentEndpoint, AgentProcess
from ovman.remote.connection import ConnectionLost
from ovman.settings.benchmark import Remote

SERVER = """
import os, sys, tempfile, time
from pathlib import Path
ILL
if os.fork():
    places = os.environ["HOME"], tempfile.gettempdir(), os.getcwd()
    told = [*places, *sum(map(os.listdir, places), []), *(name for name in os.environ if "SECRET" in name)]
    Path(sys.argv[1], "told").write_text(chr(10).join(told))
    os.write(int(sys.argv[-1]), b"ready\\n")
time.sleep(100)
"""


@pytest.fixture
def start(tmp_path):
    """Starts a server that does something before it listens."""

    def start(ill="", connect_s=20.0):
        (tmp_path / "server.py").write_text(SERVER.replace("ILL", ill))
        limits = Remote(connect_s=connect_s, tour_s=1.0, act_s=1.0, memory_gb=1.0)
        return AgentProcess(AgentEndpoint(limits, None, (str(tmp_path / "server.py"), str(tmp_path)), tmp_path / "log"))

    return start


def mentioning(path):
    """The living processes whose command line names a file."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if str(path) in (entry / "cmdline").read_text() and " Z " not in (entry / "stat").read_text():
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def test_it_has_empty_folders_and_no_secret_and_nothing_is_left_of_it(start, tmp_path, monkeypatch):
    monkeypatch.setenv("MY_SECRET", "answer")
    process = start()
    home, temporary, work = map(Path, (tmp_path / "told").read_text().splitlines())
    assert process.address.startswith(b"\0") and len(mentioning(tmp_path / "server.py")) == 2
    (work / "link").symlink_to(tmp_path)
    process.end()
    until = time.monotonic() + 5
    while mentioning(tmp_path / "server.py") and time.monotonic() < until:
        time.sleep(0.05)
    assert not mentioning(tmp_path / "server.py") and not home.parent.exists() and temporary.parent == work.parent == home.parent
    assert (tmp_path / "told").exists()


def test_why_it_did_not_start_is_one_line(start, tmp_path):
    with pytest.raises(ConnectionLost, match="^the agent's process ended before it listened: ValueError: no weights$"):
        start("raise ValueError('no weights')")
    with pytest.raises(AgentError, match="^the agent did not listen within 0.5 s; raise remote.connect_s$"):
        start("time.sleep(100)", connect_s=0.5)
    assert not mentioning(tmp_path / "server.py")

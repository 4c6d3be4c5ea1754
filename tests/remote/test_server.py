"""The agent's server lets in who has its token and is no web page, and tells where in its own code an agent went wrong."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from ovman.entry.entrant import add_arm
from ovman.evaluation.supervision import AgentError
from ovman.remote.connection import Connection
from ovman.remote.host import host_arm
from ovman.sim.embodiment import Embodiment
from ovman_client import Server
from ovman_client.messages import MAX_MESSAGE
from tests.arms import CONFIG
from tests.remote.test_host import begin
from tests.runs import Quiet

SEEN = {
    "rgb": None,
    "depth": None,
    "pose": dict.fromkeys(("x", "y", "z", "yaw_deg", "horizon_deg"), 0.0),
    "field_of_view_deg": 90.0,
    "last_action_succeeded": True,
    "reachable": None,
}


class Agent(Quiet):
    looks = False

    def __init__(self, context):
        pass

    def act(self, observation):
        return "Stop"


@pytest.fixture
def server():
    with Server(Agent, "mine", port=0) as server:
        yield server


def test_who_has_no_token_is_turned_away_in_one_line(server):
    Connection(server.url, 5.0).close()
    for address in (f"ws://127.0.0.1:{server.port}", f"{server.url}x", server.url.replace("token", "taken")):
        with pytest.raises(AgentError, match="its server asks for a token; write the whole address that it printed") as caught:
            Connection(address, 5.0)
        assert "token=" not in str(caught.value)


def test_a_web_page_is_turned_away_though_it_has_the_token(server):
    with pytest.raises(InvalidStatus, match="403"):
        connect(server.url, origin="https://example.org")


def test_a_message_that_is_too_large_is_refused_on_both_sides(server):
    with connect(server.url, compression=None, max_size=None) as raw:
        with pytest.raises(ConnectionClosed) as caught:
            raw.send(bytes(MAX_MESSAGE + 1))
            raw.recv()
        assert caught.value.rcvd.code == 1009
    with Connection(server.url, 5.0) as line, pytest.raises(AgentError, match=f"the protocol has {MAX_MESSAGE} at most"):
        line.ask({"type": "familiarise", "visit": bytes(MAX_MESSAGE)}, 5.0)


@pytest.mark.parametrize("command", [["ovman.cli", "serve", "--arm", "cow"], ["ovman_client", "tests.remote.test_server:Agent"]])
def test_a_port_that_is_none_is_one_line(command):
    done = subprocess.run([sys.executable, "-m", *command, "--port", "99999"], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "--port 99999: " in done.stderr


AGENT = """
class Agent:
    looks = False
    def __init__(self, context): self.pilot = context.pilot
    def familiarise(self, visit): self.at = visit.reachable
    def revisit(self, visit): pass
    def ask(self, query): self.pilot.set_out(self.at, query.relation)
    def ACT
"""
ERRORS = {
    "blind": ("act(self, seen): return seen.rgb.mean()", r"AttributeError in agent.py, line 8: .*looks is False, so rgb"),
    "three": ("act(self, seen): return 3", "act returned 3; return an Action of ovman.agents.interface or of ovman_client"),
    "nan": ("act(self, seen): return self.pilot.act(seen, (float('nan'), 0.0))", "ValueError in agent.py, line 8: .*NaN"),
    "method": ("react(self, seen): return 3", "agent:Agent has no method act; write it"),
}


@pytest.mark.parametrize("error", ERRORS)
def test_what_an_agent_does_wrong_is_told_at_its_own_line(tmp_path, monkeypatch, error):
    act, wanted = ERRORS[error]
    (tmp_path / error).mkdir()
    (tmp_path / error / "agent.py").write_text(AGENT.replace("ACT", act))
    monkeypatch.syspath_prepend(tmp_path)
    settings, arm = add_arm(CONFIG, f"{error}.agent:Agent", "mine", None)
    visit = {"observations": [], "reachable": np.array([[0.0, 0.0], [0.25, 0.0]]), "content": None}
    with (
        pytest.raises(AgentError, match=wanted) as caught,
        Server(host_arm(settings, arm), "mine", port=0, decoded=False) as server,
        Connection(server.url, 5.0) as line,
    ):
        line.ask({"type": "begin", **begin(Embodiment.of(CONFIG))}, 5.0)
        line.ask({"type": "familiarise", "visit": visit}, 5.0)
        line.ask({"type": "ask", "query": {"category": "Chair", "relation": "moved"}}, 5.0)
        line.ask({"type": "act", "observation": SEEN}, 5.0)
    assert "\n" not in str(caught.value)

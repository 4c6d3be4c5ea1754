"""Agents that hang, lie, flood, die and babble: each costs its run one line, and no evaluator waits, grows or ends."""

from __future__ import annotations

import random
import resource
import struct
import threading
import time
from contextlib import contextmanager

import msgpack
import numpy as np
import pytest
from websockets.sync.server import serve

from ovman.agents.interface import CameraPose, Observation
from ovman.evaluation.supervision import AgentError
from ovman.remote.agent import RemoteAgent, TourMessages
from ovman.remote.connection import MAX_REPLY, Connection, ConnectionLost
from ovman.settings.benchmark import Remote
from ovman_client import MessageError
from ovman_client.messages import PROTOCOL, packed, unpacked

LIMITS = Remote(connect_s=5.0, tour_s=0.5, act_s=0.5, memory_gb=1.0)
SEEN = Observation(np.zeros((8, 8, 3), np.uint8), np.zeros((8, 8), np.float32), CameraPose(0, 1, 0, 0, 0), 90.0)
WELCOME = {"type": "welcome", "protocol": PROTOCOL, "agent": "mine"}


class Begun(RemoteAgent):
    """An agent at the end of a line, without a run."""

    def __init__(self, line):
        self._connection, self._limits, self._tours = line, LIMITS, TourMessages()


@contextmanager
def line_to(answer, connect_s=5.0):
    """A line to a server that says welcome, and then whatever answer(connection, message) sends."""

    def converse(connection):
        connection.send(packed({**WELCOME, "number": unpacked(connection.recv())["number"]}))
        for data in connection:
            answer(connection, unpacked(data))

    with serve(converse, "127.0.0.1", 0, compression=None, max_size=None, ping_interval=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            with Connection(f"ws://127.0.0.1:{server.socket.getsockname()[1]}", connect_s) as line:
                yield line
        finally:
            server.shutdown()


def replies(make):
    return lambda connection, message: connection.send(make(message))


def reply(**parts):
    return replies(lambda message: packed({"number": message["number"], **parts}))


HOSTILE = {
    "says nothing": (lambda connection, message: None, "no answer within 0.5 s"),
    "dies": (lambda connection, message: connection.socket.close(), "the agent is gone"),
    "sends text": (lambda connection, message: connection.send("Stop"), "this one is text"),
    "nests": (replies(lambda message: b"\x91" * 60_000), "no MessagePack"),
    "claims a large array": (replies(lambda message: b"\xdd\xff\xff\xff\xff"), "no MessagePack"),
    "sends a list": (replies(lambda message: msgpack.packb([1, 2])), 'a message is a map with a text "type"'),
    "sends too much": (replies(lambda message: bytes(MAX_REPLY + 1)), f"an answer of more than {MAX_REPLY} bytes"),
    "is out of turn": (reply(type="action", action="Stop", number=99), "the agent answered message 99"),
    "says another thing": (reply(type="done"), "the reply done is not an action"),
    "jumps": (reply(type="action", action="Jump"), "the reply Jump is not an action; answer one of MoveAhead"),
}


@pytest.mark.parametrize(("answer", "said"), HOSTILE.values(), ids=HOSTILE.keys())
def test_what_breaks_the_protocol_is_one_line_within_its_time_and_is_hung_up_on(answer, said):
    with line_to(answer) as line:
        began = time.monotonic()
        with pytest.raises(ConnectionLost) as caught:
            Begun(line).act(SEEN)
        assert time.monotonic() - began < 5
        text = str(caught.value)
        assert text.startswith("act: ") and said in text and "\n" not in text and len(text) < 400
        with pytest.raises(ConnectionLost):
            Begun(line).act(SEEN)


def test_a_run_that_takes_too_long_ends_though_each_action_is_in_time():
    with line_to(reply(type="action", action="MoveAhead")) as line:
        agent = Begun(line)
        agent._limits = LIMITS.model_copy(update={"run_s": 0.2})
        agent.act(SEEN)
        time.sleep(0.3)
        with pytest.raises(ConnectionLost, match="a run of more than 0.2 s"):
            agent.act(SEEN)


def test_an_error_of_the_agents_is_told_in_one_line_and_the_line_stays():
    with line_to(reply(type="error", message="KeyError in mine.py, line 3:\n" + "x" * 1000)) as line:
        for _ in range(2):
            with pytest.raises(AgentError, match=r"^act raised KeyError in mine.py, line 3: x+; mend the agent$") as caught:
                Begun(line).act(SEEN)
            assert not isinstance(caught.value, ConnectionLost) and len(str(caught.value)) < 400


def test_a_frame_that_claims_a_gigabyte_is_refused_before_it_comes():
    def flood(connection, message):
        header = b"\x82\x7f" + struct.pack(">Q", 1 << 30)
        try:
            connection.socket.sendall(header)
            for _ in range(1 << 10):
                connection.socket.sendall(bytes(1 << 20))
        except OSError:
            pass

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with line_to(flood) as line, pytest.raises(ConnectionLost, match="an answer of more than"):
        Begun(line).act(SEEN)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kB


@pytest.mark.parametrize(
    ("welcome", "said"),
    [
        ({"type": "done"}, "hello was answered by done"),
        ({"type": "welcome", "protocol": PROTOCOL, "agent": 7}, "hello was answered by welcome"),
        ({"type": "error", "message": "this agent speaks ovman-agent/9"}, "this agent speaks ovman-agent/9"),
    ],
)
def test_who_is_no_agent_is_refused(welcome, said):
    def converse(connection):
        connection.send(packed({**welcome, "number": unpacked(connection.recv())["number"]}))
        connection.recv()

    with serve(converse, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with pytest.raises(AgentError, match=said):
            Connection(f"ws://127.0.0.1:{server.socket.getsockname()[1]}", 5.0)
        server.shutdown()


def test_fuzzed_messages_are_messages_or_refused():
    """A good answer with some bytes changed or cut."""
    rng, refused = random.Random(0), 0
    for _ in range(10_000):
        data = bytearray(packed({"type": "action", "number": 1, "action": "Stop", "more": [1, 2.5, None, "x", b"y"]}))
        for _ in range(rng.randrange(1, 6)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        try:
            message = unpacked(bytes(data[: rng.randrange(2 * len(data))]))
            assert isinstance(message, dict) and isinstance(message["type"], str)
        except MessageError as error:
            refused += 1
            assert "\n" not in str(error).split(": ")[0]
    assert 3_000 < refused < 10_000

"""Protocol: frames as the unmodified client reads them, the order of the handshake, and an engine that never outlives its
client."""

from __future__ import annotations

import json
import os
import shlex
import signal
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import msgpack
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ovman_engine import executable
from ovman_engine.client.wire import ClientGone, Field, Wire

DEADLINE_S = 20.0


def until(condition, seconds=DEADLINE_S):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


class Client:
    """The client's end of the pipes, a few lines of it."""

    def __init__(self, environment):
        self.environment = environment
        self.process = subprocess.Popen(
            shlex.split(executable()), env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        self.reader = self.writer = None

    def connect(self):
        self.reader = open(self.environment["AI2THOR_FIFO_SERVER_PIPE_PATH"], "rb")  # noqa: SIM115
        return self.receive()

    def receive(self):
        frames = []
        while True:
            kind, length = struct.unpack("!BI", self.reader.read(5))
            if kind == 255:
                assert length == 0
                return frames
            frames.append((kind, self.reader.read(length)))

    def send(self, body, kind=2):
        if self.writer is None:
            self.writer = open(self.environment["AI2THOR_FIFO_CLIENT_PIPE_PATH"], "wb")  # noqa: SIM115
        self.writer.write(struct.pack("!BI", kind, len(body)) + body + struct.pack("!BI", 255, 0))
        self.writer.flush()

    def ask(self, **request):
        self.send(json.dumps(request).encode())
        return self.receive()

    def close(self):
        for end in (self.reader, self.writer):
            if end is not None:
                end.close()
        try:
            self.process.wait(DEADLINE_S)
        finally:
            self.process.kill()
            self.process.wait()


@pytest.fixture
def client(engine_environment):
    made = Client(engine_environment)
    try:
        yield made
    finally:
        made.close()


def test_speaks_first_then_echoes_sequence_numbers_whatever_it_is_sent(client):
    (kind, body), *images = client.connect()
    first = msgpack.unpackb(body)
    assert kind == Field.METADATA and first["sequenceId"] == 0 and not images
    assert first["agents"][0]["lastActionSuccess"] is True

    (kind, body), *images = client.ask(action="MoveAhead", sequenceId=7)
    reply = msgpack.unpackb(body)
    assert reply["sequenceId"] == 7 and not images
    assert reply["agents"][0]["errorMessage"].startswith("No scene is loaded")

    for garbage in (b"", b"\xff\xfe", b"[1]", b"nonsense", b'{"action": "Pass", "sequenceId": ', b'{"action": ["Pass"]}', b"NaN"):
        client.send(garbage)
        (kind, body), *images = client.receive()
        assert not msgpack.unpackb(body)["agents"][0]["lastActionSuccess"] and not images

    client.send(b"not an action", kind=99)
    client.receive()
    ((_, body),) = client.ask(action="Reset", sceneName="FloorPlan999_physics", sequenceId=0)
    reset = msgpack.unpackb(body)["agents"][0]
    assert not reset["lastActionSuccess"] and "FloorPlan999_physics" in reset["errorMessage"]
    ((_, body),) = client.ask(action="MoveAhead", sequenceId=9)
    assert "FloorPlan999" in msgpack.unpackb(body)["agents"][0]["errorMessage"]
    ((_, body),) = client.ask(action="Reset", sceneName="FloorPlan401_physics", sequenceId=0)
    assert msgpack.unpackb(body)["agents"][0]["sceneName"] == "FloorPlan401_physics"


def test_ends_when_the_client_closes_its_pipe(client):
    client.connect()
    client.send(b"{}")
    client.receive()
    client.writer.close()
    client.reader.close()
    assert client.process.wait(DEADLINE_S) == 0


def test_ends_when_the_client_never_writes(client):
    client.connect()
    client.reader.close()
    assert client.process.wait(DEADLINE_S) == 0


def test_ends_in_the_middle_of_a_frame(client):
    client.connect()
    client.send(b"{}")
    client.receive()
    client.writer.write(struct.pack("!BI", 2, 1000) + b'{"action"')
    client.writer.close()
    client.reader.close()
    assert client.process.wait(DEADLINE_S) == 0


def test_refuses_to_run_without_pipes():
    environment = {k: v for k, v in os.environ.items() if not k.startswith("AI2THOR_FIFO")}
    run = subprocess.run([sys.executable, "-m", "ovman_engine"], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 2 and "local_executable_path" in run.stderr and run.stderr.count("\n") == 1


CLIENT_PROGRAM = """
import sys, time
from ai2thor.controller import Controller
from ovman_engine import executable
controller = Controller(local_executable_path=executable(), scene="FloorPlan401", renderImage=False)
print(controller.unity_pid, flush=True)
time.sleep(600)
"""


def test_no_orphan_when_the_client_is_killed(alive):
    client = subprocess.Popen([sys.executable, "-c", CLIENT_PROGRAM], stdout=subprocess.PIPE, text=True)
    pid = int(client.stdout.readline())
    assert alive(pid)
    client.send_signal(signal.SIGKILL)
    client.wait()
    client.stdout.close()
    assert until(lambda: not alive(pid))


def test_no_orphan_when_the_client_dies_before_it_opens_its_end(engine_environment, alive):
    program = f"import subprocess, time; print(subprocess.Popen({shlex.split(executable())!r}).pid, flush=True); time.sleep(600)"
    starter = subprocess.Popen([sys.executable, "-c", program], env=engine_environment, stdout=subprocess.PIPE, text=True)
    pid = int(starter.stdout.readline())
    assert until(lambda: b"ovman_engine" in Path(f"/proc/{pid}/cmdline").read_bytes())
    time.sleep(0.5)
    assert alive(pid)
    starter.kill()
    starter.wait()
    assert until(lambda: not alive(pid))
    starter.stdout.close()


def test_gives_up_on_a_client_that_it_never_saw(tmp_path, monkeypatch):
    monkeypatch.setattr("ovman_engine.client.wire.OPENING_LIMIT_S", 0.05)
    os.mkfifo(tmp_path / "server")
    with pytest.raises(ClientGone):
        Wire(str(tmp_path / "server"), str(tmp_path / "client"))
    with pytest.raises(ClientGone):
        Wire(str(tmp_path / "absent"), str(tmp_path / "client"))


bodies = st.lists(
    st.tuples(st.sampled_from([f for f in Field if f != Field.END_OF_MESSAGE]), st.binary(max_size=3000)), max_size=5
)


@settings(max_examples=25, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(messages=st.lists(bodies, min_size=1, max_size=3), large=st.integers(0, 3_000_000))
def test_every_message_arrives_whole(tmp_path_factory, messages, large):
    """This holds for messages longer than the pipe's buffer."""
    directory = tmp_path_factory.mktemp("pipes")
    server, client = str(directory / "server"), str(directory / "client")
    os.mkfifo(server)
    os.mkfifo(client)
    messages = [*messages, [(Field.RGB, bytes(large))]]
    received = []

    def read():
        with open(server, "rb") as pipe:
            for _ in messages:
                frames = []
                while (header := struct.unpack("!BI", pipe.read(5)))[0] != 255:
                    frames.append((header[0], pipe.read(header[1])))
                received.append(frames)

    reader = threading.Thread(target=read)
    reader.start()
    wire = Wire(server, client)
    for message in messages:
        wire.send(message)
    reader.join()
    assert received == messages
    with pytest.raises(ClientGone):
        wire.send([(Field.RGB, bytes(10))])
    wire.close()

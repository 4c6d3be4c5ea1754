"""Protocol: frames as the unmodified client reads them, the order of the handshake, and an engine that never outlives its
client.
"""

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
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ovman_engine import executable
from ovman_engine.client.resolution import MAX_SIDE_PX, objection
from ovman_engine.client.wire import ClientGone, Field, Wire

DEADLINE_S = 20.0
END = struct.pack("!BI", 255, 0)


def until(condition, seconds=DEADLINE_S):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


class Client:
    """The client's end of the pipes."""

    def __init__(self, environment, *options):
        self.process = subprocess.Popen(
            [*shlex.split(executable()), *options],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            # under nohup, the tests and so the engine would ignore the signal
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
        )
        self.reader = open(environment["AI2THOR_FIFO_SERVER_PIPE_PATH"], "rb", buffering=0)  # noqa: SIM115
        self.first = self.receive()
        self.writer = open(environment["AI2THOR_FIFO_CLIENT_PIPE_PATH"], "wb", buffering=0)  # noqa: SIM115

    def read(self, size):
        data = b""
        while len(data) < size:
            part = self.reader.read(size - len(data))
            assert part, "the engine has gone"
            data += part
        return data

    def receive(self):
        frames = []
        while True:
            kind, length = struct.unpack("!BI", self.read(5))
            if kind == 255:
                return frames
            frames.append((kind, self.read(length)))

    def send(self, **request):
        self.put(json.dumps(request).encode())

    def put(self, body, kind=2):
        self.writer.write(struct.pack("!BI", kind, len(body)) + body + END)

    def frames(self, **request):
        self.send(**request)
        return self.receive()

    def ask(self, **request):
        (_, body), *_ = self.frames(**request)
        answer = msgpack.unpackb(body)
        return answer["agents"][0] if "agents" in answer else answer

    def gone(self):
        """Exit status, once the engine has ended by itself."""
        return self.process.wait(DEADLINE_S)

    def close(self):
        self.reader.close()
        self.writer.close()
        self.process.kill()
        self.process.wait()


@pytest.fixture
def connect(engine_environment):
    clients = []

    def make(*options):
        clients.append(Client(engine_environment, *options))
        return clients[-1]

    yield make
    for made in clients:
        made.close()


@pytest.fixture(scope="module")
def talking(with_pipes, tmp_path_factory):
    """A client whose engine several tests talk to, in their order."""
    options = ("-screen-fullscreen", "0", "-screen-quality", "7", "-screen-width", "64", "-screen-height", "48")
    client = Client(with_pipes(tmp_path_factory.mktemp("pipes")), *options)
    client.loaded = Path(f"/proc/{client.process.pid}/maps").read_text()
    yield client
    client.close()


def test_first_message_waits_for_no_world(talking):
    """The client opens the server pipe without a time limit, so nothing slow is imported before."""
    assert "numpy" not in talking.loaded and "mujoco" not in talking.loaded
    talking.frames(action="Pass", sequenceId=0)
    assert "numpy" in Path(f"/proc/{talking.process.pid}/maps").read_text()


def test_answers_whatever_it_is_sent(talking):
    assert talking.ask(action="MoveAhead", sequenceId=7)["errorMessage"].startswith("No scene is loaded")
    for garbage in (b"", b"\xff\xfe", b"[1]", b"nonsense", b'{"action": "Pass", "sequenceId": ', b'{"action": ["Pass"]}', b"NaN"):
        talking.put(garbage)
        (kind, body), *images = talking.receive()
        assert kind == Field.METADATA and not msgpack.unpackb(body)["agents"][0]["lastActionSuccess"] and not images
    talking.put(b"not an action", kind=99)
    talking.receive()
    talking.put(b'{"action": ' + b"[" * 500_000)
    (_, answer), *_ = talking.receive()
    assert "nested too deeply" in msgpack.unpackb(answer)["agents"][0]["errorMessage"]
    reset = talking.ask(action="Reset", sceneName="FloorPlan999_physics", sequenceId=0)
    assert not reset["lastActionSuccess"] and "FloorPlan999_physics" in reset["errorMessage"]
    assert "FloorPlan999" in talking.ask(action="MoveAhead", sequenceId=9)["errorMessage"]
    assert talking.ask(action="Reset", sceneName="FloorPlan401_physics", sequenceId=0)["sceneName"] == "FloorPlan401_physics"
    long = talking.ask(action="Pass", sequenceId=2, blank="x" * (2 << 20))
    assert not long["lastActionSuccess"] and "'blank'" in long["errorMessage"]


def test_frames(talking):
    """The size comes from the command line; the first message is unprompted and has metadata only; metadata come first and once;
    bodies have the right length; alpha is 255; the sequence number is echoed.
    """
    client = talking
    ((kind, body),) = client.first
    first = msgpack.unpackb(body)
    assert kind == 1 and first["sequenceId"] == 0 and first["activeAgentId"] == 0 and len(first["agents"]) == 1
    assert (first["agents"][0]["screenWidth"], first["agents"][0]["screenHeight"]) == (64, 48)

    client.frames(action="Reset", sceneName="FloorPlan3_physics", sequenceId=0)
    flags = {
        "renderDepthImage": True,
        "renderInstanceSegmentation": True,
        "renderSemanticSegmentation": True,
        "renderNormalsImage": True,
    }
    frames = client.frames(action="Initialize", sequenceId=1, **flags)
    sizes = {4: (3, 4), 5: (4,), 6: (3, 4), 8: (3, 4), 9: (3, 4)}
    assert frames[0][0] == 1 and sorted(k for k, _ in frames[1:]) == sorted(sizes)
    for kind, image in frames[1:]:
        assert len(image) / (64 * 48) in sizes[kind], kind
        if kind in (8, 9) and len(image) == 4 * 64 * 48:
            assert (np.frombuffer(image, np.uint8).reshape(-1, 4)[:, 3] == 255).all()

    (kind, body), *_ = client.frames(action="RotateRight", sequenceId=1234567)
    assert kind == 1 and msgpack.unpackb(body)["sequenceId"] == 1234567
    for patched in client.frames(action="Pass", sequenceId=5), client.frames(action="Done", sequenceId=6):
        assert [k for k, _ in patched if k in (1, 11)] == [patched[0][0]]
        if patched[0][0] == 11:
            keys = {"agentId", "lastAction", "lastActionSuccess", "errorMessage", "errorCode", "actionReturn"}
            assert set(msgpack.unpackb(patched[0][1])) >= keys


def test_refuses_to_run_without_pipes():
    environment = {k: v for k, v in os.environ.items() if not k.startswith("AI2THOR_FIFO")}
    run = subprocess.run([sys.executable, "-m", "ovman_engine"], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 2 and "local_executable_path" in run.stderr and run.stderr.count("\n") == 1


def test_gives_up_on_a_client_that_it_never_saw(tmp_path, monkeypatch):
    monkeypatch.setattr("ovman_engine.client.wire.OPENING_LIMIT_S", 0.05)
    os.mkfifo(tmp_path / "server")
    with pytest.raises(ClientGone):
        Wire(str(tmp_path / "server"), str(tmp_path / "client"))
    with pytest.raises(ClientGone):
        Wire(str(tmp_path / "absent"), str(tmp_path / "client"))


@pytest.mark.parametrize(
    "garbage",
    [struct.pack("!BI", 2, 0xFFFFFFFF) + b"{}", b"GET / HTTP/1.1\r\n\r\n", b"\xff" * 4096, struct.pack("!BI", 2, 10) + b"{"],
    ids=["four gigabytes", "another protocol", "noise", "cut short"],
)
def test_garbage_on_the_pipe(connect, garbage):
    """Whatever the bytes, the engine ends at the end of the pipe at the latest."""
    client = connect()
    try:
        client.writer.write(garbage)
        client.writer.close()
    except BrokenPipeError:
        pass
    client.reader.close()
    assert client.gone() == 0


def test_client_that_dies_while_it_reads_an_image(connect):
    client = connect()
    client.ask(action="Reset", sceneName="FloorPlan403_physics", sequenceId=0)
    client.ask(action="ChangeResolution", x=1600, y=1200, sequenceId=1, renderImage=False)
    client.send(action="Initialize", sequenceId=2, renderDepthImage=True)
    client.read(100_000)
    client.reader.close()
    assert client.gone() == 0


def test_pipes_that_another_process_holds_open(engine_environment, alive):
    """The client is killed while the engine writes an image, and a fork of the client keeps the pipes, so that no end of file
    comes.
    """
    program = f"import subprocess, time; print(subprocess.Popen({shlex.split(executable())!r}).pid, flush=True); time.sleep(600)"
    starter = subprocess.Popen([sys.executable, "-c", program], env=engine_environment, stdout=subprocess.PIPE, text=True)
    pid = int(starter.stdout.readline())
    with (
        open(engine_environment["AI2THOR_FIFO_SERVER_PIPE_PATH"], "rb", buffering=0) as reader,
        open(engine_environment["AI2THOR_FIFO_CLIENT_PIPE_PATH"], "wb", buffering=0) as writer,
    ):
        requests = (
            {"action": "Reset", "sceneName": "FloorPlan403_physics"},
            {"action": "ChangeResolution", "x": 1600, "y": 1200},
        )
        for number, request in enumerate(requests):
            body = json.dumps({**request, "sequenceId": number}).encode()
            writer.write(struct.pack("!BI", 2, len(body)) + body + END)
        time.sleep(1.0)
        assert alive(pid)
        starter.kill()
        starter.wait()
        end = time.monotonic() + DEADLINE_S
        while alive(pid) and time.monotonic() < end:
            time.sleep(0.05)
        assert not alive(pid)
        assert reader
    starter.stdout.close()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_ends_when_it_is_told_to(connect, number):
    client = connect()
    client.ask(action="Pass", sequenceId=0)
    client.process.send_signal(number)
    assert client.gone() in (0, -number)
    assert client.reader.read(1) == b""


def test_resolution_that_is_refused_is_not_taken(controller):
    before = controller.step("Pass").frame.shape
    for x, y in ((0, 0), (-1, 300), (300, -5), (10_000, 10_000), (MAX_SIDE_PX + 1, 1), (2**31, 1), (1e300, 1)):
        try:
            event = controller.step("ChangeResolution", x=x, y=y)
        except ValueError:
            event = controller.last_event
        assert not event and event.metadata["errorMessage"]
        assert controller.step("Pass").frame.shape == before


def test_objections():
    assert not objection(1, 1) and not objection(300, 300, 60) and not objection(3840, 2160, 2)
    assert objection(MAX_SIDE_PX + 1, 1) and objection(4097, 2048) and objection(4096, 2048, 5) and objection(0, 1)


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

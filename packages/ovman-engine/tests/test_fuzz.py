"""For any request, the answer decodes, the world stays consistent, and no action fails inside the engine."""

from __future__ import annotations

import io
import json
import math
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ovman_engine.actions import TABLE
from ovman_engine.actions.values import ObjectPose, PartialVector3, Vector3
from ovman_engine.client import log
from ovman_engine.engine import Engine
from ovman_engine.plan import floorplan

SCENES = ("FloorPlan403", "FloorPlan302", "FloorPlan28", "FloorPlan212")
TAKE_AWAY = {
    "Reset",
    "CreateHouse",
    "SetObjectFilter",
    "SetObjectPoses",
    "InitialRandomSpawn",
    "RemoveFromScene",
    "RemoveObjsFromScene",
}
"""Actions after which an object may be missing from the metadata."""
WAYS = [way for ways in TABLE.values() for way in ways]

wild = st.sampled_from(
    [
        *(None, True, False, 0, -1, 1, 1e-12, 0.05, 360, 1e6, -1e30, 1e308, 10**25, math.nan, math.inf, -math.inf),
        *("", "x", "1.5", "NaN", "true", "FloorPlan1_physics", "\ud800", "a" * 5000),
        *([], {}, [[]], {"x": "y"}, {"x": math.nan, "y": 0, "z": 0}, [1, "a", None], {"x": 1e30, "y": 1e30, "z": -1e30}),
    ]
)
rare = st.integers(0, 19)
numbers = st.sampled_from([0, 0.25, 0.5, 1, 2, 15, 30, 45, 60, 90, 180, 359.9, -30, -90, 0.01]) | st.floats(-10, 10)
places = st.fixed_dictionaries({a: st.floats(-4, 4) | st.integers(-8, 8).map(lambda i: i / 4) for a in "xyz"})
angles = st.fixed_dictionaries({a: st.sampled_from([0, 0, 0, 30, 90, 180, 275.5, -45]) for a in "xyz"})
partial = st.fixed_dictionaries({}, optional={a: st.floats(-3, 3) for a in "xyz"})
texts = {
    "objectType": st.sampled_from(["Mug", "Bed", "Floor", "Toilet", "Elephant"]),
    "sceneName": st.sampled_from([f"{s}_physics" for s in SCENES] + ["FloorPlan999_physics", "Procedural", ""]),
    "agentMode": st.sampled_from(["default", "default", "locobot", "arm", "DEFAULT"]),
    "visibilityScheme": st.sampled_from(["Collider", "Distance", "distance", "None"]),
    "skyboxColor": st.sampled_from(["white", "#102030", "no colour"]),
    "quality": st.sampled_from(["Very Low", "none"]),
}


def plausible(scene):
    """Strategies of values by the name of the argument, or by its kind."""
    things = floorplan.load(scene).objects
    ids, named = (st.sampled_from([*values, "Nothing"]) for values in ([o.object_id for o in things], [o.name for o in things]))
    poses = st.fixed_dictionaries({"objectName": named, "position": places, "rotation": angles})
    kinds = {
        float: numbers,
        int: st.integers(-2, 60),
        bool: st.booleans(),
        str: ids,
        Vector3: places | angles,
        PartialVector3: places | partial,
        list[float]: st.lists(numbers, max_size=3),
        list[str]: st.lists(ids | st.sampled_from(["Kitchen", "bedroom"]), max_size=4),
        list[bool]: st.lists(st.booleans(), max_size=2),
        list[Vector3]: st.lists(places, max_size=4),
        list[ObjectPose]: st.lists(poses, max_size=6),
    }
    return lambda parameter: (
        places if parameter.name == "position" else texts.get(parameter.name, kinds.get(parameter.kind, wild))
    )


@st.composite
def requests(draw, values):
    """A request by the signature of an action, mostly: with missing, wrong and unknown arguments; sometimes of no known
    action.
    """
    if draw(rare) == 0:
        return draw(st.dictionaries(st.sampled_from(["action", "x", "sequenceId", "objectId", "renderImage"]), wild, max_size=4))
    way = draw(st.sampled_from(WAYS))
    request = {"action": way.name}
    for parameter in way.parameters:
        if draw(st.integers(0, 3)) if not parameter.required else draw(rare) == 1:
            continue
        request[parameter.name] = draw(wild if draw(rare) == 2 else values(parameter))
    if draw(rare) == 3:
        request[draw(st.sampled_from(["zzz", "agentId", "renderImage", "renderNormalsImage", "renderClassImage"]))] = draw(wild)
    return request


def sequences(shortest, longest):
    """Scenes with sequences of fitting actions."""
    return st.sampled_from(SCENES).flatmap(
        lambda s: st.tuples(st.just(s), st.lists(requests(plausible(s)), min_size=shortest, max_size=longest))
    )


class Client:
    """The engine in this process; the client's own code decodes its messages."""

    def __init__(self, monkeypatch):
        from ai2thor.fifo_server import FifoServer

        self.engine = Engine(40, 30, draws=True)
        self.server = FifoServer(40, 30, timeout=None)
        self.server.server_pipe = "the buffer"
        monkeypatch.setattr(self.server, "_read_with_timeout", self._read)
        self.logged = []
        monkeypatch.setattr(log, "note", self.logged.append)
        self.event = None

    def _read(self, server_pipe, message_size, timeout):
        return self._buffer.read(message_size)

    def send(self, **request):
        frames = self.engine.answer(json.dumps(request).encode())
        parts = [struct.pack("!BI", field, memoryview(body).nbytes) + bytes(body) for field, body in frames]
        self._buffer = io.BytesIO(b"".join(parts) + struct.pack("!BI", 255, 0))
        self.server.sequence_id = request["sequenceId"]
        self.event = self.server.receive()
        assert not self._buffer.read()
        return self.event

    def start(self, scene):
        reset = self.send(action="Reset", sceneName=f"{scene}_physics", sequenceId=0)
        assert reset, reset.metadata["errorMessage"]
        flags = ("renderDepthImage", "renderInstanceSegmentation", "renderSemanticSegmentation", "renderNormalsImage")
        assert self.send(action="Initialize", sequenceId=1, **dict.fromkeys(flags, True))
        assert self.send(action="ChangeResolution", x=40, y=30, sequenceId=2)


@pytest.fixture(scope="module")
def client():
    with pytest.MonkeyPatch.context() as patch:
        yield Client(patch)


@pytest.fixture(scope="module")
def started(client):
    """The client on a scene, for what changes nothing."""
    client.start(SCENES[0])
    return client


def names(metadata):
    return {o["name"] for o in metadata["objects"]}


def check(client, request, before):
    event, metadata = client.event, client.event.metadata
    name = request.get("action") if isinstance(request.get("action"), str) else ""
    assert not client.logged, (request, client.logged)
    json.dumps(dict(metadata), allow_nan=False)
    silent = name in ("DisableObject", "EnableObject") or request.get("positions") == []
    assert event or metadata["errorMessage"] or silent, request
    shape = (metadata["screenHeight"], metadata["screenWidth"])
    for image in (event.frame, event.depth_frame, event.instance_segmentation_frame, event.semantic_segmentation_frame):
        if image is not None and 1 not in shape:  # the client converts depth
            assert image.shape[:2] == shape, (request, image.shape, shape)
    if event.frame is not None:
        assert len(event.third_party_camera_frames) == len(metadata["thirdPartyCameras"] or [])
    if event.depth_frame is not None:
        assert np.isfinite(event.depth_frame).all()
    assert len(names(metadata)) == len(metadata["objects"]) == len({o["objectId"] for o in metadata["objects"]}), request
    if name not in TAKE_AWAY:
        assert before <= names(metadata), (request, before - names(metadata))
    if name not in ("RotateLook", "Initialize", "Reset"):
        assert -90.001 <= metadata["agent"]["cameraHorizon"] <= 90.001 or not event
    assert 0 <= metadata["agent"]["rotation"]["y"] < 360


def run(client, scene, sequence):
    client.start(scene)
    for number, request in enumerate(sequence):
        client.send(action="ResetObjectFilter", renderImage=False, sequenceId=3)
        before = names(client.event.metadata)
        given_id = request.get("sequenceId", number)
        request = {**request, "sequenceId": given_id if isinstance(given_id, int) and abs(given_id) < 2**63 else number}
        client.send(**request)
        check(client, request, before)
    if client.send(action="Initialize", gridSize=0.25, renderImage=False, sequenceId=1):
        client.send(action="ChangeResolution", x=40, y=30, renderImage=False, sequenceId=1)
        event = client.send(action="GetReachablePositions", renderImage=False, sequenceId=1)
        position = event.metadata["agent"]["position"]
        assert event, event.metadata["errorMessage"]
        assert any(abs(p["x"] - position["x"]) + abs(p["z"] - position["z"]) < 1e-3 for p in event.metadata["actionReturn"])
        for record in event.metadata["objects"]:
            assert all(abs(record["position"][a]) < 1e4 for a in "xyz"), record["objectId"]
    assert not client.logged


bounded = {
    "derandomize": True,
    "deadline": None,
    "suppress_health_check": [HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large],
}


@settings(max_examples=8, **bounded)
@given(sequences(10, 20))
def test_random_actions(client, sequence):
    run(client, *sequence)


@pytest.mark.soak
@pytest.mark.timeout(3600)
@settings(max_examples=1500, **bounded)
@given(sequences(20, 60))
def test_random_actions_for_long(client, sequence):
    run(client, *sequence)


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 100_000,
        b'{"action":' + b'{"a":' * 50_000,
        b'{"action": "MoveAhead", "moveMagnitude": ' + b"[" * 900 + b"]" * 900 + b"}",
        b'{"action": "' + b"x" * (1 << 20) + b'"}',
        b'{"action": "\\ud800", "sequenceId": 1}',
        b'{"action": "Pass", "\\udfff": 1, "sequenceId": "\\ud800"}',
        b'{"action": "Pass", "sequenceId": ' + b"9" * 5000 + b"}",
        b'{"action": "Pass", "sequenceId": [[{}]]}',
        b'{"action": "MoveAhead", "moveMagnitude": NaN}',
        b'{"action": "Teleport", "position": {"x": Infinity, "y": 0, "z": -Infinity}}',
        b'{"action": "Pass"}\x00',
        b"\xff\xfe{\x00}\x00",
        b"",
        b"null",
    ],
    ids=lambda body: body[:40].decode("latin-1"),
)
def test_hostile_bytes(started, body):
    before = started.event.metadata["agent"]
    frames = started.engine.answer(body)
    assert frames[0][0] in (1, 11)
    assert not started.logged
    assert started.send(action="Pass", sequenceId=3).metadata["agent"] == before

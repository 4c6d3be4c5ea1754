"""The example for vla-evaluation-harness drives real runs: with a stub of its protocol, and with its package if that is there."""

from __future__ import annotations

import threading
from contextlib import contextmanager

import msgpack
import numpy as np
import pytest
from websockets.sync.server import serve

from ovman.entry.entrant import add_arm
from ovman.records.run import Score
from ovman.remote.host import host_arm
from ovman_client import Server
from tests.arms import CONFIG
from tests.entry.evaluations import SCENE, command
from tests.episodes import ROOT, of_scene

MOBILE = {"position": 3, "rotation": 3, "gripper": 1, "base_motion": 4, "control_mode": 1}
ARM_PLAN = [(0.5, 0, -1), (0, 0.4, -1), (0, -0.4, -1), (-0.1, 0, -1), (0, 0, 1)]
"""Forward, yaw and gripper of an arm's actions in turn: ahead, left, right, right because it cannot step back, stop."""
TRACE = "FLRRS"


def arm_action(step):
    """The action of an arm at a step, as a chunk of one."""
    forward, yaw, gripper = ARM_PLAN[min(step, len(ARM_PLAN) - 1)]
    return np.array([[forward, 0, 0, 0, 0, yaw, gripper]], np.float32)


def base_action(step):
    """The same as an action of a mobile base, whose arm takes over at the end."""
    forward, yaw, gripper = ARM_PLAN[min(step, len(ARM_PLAN) - 1)]
    return np.array([*[0] * 7, forward, 0, yaw, 0, gripper < 0], np.float32)


@contextmanager
def stub(specs, choose, params=None):
    """A model server made from the harness's protocol. Yields its address and the observations that it got."""
    seen = []

    def converse(connection):
        step = 0
        for data in connection:
            message = msgpack.unpackb(data)
            assert {*message} == {"type", "payload", "seq", "timestamp"}
            kind, payload = message["type"], message["payload"]
            reply = None
            if kind == "hello":
                spec = {name: {"name": name, "dims": dims, "format": "raw"} for name, dims in specs.items()}
                reply = (
                    "hello",
                    {"harness_version": "0", "protocol_version": 1, "action_spec": spec, "observation_params": params or {}},
                )
            elif kind == "episode_start":
                step = 0
            elif kind == "observation":
                seen.append(payload)
                action = choose(step)
                data = {"__ndarray__": True, "data": action.tobytes(), "dtype": action.dtype.str, "shape": list(action.shape)}
                reply, step = ("action", {"actions": data}), step + 1
            if reply is not None:
                answer = {"type": reply[0], "payload": reply[1], "seq": message["seq"], "timestamp": 0.0}
                connection.send(msgpack.packb(answer))

    with serve(converse, "127.0.0.1", 0, compression=None, max_size=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}", seen
        server.shutdown()


@contextmanager
def packaged(specs, choose, params=None):
    """A model server of the package `vla-eval`."""
    api, base, dims = (pytest.importorskip(f"vla_eval.{name}") for name in ("api", "model_servers.predict", "specs"))
    seen = []

    class Model(base.PredictModelServer):
        def predict(self, obs, ctx):
            seen.append(obs)
            return {"actions": choose(ctx.step)}

        def get_action_spec(self):
            return {name: dims.DimSpec(name, size, "raw") for name, size in specs.items()}

        def get_observation_spec(self):
            return {"image": dims.IMAGE_RGB, "language": dims.LANGUAGE}

        def get_observation_params(self):
            return params or {}

    with api.serve_background(Model(chunk_size=1)) as handle:
        yield handle.url, seen


@pytest.mark.parametrize("make", [stub, packaged])
@pytest.mark.parametrize(("specs", "choose", "params"), [({}, arm_action, {"send_tours": True}), (MOBILE, base_action, None)])
def test_a_model_server_of_the_harness_drives(make, specs, choose, params, tours, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    settings, name = add_arm(CONFIG, "vla_harness:VlaAgent", None, None)
    (tmp_path / "one.jsonl").write_text(of_scene(SCENE)[0].to_line())
    with make(specs, choose, params) as (address, seen), Server(host_arm(settings, name), name, port=0, decoded=False) as server:
        monkeypatch.setenv("VLA_SERVER", address)
        options = ["--server", server.url, "--name", "vla", "--episodes", tmp_path / "one.jsonl", "--seeds", "0"]
        assert command("eval", "--out", tmp_path / "out", "--cache", tours, *options) == 0
    (run,) = Score.read(tmp_path / "out" / "runs.jsonl")
    assert run.trace == TRACE and {one["task_description"] for one in seen} == {of_scene(SCENE)[0].sentence}
    assert ["tours" in one for one in seen] == [bool(params), *[False] * (len(TRACE) - 1)]

"""Let a model server of vla-evaluation-harness drive: OVMAN's agent asks it for an action at every step.

The harness (https://github.com/allenai/vla-evaluation-harness, `pip install vla-eval`) serves pretrained vision-language-action
models over WebSocket and MessagePack. This file speaks its protocol, version 1, and needs nothing of its package. It was tested
with `vla-eval` 0.8.0.

    vla-eval serve --config MODEL.yaml                                # or: python my_server.py, which calls run_server
    VLA_SERVER=ws://localhost:8000 ovman serve --agent vla_harness:VlaAgent --path examples
    ovman eval --server 'ws://127.0.0.1:8765/?token=...' --name vla --split dev_everyday --seeds 0 --out mine

The second command prints the address for the third. An isolated agent has no network, hence `ovman serve` (docs/protocol.md).

Limits. The models of the harness move arms. They see one picture and a sentence, so they know nothing of the first visit and can
only guess which object changed: expect scores near zero. A server whose observation parameters have `send_tours` gets both tours
with the first observation, under `tours`. The harness has no primitives of navigation. The adapter reads the mobile base of
RoboCasa (`base_motion`, `control_mode`) as driving, and stops when the arm takes over. It reads the action of an arm as if the
hand were the robot: forward, yaw, and a closing gripper stops. Agents cannot step back: a negative forward speed turns.
"""

import os
import time
from contextlib import ExitStack
from itertools import count

import msgpack
import numpy as np
from websockets.sync.client import connect

from ovman.agents.interface import Action

ARM = {"position": 3, "rotation": 3, "gripper": 1}
"""Components of an action and their sizes, for a server that declares none."""


def encode(value):
    """Return an array as the harness packs it."""
    return {"__ndarray__": True, "data": value.tobytes(), "dtype": value.dtype.str, "shape": list(value.shape)}


def decode(value):
    """Return the array that a map of the harness holds, or the map."""
    return np.frombuffer(value["data"], value["dtype"]).reshape(value["shape"]) if "__ndarray__" in value else value


class VlaAgent:
    """An agent that does what a model server says. One connection per run."""

    def __init__(self, context):
        self.numbers = count(1)
        self.open = ExitStack()
        dialled = connect(os.environ["VLA_SERVER"], compression=None, max_size=None, ping_interval=None)
        self.socket = self.open.enter_context(dialled)
        self.hello = self.ask_server("hello", {"protocol_version": 1, "harness_version": "ovman", "benchmark": "ovman"})
        sizes = {name: spec["dims"] for name, spec in self.hello.get("action_spec", {}).items()}
        sizes = sizes if {"base_motion", "control_mode"} <= {*sizes} else ARM
        self.starts = dict(zip(sizes, np.cumsum([0, *sizes.values()]), strict=False))

    def familiarise(self, visit):
        """Keep the first tour."""
        self.tours = {"first": visit.observations}

    def revisit(self, visit):
        """Keep the second tour."""
        self.tours["second"] = visit.observations

    def ask(self, query):
        """Begin an episode of the harness."""
        self.task = query.sentence
        self.tell_server("episode_start", {"task": {"name": self.task}})
        wanted = self.hello.get("observation_params", {}).get("send_tours")
        self.extra = {"tours": {which: [describe(one) for one in tour] for which, tour in self.tours.items()}} if wanted else {}

    def act(self, observation):
        """Return the primitive nearest to the action of the server."""
        seen = {"images": {"agentview": observation.rgb}, "task_description": self.task, **self.extra}
        self.extra = {}
        action = np.atleast_2d(self.ask_server("observation", seen)["actions"])[0]
        if "base_motion" in self.starts:
            drive, done = action[self.starts["base_motion"] :], action[self.starts["control_mode"]] < 0.5
            forward, turn = drive[0], drive[2]
        else:
            forward, turn, done = action[0], action[5], action[6] > 0
        if done:
            return Action.STOP
        if forward >= abs(turn):
            return Action.MOVE_AHEAD
        return Action.ROTATE_LEFT if turn > 0 else Action.ROTATE_RIGHT

    def tell_server(self, kind, payload):
        """Send a message."""
        message = {"type": kind, "payload": payload, "seq": next(self.numbers), "timestamp": time.time()}
        self.socket.send(msgpack.packb(message, default=encode))

    def ask_server(self, kind, payload):
        """Send a message and return the payload of the reply."""
        self.tell_server(kind, payload)
        reply = msgpack.unpackb(self.socket.recv(), object_hook=decode)
        if reply["type"] == "error":
            raise RuntimeError(f"the model server says: {reply['payload']}")
        return reply["payload"]

    def __del__(self):
        """End the episode: the server takes a lost connection for its end."""
        self.open.close()


def describe(observation):
    """Return a view of a tour as a message has it: pose is x, y, z in metres, yaw and horizon in degrees."""
    at = observation.pose
    pose = np.array([at.x, at.y, at.z, at.yaw_deg, at.horizon_deg])
    return {"image": observation.rgb, "depth": observation.depth, "pose": pose}

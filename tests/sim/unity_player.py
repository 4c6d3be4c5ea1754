"""Plays Unity's part: the engine with those of Unity's manners that it does not have itself.

Depth is short by near / far; after a reset, things move until time has passed (three times Pass).
"""

from __future__ import annotations

import sys

import msgpack
import numpy as np

from ovman_engine import __main__, engine
from ovman_engine.client.wire import Field

RESTLESS = 3
"""How many times Pass it takes until a scene is at rest."""


class Player(engine.Engine):
    restless = 0

    def answer(self, body):
        self._last_state = None  # an answer of its own to everything
        return [(field, self._mannered(field, content)) for field, content in super().answer(body)]

    def _mannered(self, field, content):
        if field is Field.DEPTH:
            near, far = self.session.settings.near_m, self.session.settings.far_m
            return (np.frombuffer(content, np.float32) * np.float32((far - near) / far)).tobytes()
        if field is not Field.METADATA:
            return content
        message = msgpack.unpackb(content)
        (agent,) = message["agents"]
        if agent["lastAction"] == "Initialize":
            self.restless = RESTLESS
        self.restless -= agent["lastAction"] == "Pass"
        agent["isSceneAtRest"] = agent["isSceneAtRest"] and self.restless <= 0
        return msgpack.packb(message)


if __name__ == "__main__":
    engine.Engine = Player
    sys.exit(__main__.main())

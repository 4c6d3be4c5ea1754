"""An agent that does not run in the evaluator's process: its messages (docs/protocol.md), and the place where it runs.

It is told observations and the query, and nothing more.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import Action, Observation, Query, Visit
from ovman.remote.connection import Connection, ConnectionLost
from ovman.remote.process import AgentProcess
from ovman.runner import AGENT_DRAWS, Run
from ovman.settings.benchmark import Remote
from ovman_client.messages import PICTURES, POSE, POSITIONS

VISITS_KEPT = 2
"""Visits that are kept as messages, of some 15 MB each: all seeds of an episode have them in common."""


@dataclass(frozen=True, slots=True)
class AgentEndpoint:
    """The place where an agent runs: a server that listens already, or one to start on this machine.

    Attributes:
        limits: Time and resources that the agent may use.
        url: ws://host:port of a server that listens; None for one to start.
        arguments: Of Python, for a server to start (`AgentProcess`).
        log: File that takes the output of a server that is started.
    """

    limits: Remote
    url: str | None = None
    arguments: tuple[str, ...] = ()
    log: Path = Path("agent.log")

    @contextmanager
    def open(self) -> Iterator[RemoteAgents]:
        """Return the factory of its agents. It connects on first use, and a server that it started ends with the context."""
        agents = RemoteAgents(self)
        try:
            yield agents
        finally:
            agents.drop()


class RemoteAgents:
    """Makes the agents of an evaluation, over one connection that is made again if it was lost."""

    def __init__(self, endpoint: AgentEndpoint) -> None:
        self._endpoint, self._tours = endpoint, TourMessages()
        self._process = None if endpoint.url else AgentProcess(endpoint.arguments, endpoint.limits, endpoint.log)
        self._connection: Connection | None = None

    def __call__(self, run: Run) -> RemoteAgent:
        """Return an agent for a run. ConnectionLost and AgentError as for `Connection`."""
        connection = self.connect()
        if self._process is not None:
            self._process.clean()
        return RemoteAgent(connection, run, self._endpoint.limits, self._tours)

    def connect(self) -> Connection:
        """Return the connection; make it if there is none. AgentError as for `Connection`."""
        if self._connection is None:
            why = None if self._process is None else self._process.passed_limit
            url = self._endpoint.url if self._process is None else self._process.address()
            self._connection = Connection(str(url), self._endpoint.limits.connect_s, why)
        return self._connection

    def drop(self) -> None:
        """Close the connection, and end the server if it was started here."""
        if self._connection is not None:
            self._connection.close()
        self._connection = None
        if self._process is not None:
            self._process.end()


class RemoteAgent:
    """An `Agent` at the other end of a connection, for one run. Each method is one message and its reply."""

    looks = True

    def __init__(self, connection: Connection, run: Run, limits: Remote, tours: TourMessages) -> None:
        self._connection, self._limits, self._tours = connection, limits, tours
        self._left_s = limits.run_s
        self._tell(begin_message(run))

    def familiarise(self, visit: Visit) -> None:
        """Call `Agent.familiarise`. ConnectionLost and AgentError as for `Connection.ask`; so for the other methods."""
        self._tell({"type": "familiarise", "visit": self._tours(visit)})

    def revisit(self, visit: Visit) -> None:
        """Call `Agent.revisit`."""
        self._tell({"type": "revisit", "visit": self._tours(visit)})

    def ask(self, query: Query) -> None:
        """Call `Agent.ask`."""
        reply = self._tell({"type": "ask", "query": {"category": query.category, "relation": str(query.relation)}})
        self.looks = reply.get("looks") is not False

    def act(self, observation: Observation) -> Action:
        """Call `Agent.act`. ConnectionLost for a reply that is not an action."""
        reply = self._ask({"type": "act", "observation": observation_message(observation)}, self._limits.act_s)
        if reply["type"] == "action":
            try:
                return Action(str(reply.get("action")))
            except ValueError:
                pass
        self._connection.close()
        names = ", ".join(Action)
        raise ConnectionLost(f"act: the reply {str(reply.get('action', reply['type'])):.40} is no action; answer one of {names}")

    def _tell(self, message: Mapping[str, Any]) -> dict[str, Any]:
        reply = self._ask(message, self._limits.tour_s)
        if reply["type"] != "done":
            self._connection.close()
            raise ConnectionLost(f"{message['type']}: the reply is {reply['type']:.40}, not done; answer as the protocol says")
        return reply

    def _ask(self, message: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        """Return the reply to a message, within the time of the message and within the rest of the run's time."""
        began = time.monotonic()
        try:
            return self._connection.ask(message, min(limit_s, self._left_s))
        except ConnectionLost as error:
            if time.monotonic() - began < self._left_s:
                raise
            whole = f"the agent has taken {self._limits.run_s:g} s of the run; answer sooner, or raise remote.run_s"
            raise ConnectionLost(f"{message['type']}: {whole}") from error
        finally:
            self._left_s = max(0.0, self._left_s - (time.monotonic() - began))


class TourMessages:
    """Visits as parts of messages; the last few are kept by their content."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Sequence[dict[str, Any]]] = OrderedDict()

    def __call__(self, visit: Visit) -> dict[str, Any]:
        """Return the visit as a part of a message."""
        observations = self._kept.pop(visit.content, None) if visit.content is not None else None
        if observations is None:
            observations = [observation_message(seen) for seen in visit.observations]
        if visit.content is not None:
            self._kept[visit.content] = observations
        while len(self._kept) > VISITS_KEPT:
            self._kept.popitem(last=False)
        return {"observations": list(observations), "reachable": _array(visit.reachable, POSITIONS), "content": visit.content}


def begin_message(run: Run) -> dict[str, Any]:
    """Return the message `begin`: constants of the protocol, the body's camera, and words that the agent's draws follow from."""
    body, primitives = run.embodiment, run.episode.protocol.primitives
    return {
        "type": "begin",
        **primitives.model_dump(mode="json"),
        "action_budget": primitives.action_budget if run.arm.budget is None else run.arm.budget,
        "camera": {"width": body.width_px, "height": body.height_px, "field_of_view_deg": body.field_of_view_deg},
        "words": {name: run.words(name) for name in AGENT_DRAWS},
    }


def observation_message(seen: Observation) -> dict[str, Any]:
    """Return an observation as a part of a message. ValueError for one with oracle positions, which stay with the evaluator."""
    if seen.positions is not None:
        raise ValueError("an agent that is given positions runs in the evaluator's process")
    return {
        "rgb": None if seen.rgb is None else _array(seen.rgb, PICTURES["rgb"]),
        "depth": None if seen.depth is None else _array(seen.depth, PICTURES["depth"]),
        "pose": {name: float(getattr(seen.pose, name)) for name in POSE},
        "field_of_view_deg": float(seen.field_of_view_deg),
        "last_action_succeeded": bool(seen.last_action_succeeded),
        "reachable": None if seen.reachable is None else _array(seen.reachable, POSITIONS),
    }


def _array(values: np.ndarray, dtype: str) -> dict[str, Any]:
    ordered = np.ascontiguousarray(values, dtype)
    return {"dtype": dtype, "shape": list(ordered.shape), "data": ordered.tobytes()}

"""A WebSocket server for an agent: the evaluator dials, asks, and the agent answers. One connection a worker of the evaluator."""

from __future__ import annotations

import json
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server as Listener
from websockets.sync.server import ServerConnection
from websockets.sync.server import serve as listen

from ovman_client import messages
from ovman_client.messages import PROTOCOL, MessageError

MAX_MESSAGE = 1 << 30
"""Bytes. A tour of 24 frames of 300 by 300 pixels has 15 MB."""

Make = Callable[[Mapping[str, Any]], Any]
"""From the message `begin` to an agent for one run."""


class Server:
    """Serves an agent until it is closed. A context manager that begins to listen at once.

    agent: called with a `Context` for every run, it returns an object with the four methods; or, with decoded=False, called with
    the message `begin` as it came, and given the others as they came. name: what the agent calls itself. port: 0 takes a
    free one.
    """

    def __init__(
        self, agent: Callable[..., Any], name: str, host: str = "127.0.0.1", port: int = 8765, decoded: bool = True
    ) -> None:
        self._name = name
        self._make: Make = (lambda begun: _Decoded(agent(messages.context(begun)))) if decoded else agent
        self._listener: Listener = listen(
            self._converse,
            host,
            port,
            compression=None,
            max_size=MAX_MESSAGE,
            ping_interval=None,
            process_request=self._health,
        )

    @property
    def port(self) -> int:
        """Where it listens."""
        port: int = self._listener.socket.getsockname()[1]
        return port

    def forever(self) -> None:
        """Serve until `close`, or until the process is told to end."""
        self._listener.serve_forever()

    def close(self) -> None:
        """Stop listening."""
        self._listener.shutdown()

    def __enter__(self) -> Server:
        threading.Thread(target=self.forever, daemon=True).start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _health(self, connection: ServerConnection, request: Any) -> Any:
        if request.path != "/health":
            return None
        status = {"status": "ok", "protocol": PROTOCOL, "agent": self._name}
        response = connection.respond(HTTPStatus.OK, json.dumps(status) + "\n")
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "application/json"
        return response

    def _converse(self, connection: ServerConnection) -> None:
        run: Any | None = None
        try:
            for data in connection:
                number = None
                try:
                    message = messages.unpacked(data)
                    number = message.get("number")
                    run, reply = self._answered(run, message)
                except MessageError as error:
                    reply = {"type": "error", "message": str(error)}
                except (Exception, SystemExit) as error:
                    traceback.print_exception(type(error), error, error.__traceback__)
                    reply, run = {"type": "error", "message": _line(error)}, None
                connection.send(messages.packed({**reply, "number": number}))
        except ConnectionClosed:
            pass

    def _answered(self, run: Any | None, message: Mapping[str, Any]) -> tuple[Any | None, dict[str, Any]]:
        kind = message["type"]
        if kind == "hello":
            if message.get("protocol") != PROTOCOL:
                raise MessageError(
                    f"this agent speaks {PROTOCOL}, the evaluator {message.get('protocol')}; install one version of both"
                )
            return run, {"type": "welcome", "protocol": PROTOCOL, "agent": self._name}
        if kind == "begin":
            return self._make(message), {"type": "done"}
        if kind == "end":
            return None, {"type": "done"}
        if run is None:
            raise MessageError(f"{kind} without begin")
        if kind in ("familiarise", "revisit"):
            getattr(run, kind)(_part(message, "visit"))
            return run, {"type": "done"}
        if kind == "ask":
            run.ask(_part(message, "query"))
            return run, {"type": "done", "looks": bool(getattr(run, "looks", True))}
        if kind == "act":
            returned = run.act(_part(message, "observation"))
            action = messages.action(returned)
            if action is None:
                raise TypeError(f"act returned {returned!r:.200}; return an ovman_client.Action")
            return run, {"type": "action", "action": action.value}
        raise MessageError(f"no message is called {kind:.40}")


def serve(agent: Callable[..., Any], name: str | None = None, host: str = "127.0.0.1", port: int = 8765) -> None:
    """Serve an agent until the process is told to end, and say where. Parameters as of `Server`."""
    server = Server(agent, name or str(getattr(agent, "__name__", "agent")), host, port)
    print(f"{server._name} listens on ws://{host}:{server.port}", file=sys.stderr, flush=True)
    try:
        server.forever()
    except KeyboardInterrupt:
        server.close()


class _Decoded:
    """An agent that is given arrays and dataclasses in the place of messages."""

    def __init__(self, agent: Any) -> None:
        self._agent = agent

    @property
    def looks(self) -> bool:
        return bool(getattr(self._agent, "looks", True))

    def familiarise(self, visit: Mapping[str, Any]) -> None:
        self._agent.familiarise(messages.visit(visit))

    def revisit(self, visit: Mapping[str, Any]) -> None:
        self._agent.revisit(messages.visit(visit))

    def ask(self, query: Mapping[str, Any]) -> None:
        self._agent.ask(messages.query(query))

    def act(self, observation: Mapping[str, Any]) -> Any:
        return self._agent.act(messages.observation(observation))


def _part(message: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    part = message.get(name)
    if not isinstance(part, dict):
        raise MessageError(f"{message['type']} lacks {name}")
    return part


def _line(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    place = f" in {Path(frames[-1].filename).name}, line {frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}{place}: {' '.join(str(error).split()) or 'no message'}"[:500]

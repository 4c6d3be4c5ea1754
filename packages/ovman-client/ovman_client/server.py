"""A WebSocket server for an agent: the evaluator dials, asks, and the agent answers. One connection a worker of the evaluator."""

from __future__ import annotations

import hmac
import json
import os
import secrets
import socket
import sys
import sysconfig
import threading
import traceback
from collections.abc import Callable, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server as Listener
from websockets.sync.server import ServerConnection
from websockets.sync.server import serve as listen

from ovman_client import messages
from ovman_client.interface import Action
from ovman_client.messages import MAX_MESSAGE, PROTOCOL, MessageError

TOKEN = "OVMAN_TOKEN"
"""The environment variable that may hold the token of a server; else it is drawn anew for each."""
HERE = ("127.0.0.1", "::1", "localhost")
"""Hosts that only this machine reaches."""
KEEP_ALIVE = {"TCP_KEEPIDLE": 60, "TCP_KEEPINTVL": 20, "TCP_KEEPCNT": 3}
"""Seconds, seconds and number of the kernel's questions whether a silent evaluator's machine is still there."""

OURS = ("ovman", "ovman_client")
"""Packages whose lines are not the agent's."""

Make = Callable[[Mapping[str, Any]], Any]
"""From the message `begin` to an agent for one run."""


class Server:
    """Serves an agent until it is closed. A context manager that begins to listen at once.

    agent: called with a `Context` for every run, it returns an object with the four methods; or, with decoded=False, called with
    the message `begin` as it came, and given the others as they came. name: what the agent calls itself. port: 0 takes a
    free one. listener: a socket that listens already, in the place of host and port. token: what the evaluator must bring to be
    let in; None for that of the environment, or for a new one. Web pages, which send an Origin, are not let in.
    """

    def __init__(
        self,
        agent: Callable[..., Any],
        name: str,
        host: str = "127.0.0.1",
        port: int = 8765,
        decoded: bool = True,
        token: str | None = None,
        listener: socket.socket | None = None,
    ) -> None:
        self._name, self._host = name, host
        self._token = token or os.environ.get(TOKEN) or secrets.token_urlsafe(16)
        self._make: Make = (lambda begun: _Decoded(agent(messages.context(begun)))) if decoded else agent
        self._listener: Listener = listen(
            self._converse,
            host if listener is None else None,
            port if listener is None else None,
            sock=listener,
            compression=None,
            max_size=MAX_MESSAGE,
            ping_interval=None,
            origins=[None],
            process_request=self._admit,
        )

    @property
    def port(self) -> int:
        """Where it listens."""
        port: int = self._listener.socket.getsockname()[1]
        return port

    @property
    def url(self) -> str:
        """What the evaluator dials, the token included."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"ws://{host}:{self.port}/?token={quote(self._token, safe='')}"

    @property
    def greeting(self) -> str:
        """What to print when it listens: a line with its address, and a warning where other machines reach it."""
        reach = "anybody who has this address may use the agent, and what is sent can be read on the way; a tunnel is safer"
        return f"{self._name} listens on {self.url}" + ("" if self._host in HERE else f"\nwarning: --host {self._host}: {reach}")

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

    def _admit(self, connection: ServerConnection, request: Any) -> Any:
        """Answer /health, and turn away whoever lacks the token."""
        parts = urlsplit(request.path)
        if parts.path != "/health":
            token = parse_qs(parts.query).get("token", [""])[0]
            if hmac.compare_digest(token.encode(), self._token.encode()):
                return None
            return connection.respond(HTTPStatus.UNAUTHORIZED, "dial the address that the server printed, with its ?token=\n")
        status = {"status": "ok", "protocol": PROTOCOL, "agent": self._name}
        response = connection.respond(HTTPStatus.OK, json.dumps(status) + "\n")
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "application/json"
        return response

    def _converse(self, connection: ServerConnection) -> None:
        run: Any | None = None
        _keep_alive(connection.socket)
        try:
            for data in connection:
                number, message = None, {}
                try:
                    message = messages.unpacked(data)
                    number = message.get("number")
                    run, reply = self._answered(run, message)
                except MessageError as error:
                    reply = {"type": "error", "message": str(error)}
                except (Exception, SystemExit) as error:
                    traceback.print_exception(type(error), error, error.__traceback__)
                    said = _line(error) + (BLIND if _blind(run, message, error) else "")
                    reply, run = {"type": "error", "message": said}, None
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
                raise TypeError(
                    f"act returned {returned!r:.200}; return an Action of ovman.agents.interface or of ovman_client, "
                    f"or its name: {', '.join(action.value for action in Action)}"
                )
            return run, {"type": "action", "action": action.value}
        raise MessageError(f"no message is called {kind:.40}")


BLIND = " (looks is False, so rgb and depth are None in act; set looks to True to be given pictures)"


def _blind(run: Any, message: Mapping[str, Any], error: BaseException) -> bool:
    """Whether an agent that takes no pictures has used one as if it were there."""
    blind = message.get("type") == "act" and not getattr(run, "looks", True)
    return blind and isinstance(error, (AttributeError, TypeError)) and "NoneType" in str(error)


def _keep_alive(connection: socket.socket) -> None:
    """Have the kernel close a connection whose other machine is gone."""
    if connection.family not in (socket.AF_INET, socket.AF_INET6):
        return
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in KEEP_ALIVE.items():
        if hasattr(socket, name):  # Linux
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


METHODS = ("familiarise", "revisit", "ask", "act")


def lacking(agent: Any) -> str | None:
    """Name a method that an agent, or a class of agents, does not have; None where it has all four, or is a function."""
    if not isinstance(agent, type) and callable(agent):
        return None
    return next((name for name in METHODS if not callable(getattr(agent, name, None))), None)


def serve(agent: Callable[..., Any], name: str | None = None, host: str = "127.0.0.1", port: int = 8765) -> None:
    """Serve an agent until the process is told to end, and say where. Parameters as of `Server`."""
    server = Server(agent, name or str(getattr(agent, "__name__", "agent")), host, port)
    print(server.greeting, file=sys.stderr, flush=True)
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
    """Return the error in one line, with the innermost place in the agent's own code.

    Where none is known, the innermost place of all.
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not _of_a_library(frame.filename)] or frames
    place = f" in {Path(own[-1].filename).name}, line {own[-1].lineno}" if own else ""
    return f"{type(error).__name__}{place}: {' '.join(str(error).split()) or 'no message'}"[:500]


def _of_a_library(file: str) -> bool:
    """Whether a file is Python's, an installed package's, or of OVMAN, which may lie in a checkout."""
    folders = {Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    folders |= {Path(str(sys.modules[name].__file__)).parent for name in OURS if name in sys.modules}
    return not folders.isdisjoint(Path(file).absolute().parents)

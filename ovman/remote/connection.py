"""The connection to an agent's server: one request, one reply, each within its time."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from http import HTTPStatus
from typing import Any

from websockets.exceptions import ConnectionClosed, InvalidStatus, InvalidURI, WebSocketException
from websockets.sync.client import connect

from ovman.evaluation.supervision import AgentError
from ovman_client.messages import MAX_MESSAGE, PROTOCOL, MessageError, packed, unpacked

MAX_REPLY = 1 << 16
"""Bytes. The longest reply that the protocol has is the line of an error."""
TOO_BIG = 1009
"""The WebSocket code for a message that is larger than allowed."""
SAID = 300
"""Characters that are shown of what an agent says of its error."""


class ConnectionLost(AgentError):
    """The agent's server cannot be reached any more: it died, or it broke the protocol and the connection was closed."""


class Connection:
    """A connection to an agent's server. A context manager."""

    def __init__(self, url: str, connect_s: float, why: Callable[[], str | None] | None = None) -> None:
        """Connect and say hello.

        Args:
            url: "ws://host:port/?token=...", as the server prints it.
            connect_s: Seconds until the connection must stand.
            why: Says why the other side is gone, if that is known.

        Raises:
            AgentError: The connection does not stand, or the other side speaks another protocol.
        """
        self._number, self._why = 0, why
        place = url.partition("?")[0]  # the token is nobody else's
        try:
            self._open = ExitStack()
            self._socket = self._open.enter_context(
                connect(
                    url,
                    open_timeout=connect_s,
                    close_timeout=1,
                    max_size=MAX_REPLY,
                    compression=None,
                    ping_interval=None,
                    proxy=None,
                )
            )
        except InvalidURI:
            raise AgentError(f"--server: {place!r} is not an address; write ws://host:port/?token=... as printed") from None
        except InvalidStatus as error:
            if error.response.status_code != HTTPStatus.UNAUTHORIZED:
                raise ConnectionLost(f"{place}: no agent answers ({_words(error)}); name the address of its server") from None
            raise AgentError(f"{place}: its server asks for a token; write the whole address that it printed") from None
        except (OSError, WebSocketException, TimeoutError) as error:
            raise ConnectionLost(
                f"{place}: no agent answers ({_words(error)}); start its server, ovman serve or ovman-client"
            ) from None
        welcome = self.ask({"type": "hello", "protocol": PROTOCOL}, connect_s)
        if welcome["type"] != "welcome" or not isinstance(welcome.get("agent"), str):
            self.close()
            raise AgentError(f"{place}: hello was answered by {welcome['type']:.40}; the agent's side speaks another protocol")
        self.agent = str(welcome["agent"])[:80]

    def ask(self, message: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        """Send a message and return the reply. limit_s: Seconds for both ways.

        Raises:
            ConnectionLost: Nothing comes in time, the reply is not a message, or the other side is gone. The connection closes.
            AgentError: The reply is an error of the agent's own.
        """
        self._number += 1
        kind = str(message["type"])
        with self._closed_on_failure(kind, limit_s):
            data = packed({**message, "number": self._number})
            if len(data) > MAX_MESSAGE:
                raise MessageError(f"a message of {len(data)} bytes, and the protocol has {MAX_MESSAGE} at most")
            with self._send_limit(limit_s):
                self._socket.send(data)
            reply = unpacked(self._socket.recv(timeout=limit_s))
        if reply.get("number") != self._number:
            self.close()
            raise ConnectionLost(
                f"{kind}: the agent answered message {str(reply.get('number')):.20}, not {self._number}; answer in turn"
            )
        if reply["type"] == "error":
            raise AgentError(f"{kind} raised {' '.join(str(reply.get('message')).split()):.{SAID}}; mend the agent")
        return reply

    def close(self) -> None:
        """Close the connection."""
        with suppress(OSError, WebSocketException):
            self._open.close()

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @contextmanager
    def _closed_on_failure(self, kind: str, limit_s: float) -> Iterator[None]:
        try:
            yield
        except TimeoutError:
            reason = f"no answer within {limit_s:g} s; answer sooner, or raise the limit in section remote of the settings"
        except ConnectionClosed as error:
            sent = error.sent
            large = sent is not None and sent.code == TOO_BIG
            gone = (None if large or self._why is None else self._why()) or "the agent is gone"
            reason = f"an answer of more than {MAX_REPLY} bytes; answer with one action" if large else gone
        except (MessageError, WebSocketException, OSError) as error:
            reason = f"{_words(error):.{SAID}}; answer as the protocol says"
        else:
            return
        self.close()
        raise ConnectionLost(f"{kind}: {reason}") from None

    @contextmanager
    def _send_limit(self, limit_s: float) -> Iterator[None]:
        """End a send to an agent that does not read."""
        late = threading.Timer(limit_s, self._shut)
        late.daemon = True
        late.start()
        try:
            yield
        finally:
            late.cancel()

    def _shut(self) -> None:
        with suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)


def _words(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__

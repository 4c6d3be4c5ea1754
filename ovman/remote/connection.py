"""The connection to an agent's server: one request, one reply, each within its time."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from functools import partial
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

    def __init__(self, url: str, connect_s: float, address: bytes | None = None) -> None:
        """Connect and say hello.

        Args:
            url: "ws://host:port/?token=...", as the server prints it.
            connect_s: Seconds until the connection must stand.
            address: Of the Unix socket of a server that was started here; None for the host and port of the URL.

        Raises:
            AgentError: The connection does not stand, or the other side speaks another protocol.
        """
        self._number, self._open = 0, ExitStack()
        place = url.partition("?")[0]  # the token is nobody else's
        try:
            own = None if address is None else _dial(address, connect_s)
            limits = partial(connect, open_timeout=connect_s, close_timeout=1, max_size=MAX_REPLY, ping_interval=None)
            self._socket = self._open.enter_context(limits(url, sock=own, compression=None, proxy=None))
        except InvalidURI:
            raise AgentError(f"--server: {place!r} is not an address; write ws://host:port/?token=... as printed") from None
        except (OSError, WebSocketException) as error:
            if isinstance(error, InvalidStatus) and error.response.status_code == HTTPStatus.UNAUTHORIZED:
                raise AgentError(f"{place}: its server asks for a token; write the whole address that it printed") from None
            says = f"no agent answers ({_words(error)}); start its server, ovman serve or ovman-client"
            raise ConnectionLost(f"{place}: {says}") from None
        welcome = self.ask({"type": "hello", "protocol": PROTOCOL}, connect_s)
        if welcome["type"] != "welcome" or not isinstance(welcome.get("agent"), str):
            self.close()
            raise AgentError(f"{place}: hello was answered by {welcome['type']:.40}; the agent's side speaks another protocol")

    def ask(self, message: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        """Send a message and return the reply. limit_s: Seconds for both ways.

        Raises:
            ConnectionLost: Nothing comes in time, the reply is not a message, or the other side is gone. The connection closes.
            AgentError: The reply is an error of the agent's own.
        """
        self._number += 1
        kind, began = str(message["type"]), time.monotonic()
        late = threading.Timer(limit_s, self._shut)  # ends a send, too, to an agent that does not read
        late.daemon = True
        late.start()
        try:
            data = packed({**message, "number": self._number})
            if len(data) > MAX_MESSAGE:
                raise MessageError(f"a message of {len(data)} bytes, and the protocol has {MAX_MESSAGE} at most")
            self._socket.send(data)
            reply = unpacked(self._socket.recv())
            if reply.get("number") != self._number:
                raise MessageError(f"the agent answered message {str(reply.get('number')):.20}, not {self._number}")
        except ConnectionClosed as error:
            if time.monotonic() - began >= limit_s:
                raise self.lose(
                    f"{kind}: no answer within {limit_s:g} s; answer sooner, or raise the limit in section remote"
                ) from None
            if error.sent is not None and error.sent.code == TOO_BIG:
                raise self.lose(f"{kind}: an answer of more than {MAX_REPLY} bytes; answer with one action") from None
            raise self.lose(f"{kind}: the agent is gone") from None
        except (MessageError, WebSocketException, OSError) as error:
            raise self.lose(f"{kind}: {_words(error):.{SAID}}; answer as the protocol says") from None
        finally:
            late.cancel()
        if reply["type"] == "error":
            raise AgentError(f"{kind} raised {' '.join(str(reply.get('message')).split()):.{SAID}}; mend the agent")
        return reply

    def lose(self, why: str) -> ConnectionLost:
        """Close the connection, and return the error that says why."""
        self.close()
        return ConnectionLost(why)

    def close(self) -> None:
        """Close the connection."""
        with suppress(OSError, WebSocketException):
            self._open.close()

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _shut(self) -> None:
        with suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)


def _dial(address: bytes, connect_s: float) -> socket.socket:
    own = socket.socket(socket.AF_UNIX)
    own.settimeout(connect_s)
    own.connect(address)
    return own


def _words(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__

"""The engine's end of AI2-THOR's FIFO protocol.

A message is a sequence of frames and an end mark. A frame is a type (u8), a length (u32, big-endian) and that many bytes. The
engine writes metadata (MessagePack) and images to the server pipe; the client writes actions (UTF-8 JSON) to the client pipe.
This module imports the standard library only: the client waits without a time limit until the server pipe is opened.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import select
import struct
import time
from collections.abc import Iterable
from enum import IntEnum

HEADER = struct.Struct("!BI")
PIPE_BYTES = 1 << 20
"""Requested size of a pipe's buffer, the largest that Linux grants to any user. The client concatenates what it reads, at a cost
quadratic in the number of pieces, and the usual 64 KiB make many pieces."""
ACTION_BYTES = 64 << 20
"""Longest frame accepted from the client."""
PATIENCE_S = 1.0
"""Interval at which an idle engine checks that its parent is alive."""
OPENING_S = 0.002
"""Interval at which the engine checks whether the client has opened its end of the server pipe."""
OPENING_LIMIT_S = 60.0
"""Limit of that wait. The client opens its end as soon as it has started the engine. If the client died before the engine looked,
its death is never seen."""


class Field(IntEnum):
    """Types of frames."""

    METADATA = 1
    ACTION = 2
    RGB = 4
    DEPTH = 5
    NORMALS = 6
    FLOW = 7
    CLASSES = 8
    IDS = 9
    THIRD_PARTY_RGB = 10
    METADATA_PATCH = 11
    THIRD_PARTY_DEPTH = 12
    THIRD_PARTY_NORMALS = 13
    THIRD_PARTY_IDS = 14
    THIRD_PARTY_CLASSES = 15
    THIRD_PARTY_FLOW = 16
    END_OF_MESSAGE = 255


END = HEADER.pack(Field.END_OF_MESSAGE, 0)


class ClientGone(Exception):
    """The other end of a pipe is closed, or the process that started the engine has ended."""


class Wire:
    """The two pipes of one client. Not thread-safe."""

    def __init__(self, server_pipe: str, client_pipe: str) -> None:
        """Open the server pipe, and waits for the client to open its end. Raises ClientGone if the client ends first."""
        self._client_pipe = client_pipe
        self._parent = os.getppid()
        self._from_client: int | None = None
        self._to_client = self._open_server_pipe(server_pipe)

    def _open_server_pipe(self, path: str) -> int:
        end = time.monotonic() + OPENING_LIMIT_S
        while True:
            try:
                pipe = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
            except OSError as error:
                if error.errno == errno.ENOENT:
                    raise ClientGone(f"no such pipe: {path}") from None
                if error.errno != errno.ENXIO:
                    raise
                self._check_parent()
                if time.monotonic() > end:
                    raise ClientGone("the client did not open the server pipe") from None
                time.sleep(OPENING_S)
            else:
                os.set_blocking(pipe, True)
                _enlarge(pipe)
                return pipe

    def send(self, frames: Iterable[tuple[Field, bytes | memoryview]]) -> None:
        """Write one message. Raises ClientGone if the pipe is closed."""
        pieces: list[memoryview] = []
        for field, body in frames:
            view = memoryview(body).cast("B")
            pieces += [memoryview(HEADER.pack(field, view.nbytes)), view]
        pieces.append(memoryview(END))
        try:
            while pieces:
                written = os.writev(self._to_client, pieces)
                while pieces and written >= pieces[0].nbytes:
                    written -= pieces.pop(0).nbytes
                if written:
                    pieces[0] = pieces[0][written:]
        except BrokenPipeError:
            raise ClientGone("the client closed the server pipe") from None

    def receive(self) -> bytes:
        """Body of the next action. Frames of other types are skipped. Raises ClientGone at the end of the client pipe."""
        action = b""
        while True:
            kind, length = HEADER.unpack(self._read(HEADER.size))
            if kind == Field.END_OF_MESSAGE:
                return action
            if length > ACTION_BYTES:
                raise ClientGone(f"a frame of {length} bytes is no action")
            body = self._read(length)
            if kind == Field.ACTION:
                action = body

    def close(self) -> None:
        """Close both pipes."""
        os.close(self._to_client)
        if self._from_client is not None:
            os.close(self._from_client)

    def _client_end(self) -> int:
        """Return the client pipe, opened when it is first needed."""
        if self._from_client is None:
            self._from_client = self._open_client_pipe()
        return self._from_client

    def _open_client_pipe(self) -> int:
        """Open the client pipe without blocking, so that the death of a client that never writes is noticed."""
        try:
            pipe = os.open(self._client_pipe, os.O_RDONLY | os.O_NONBLOCK)
        except FileNotFoundError:
            raise ClientGone(f"no such pipe: {self._client_pipe}") from None
        os.set_blocking(pipe, True)
        _enlarge(pipe)
        return pipe

    def _read(self, size: int) -> bytes:
        parts = []
        while size:
            self._wait()
            part = os.read(self._client_end(), size)
            if not part:
                raise ClientGone("the client closed the client pipe")
            parts.append(part)
            size -= len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _wait(self) -> None:
        """Wait for input. A parent that ended counts as a gone client, even if a process that it left behind holds the pipe."""
        poll = select.poll()
        poll.register(self._client_end(), select.POLLIN)
        poll.register(self._to_client, select.POLLERR)
        while True:
            events = dict(poll.poll(PATIENCE_S * 1000))
            if events.get(self._client_end()):
                return
            if events.get(self._to_client):
                raise ClientGone("the client closed the server pipe")
            self._check_parent()

    def _check_parent(self) -> None:
        if os.getppid() != self._parent:
            raise ClientGone("the process that started the engine has ended")


def _enlarge(pipe: int) -> None:
    with contextlib.suppress(OSError, AttributeError):  # not permitted for this user; the default size works too
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)

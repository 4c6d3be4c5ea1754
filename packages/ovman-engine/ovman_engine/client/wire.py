"""AI2-THOR's FIFO protocol, the engine's end of it.

A message is a sequence of frames and an end mark; a frame is a type (u8), a length (u32, big-endian) and that many bytes. The
engine writes metadata (MessagePack) and images to the server pipe, the client writes actions (UTF-8 JSON) to the client pipe.
Only the standard library is imported here: the client waits without a time limit for the server pipe to be opened.
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
"""Wanted size of the kernel's buffer of a pipe: the largest that Linux gives to anyone. The client joins what it reads piece by
piece, at a cost quadratic in the number of pieces, which the usual 64 KiB make many."""
ACTION_BYTES = 64 << 20
"""Longest frame that is accepted from the client."""
PATIENCE_S = 1.0
"""How often an idle engine looks whether its parent still lives."""
OPENING_S = 0.002
"""How often the engine looks whether the client has opened its end of the server pipe."""
OPENING_LIMIT_S = 60.0
"""How long the engine waits for that. The client opens it as soon as it has started the engine, so it must have died since; if it
was quick about it, the engine never saw it alive."""


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
    """The two pipes of one client. Not reentrant."""

    def __init__(self, server_pipe: str, client_pipe: str) -> None:
        """Opens the server pipe at once, waiting for the client to open its end. ClientGone if it ends before it does."""
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
                    raise ClientGone("nobody opened the server pipe") from None
                time.sleep(OPENING_S)
            else:
                os.set_blocking(pipe, True)
                _enlarge(pipe)
                return pipe

    def send(self, frames: Iterable[tuple[Field, bytes | memoryview]]) -> None:
        """Writes one message. ClientGone if nobody reads."""
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
        """Body of the next action; frames of other types are passed over. ClientGone at the end of the client pipe."""
        if self._from_client is None:
            self._from_client = self._open_client_pipe()
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
        os.close(self._to_client)
        if self._from_client is not None:
            os.close(self._from_client)

    def _open_client_pipe(self) -> int:
        """Without blocking, so that a client that dies before it ever writes is noticed."""
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
            part = os.read(self._from_client, size)
            if not part:
                raise ClientGone("the client closed the client pipe")
            parts.append(part)
            size -= len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _wait(self) -> None:
        """Until there is something to read. A parent that ended counts as a client that is gone, even if a process that it left
        behind still holds the pipe."""
        poll = select.poll()
        poll.register(self._from_client, select.POLLIN)
        poll.register(self._to_client, select.POLLERR)
        while True:
            events = dict(poll.poll(PATIENCE_S * 1000))
            if events.get(self._from_client):
                return
            if events.get(self._to_client):
                raise ClientGone("the client closed the server pipe")
            self._check_parent()

    def _check_parent(self) -> None:
        if os.getppid() != self._parent:
            raise ClientGone("the process that started the engine has ended")


def _enlarge(pipe: int) -> None:
    with contextlib.suppress(OSError, AttributeError):  # more than this user may have: the pipe works all the same
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)

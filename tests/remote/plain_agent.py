"""An agent's server written from docs/protocol.md with sockets alone: the WebSocket, MessagePack and the answers are all here."""

from __future__ import annotations

import base64
import hashlib
import socket
import struct
import threading
from collections.abc import Callable
from typing import Any

GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


class PlainServer:
    """Answers every question by `answer(message)`, one connection at a time. A context manager; port: where it listens.

    messages: all that it was told, with the sizes of arrays in the place of arrays. deaf: whether it reads nothing after hello.
    """

    def __init__(self, answer: Callable[[dict], dict], deaf: bool = False) -> None:
        self._answer, self._deaf, self.messages = answer, deaf, []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        self._done = threading.Event()

    def __enter__(self):
        threading.Thread(target=self._serve, daemon=True).start()
        return self

    def __exit__(self, *error):
        self._done.set()
        self._listening.close()

    def _serve(self):
        while True:
            try:
                connection, _ = self._listening.accept()
            except OSError:
                return
            with connection:
                handshake(connection)
                try:
                    while True:
                        message, rest = decoded(read_frame(connection))
                        assert rest == b""
                        self.messages.append(message)
                        reply = self._answer(message)
                        write_frame(connection, encoded({**reply, "number": message["number"]}))
                        if self._deaf:
                            self._done.wait()
                except (EOFError, OSError):
                    pass


def handshake(connection: socket.socket) -> None:
    request = b""
    while not request.endswith(b"\r\n\r\n"):
        request += connection.recv(1)
    lines = dict(line.split(b": ", 1) for line in request.split(b"\r\n")[1:] if b": " in line)
    key = next(value for name, value in lines.items() if name.lower() == b"sec-websocket-key")
    accept = base64.b64encode(hashlib.sha1(key + GUID).digest())
    connection.sendall(
        b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: "
        + accept
        + b"\r\n\r\n"
    )


def exactly(connection: socket.socket, n: int) -> bytes:
    data = bytearray()
    while len(data) < n:
        part = connection.recv(min(n - len(data), 1 << 20))
        if not part:
            raise EOFError
        data += part
    return bytes(data)


def read_frame(connection: socket.socket) -> bytes:
    """One message of binary frames; EOFError where the evaluator hangs up."""
    whole = b""
    while True:
        first, second = exactly(connection, 2)
        size = second & 0x7F
        if size == 126:
            (size,) = struct.unpack(">H", exactly(connection, 2))
        elif size == 127:
            (size,) = struct.unpack(">Q", exactly(connection, 8))
        mask = exactly(connection, 4)
        data = exactly(connection, size)
        if first & 0x0F == 8:
            raise EOFError
        words = int.from_bytes(data, "big") ^ int.from_bytes((mask * (size // 4 + 1))[:size], "big")
        whole += words.to_bytes(size, "big")
        if first & 0x80:
            return whole


def write_frame(connection: socket.socket, data: bytes) -> None:
    size = bytes([len(data)]) if len(data) < 126 else b"\x7e" + struct.pack(">H", len(data))
    connection.sendall(b"\x82" + size + data)


def encoded(value: Any) -> bytes:
    """MessagePack of what an answer has: short maps, texts, small integers, booleans and nil."""
    if value is None or isinstance(value, bool):
        return {None: b"\xc0", False: b"\xc2", True: b"\xc3"}[value]
    if isinstance(value, int):
        return b"\xce" + struct.pack(">I", value)
    if isinstance(value, str):
        return b"\xd9" + bytes([len(value.encode())]) + value.encode()
    return bytes([0x80 | len(value)]) + b"".join(encoded(k) + encoded(v) for k, v in value.items())


LENGTHS = {0xC4: ">B", 0xC5: ">H", 0xC6: ">I", 0xD9: ">B", 0xDA: ">H", 0xDB: ">I", 0xDC: ">H", 0xDD: ">I", 0xDE: ">H", 0xDF: ">I"}
NUMBERS = {0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q", 0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q"}


def decoded(data: bytes) -> tuple[Any, bytes]:
    """A value of MessagePack and the bytes after it. The data of an array is left as bytes."""
    kind, data = data[0], memoryview(data)[1:]
    if kind < 0x80:
        return kind, data
    if kind >= 0xE0:
        return kind - 256, data
    if kind in (0xC0, 0xC2, 0xC3):
        return {0xC0: None, 0xC2: False, 0xC3: True}[kind], data
    if kind in NUMBERS:
        size = struct.calcsize(NUMBERS[kind])
        return struct.unpack(NUMBERS[kind], data[:size])[0], data[size:]
    if kind in LENGTHS:
        size = struct.calcsize(LENGTHS[kind])
        length, data = struct.unpack(LENGTHS[kind], data[:size])[0], data[size:]
    else:
        length = kind & (0x1F if 0xA0 <= kind < 0xC0 else 0x0F)
    if kind in (0xC4, 0xC5, 0xC6):
        return bytes(data[:length]), data[length:]
    if kind in (0xD9, 0xDA, 0xDB) or 0xA0 <= kind < 0xC0:
        return bytes(data[:length]).decode(), data[length:]
    values = []
    for _ in range(length * (2 if kind in (0xDE, 0xDF) or kind < 0x90 else 1)):
        value, data = decoded(data)
        values.append(value)
    is_map = kind in (0xDE, 0xDF) or kind < 0x90
    return (dict(zip(values[::2], values[1::2], strict=True)) if is_map else values), data

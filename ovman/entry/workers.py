"""Work shared out among processes: each takes the next piece when it is done with one. One process alone receives what they make.

A worker ends with the process that started it, however that ends, and where a worker ends the others are ended: what was received
is kept, and the same command goes on.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from ovman.entry.errors import EntryError
from ovman.records.episode import Episode

Piece = TypeVar("Piece")
Send = Callable[[Any], None]
Work = Callable[[Piece, Send], None]
"""Is called with a piece and a function for what it sends."""
SENT, DONE, FAILED = "sent", "done", "failed"


def shared_out(
    opened: Callable[[], AbstractContextManager[Work[Piece]]], pieces: Sequence[Piece], workers: int, receive: Send
) -> None:
    """Have each piece worked on; `receive` is called in this process with what is sent, as it comes.

    opened: a context for the work, which each process enters once. workers: processes, at most as many as pieces; one is this
    process. opened, pieces and what is sent must be picklable where there are more. What the work raises is raised here.
    EntryError where a worker is killed.
    """
    number = min(workers, len(pieces))
    if number < 2:
        with opened() as work:
            for piece in pieces:
                work(piece, receive)
        return
    context = multiprocessing.get_context("spawn")
    processes: dict[Connection, Any] = {}
    left = iter(pieces)
    try:
        for _ in range(number):
            ours, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(opened, theirs))
            process.start()
            theirs.close()
            processes[ours] = process
            ours.send(next(left))
        busy = set(processes)
        while busy:
            for connection in wait(busy):
                assert isinstance(connection, Connection)
                if not _received(connection, processes[connection], receive, left):
                    busy.remove(connection)
    finally:
        for connection, process in processes.items():
            connection.close()
            process.terminate()
        for process in processes.values():
            process.join()


def as_texts(episodes: Iterable[Episode]) -> tuple[str, ...]:
    """Episodes as a worker can be sent them: their records hold what cannot be pickled. Nothing is rounded."""
    return tuple(episode.model_dump_json(by_alias=True) for episode in episodes)


def of_texts(texts: Iterable[str]) -> tuple[Episode, ...]:
    """The episodes of `as_texts`."""
    return tuple(Episode.parse(text) for text in texts)


def _received(connection: Connection, process: Any, receive: Send, left: Iterator[Any]) -> bool:
    """Take a message of a worker. False where it was done and there is no piece left."""
    try:
        kind, message = connection.recv()
    except (EOFError, OSError):
        process.join()
        how = f"by signal {-process.exitcode}" if (process.exitcode or 0) < 0 else f"with status {process.exitcode}"
        raise EntryError(f"a worker was ended {how}; finished runs are kept, and the same command goes on") from None
    if kind == FAILED:
        raise message
    if kind == SENT:
        receive(message)
        return True
    try:
        connection.send(next(left))
    except StopIteration:
        return False
    return True


def _serve(opened: Callable[[], AbstractContextManager[Work[Any]]], connection: Connection) -> None:
    """The life of a worker: pieces come by the connection until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is meant for the process that started it
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        with opened() as work:
            while True:
                try:
                    piece = connection.recv()
                except EOFError:
                    return
                work(piece, lambda message: connection.send((SENT, message)))
                connection.send((DONE, None))
    except Exception as error:
        connection.send((FAILED, _sendable(error)))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _sendable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return EntryError(f"{type(error).__name__}: {' '.join(str(error).split())}")
    return error

"""Attempts at the runs of an evaluation.

An attempt is written to disk before the agent is shown the first observation of its drive. Every attempt tells the agent the same
until then. An agent must not use what it learned by driving for another attempt, so the file outlives agent and evaluator.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ovman.agents.interface import Action, Observation
from ovman.atomic import durable_append

FILE = "attempts.jsonl"


class Attempts:
    """The attempts at an evaluation's runs in a file, one line per attempt. Several processes may append to it.

    Other code of the agent does not begin to count again: an agent could change its own.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        content = path.read_bytes() if path.exists() else b""
        if content and not content.endswith(b"\n"):  # torn by a kill; what comes next needs a line of its own
            durable_append(path, b"\n")
        self._number = _numbers(content)

    def of(self, episode: str, seed: int) -> int:
        """Return the number of attempts at a run."""
        return self._number.get((episode, seed), 0)

    def begin(self, episode: str, seed: int) -> None:
        """Write down that an attempt at a run begins. It survives a SIGKILL from then on."""
        self._number[episode, seed] = self.of(episode, seed) + 1
        line = {"episode": episode, "seed": seed, "attempt": self._number[episode, seed]}
        try:
            durable_append(self._path, f"{json.dumps(line)}\n".encode())
        except OSError as error:
            error.says_all = True  # type: ignore[attr-defined]  # a full disk is not the agent's fault
            raise


def _numbers(content: bytes) -> dict[tuple[str, int], int]:
    """Count the attempts in the bytes of a file. A torn line does not count: nothing was shown after it."""
    found: dict[tuple[str, int], int] = {}
    for line in content.splitlines():
        with suppress(ValueError, KeyError, TypeError):
            one = json.loads(line)
            at = one["episode"], int(one["seed"])
            found[at] = max(found.get(at, 0), int(one["attempt"]))
    return found


class CountedAgent:
    """An agent whose attempt is noted before its first observation. begin: notes it."""

    def __init__(self, agent: Any, begin: Callable[[], None]) -> None:
        self._agent, self._begin, self._began = agent, begin, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._agent, name)

    def act(self, observation: Observation) -> Action:
        """See `Agent.act`."""
        if not self._began:
            self._begin()
            self._began = True
        action: Action = self._agent.act(observation)
        return action


def joined(directories: Iterable[Path]) -> bytes:
    """Join the files of several evaluations; an attempt that is in two of them is one."""
    files = [path for directory in directories if (path := directory / FILE).is_file()]
    return b"".join(dict.fromkeys(line + b"\n" for path in files for line in path.read_bytes().splitlines() if line))

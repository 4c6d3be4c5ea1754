"""Where an agent is that does not run in the evaluator's process, as a value that a worker can be sent."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from ovman.remote.agent import Remotes
from ovman.remote.process import AgentProcess
from ovman.settings.remote import Remote


@dataclass(frozen=True, slots=True)
class Server:
    """A server that listens already. url: ws://host:port."""

    url: str
    limits: Remote

    @contextmanager
    def opened(self) -> Iterator[Remotes]:
        """What makes its agents. It is dialled at the first."""
        with Remotes(lambda: self.url, self.limits) as remotes:
            yield remotes


@dataclass(frozen=True, slots=True)
class OwnProcess:
    """A server that is started on this machine. arguments, log: as of `AgentProcess`."""

    arguments: tuple[str, ...]
    limits: Remote
    log: Path

    @contextmanager
    def opened(self) -> Iterator[Remotes]:
        """What makes its agents. It is started at the first, and ended with the context."""
        with ExitStack() as until:
            process = until.enter_context(AgentProcess(self.arguments, self.limits, self.log))
            yield until.enter_context(Remotes(process.address, self.limits, process))


Elsewhere = Server | OwnProcess

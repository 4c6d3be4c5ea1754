"""An agent in a process of its own, as the evaluator sees it: the four methods, each a message and its reply."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ovman.agents.interface import Action, Observation, Query, Visit
from ovman.remote import wire
from ovman.remote.line import Line, LineLost
from ovman.remote.process import AgentProcess
from ovman.runner import Run
from ovman.settings.remote import Remote

VISITS_KEPT = 2
"""Visits that are kept as messages, of some 15 MB each: all seeds of an episode have them in common."""


class RemoteAgent:
    """An `Agent` at the other end of a line, for one run. run: the run."""

    looks = True

    def __init__(self, line: Line, run: Run, limits: Remote, tours: Tours) -> None:
        self._line, self._limits, self._tours = line, limits, tours
        self._left_s = limits.run_s
        self._done(wire.begin(run), limits.tour_s)

    def familiarise(self, visit: Visit) -> None:
        """See `Agent.familiarise`. LineLost, AgentError: as for `Line.ask`."""
        self._done({"type": "familiarise", "visit": self._tours(visit)}, self._limits.tour_s)

    def revisit(self, visit: Visit) -> None:
        """See `Agent.revisit`. LineLost, AgentError: as for `Line.ask`."""
        self._done({"type": "revisit", "visit": self._tours(visit)}, self._limits.tour_s)

    def ask(self, query: Query) -> None:
        """See `Agent.ask`. LineLost, AgentError: as for `Line.ask`."""
        reply = self._done({"type": "ask", "query": wire.query(query)}, self._limits.tour_s)
        self.looks = reply.get("looks") is not False

    def act(self, observation: Observation) -> Action:
        """See `Agent.act`. LineLost for what is no action, and as for `Line.ask`."""
        reply = self._ask({"type": "act", "observation": wire.observation(observation)}, self._limits.act_s)
        if reply["type"] == "action":
            try:
                return Action(str(reply.get("action")))
            except ValueError:
                pass
        self._line.close()
        names = ", ".join(Action)
        raise LineLost(f"act: the reply {str(reply.get('action', reply['type'])):.40} is no action; answer one of {names}")

    def _done(self, message: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        reply = self._ask(message, limit_s)
        if reply["type"] != "done":
            self._line.close()
            raise LineLost(f"{message['type']}: the reply is {reply['type']:.40}, not done; answer as the protocol says")
        return reply

    def _ask(self, message: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        """The reply to a message, within the time of the message and within what is left of the run's."""
        began = time.monotonic()
        try:
            return self._line.ask(message, min(limit_s, self._left_s))
        except LineLost as error:
            if time.monotonic() - began < self._left_s:
                raise
            whole = f"the agent has taken {self._limits.run_s:g} s of the run; answer sooner, or raise remote.run_s"
            raise LineLost(f"{message['type']}: {whole}") from error
        finally:
            self._left_s = max(0.0, self._left_s - (time.monotonic() - began))


class Tours:
    """Visits as parts of messages; the last few are kept by what they show."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Sequence[dict[str, Any]]] = OrderedDict()

    def __call__(self, visit: Visit) -> dict[str, Any]:
        """The visit as a part of a message."""
        if visit.content is None:
            return wire.visit(visit, [wire.observation(seen) for seen in visit.observations])
        if visit.content not in self._kept:
            self._kept[visit.content] = [wire.observation(seen) for seen in visit.observations]
        self._kept.move_to_end(visit.content)
        while len(self._kept) > VISITS_KEPT:
            self._kept.popitem(last=False)
        return wire.visit(visit, self._kept[visit.content])


class Remotes:
    """Makes the agents of an evaluation, over one line that is dialled again where it was lost. A context manager.

    address: says where to dial, and starts what is to be dialled where that is the evaluator's part. process: what it starts.
    """

    def __init__(self, address: Callable[[], str], limits: Remote, process: AgentProcess | None = None) -> None:
        self._address, self._limits, self._process, self._tours = address, limits, process, Tours()
        self._line: Line | None = None

    def __call__(self, run: Run) -> RemoteAgent:
        """An agent for a run. LineLost, AgentError: as for `Line`."""
        line = self.line()
        if self._process is not None:
            self._process.clean()
        return RemoteAgent(line, run, self._limits, self._tours)

    def line(self) -> Line:
        """The line, dialled where there is none. AgentError as for `Line`."""
        if self._line is None:
            why = None if self._process is None else self._process.passed_limit
            self._line = Line(self._address(), self._limits.connect_s, why)
        return self._line

    def lost(self) -> None:
        """The line is of no use any more, nor is who was at its end."""
        if self._line is not None:
            self._line.close()
        self._line = None
        if self._process is not None:
            self._process.end()

    def __enter__(self) -> Remotes:
        return self

    def __exit__(self, *error: object) -> None:
        self.lost()

"""From "module:function" in an arm's entry to the function, and what is said where one of the agents fails."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ovman.agents.interface import LETTERS, Action, Agent, Observation, Query, Visit
from ovman.settings import Arm
from ovman.workflow import at_work


class AgentError(RuntimeError):
    """An arm's agent is missing or failed; one line that names the key, the place and the remedy."""

    says_all = True


@cache
def function(name: str, agent: str) -> Callable[..., Any]:
    """The function that the arm `name` names as "module:function". AgentError where it is missing."""
    key = f"arms.{name}.agent is {agent!r}"
    module, _, attribute = agent.partition(":")
    with failures(f"{key}: importing {module}"):
        try:
            there = find_spec(module) is not None
        except ModuleNotFoundError:
            there = False
        if there:
            found: Callable[..., Any] | None = getattr(import_module(module), attribute, None)
    if not there:
        raise AgentError(f"{key}, and there is no module {module}; install it, or put it beside the overlay")
    if found is None or not callable(found):
        raise AgentError(f"{key}, and {module} has no function {attribute}; name one that it has")
    return found


@contextmanager
def failures(doing: str) -> Iterator[None]:
    """Turns what an agent raises, SystemExit included, into an AgentError of one line, and prints the traceback before.

    doing: arm, episode and call. It is noted, so that the death of the process names it as well.
    """
    at_work.note(doing)
    try:
        yield
    except AgentError:
        raise
    except (Exception, SystemExit) as error:
        if getattr(error, "says_all", False):  # a damaged file is not the agent's fault
            raise
        traceback.print_exception(error)
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(last.filename).name}, line {last.lineno}"
        said = " ".join(str(error).split()) or "no message"
        raise AgentError(f"{doing} raised {type(error).__name__} in {place}: {said}; mend the agent") from None


class Supervised:
    """An agent whose failures name the arm and the episode, and whose actions are verified."""

    def __init__(self, agent: Any, arm: Arm, run: str) -> None:
        self._where = f"arms.{arm.name}.agent is {arm.agent!r}: {run}: "
        absent = [method for method in ("familiarise", "revisit", "ask", "act") if not callable(getattr(agent, method, None))]
        if absent:
            raise AgentError(f"{self._where}{type(agent).__name__} has no method {absent[0]}; an agent has it (docs/agents.md)")
        self._agent: Agent = agent
        self._actions: list[Action] = []

    @property
    def trace(self) -> str:
        """What the agent has done until now, a letter an action (`LETTERS`)."""
        return "".join(LETTERS[action] for action in self._actions)

    @property
    def looks(self) -> bool:
        """Whether the agent takes images while it drives (`Agent`)."""
        return bool(getattr(self._agent, "looks", True))

    def familiarise(self, visit: Visit) -> None:
        """See `Agent.familiarise`. AgentError where the agent raises."""
        with failures(f"{self._where}familiarise"):
            self._agent.familiarise(visit)

    def revisit(self, visit: Visit) -> None:
        """See `Agent.revisit`. AgentError where the agent raises."""
        with failures(f"{self._where}revisit"):
            self._agent.revisit(visit)

    def ask(self, query: Query) -> None:
        """See `Agent.ask`. AgentError where the agent raises."""
        with failures(f"{self._where}ask"):
            self._agent.ask(query)

    def act(self, observation: Observation) -> Action:
        """See `Agent.act`. AgentError where the agent raises or returns no `Action`."""
        with failures(f"{self._where}act"):
            action = self._agent.act(observation)
        if not isinstance(action, Action):
            raise AgentError(f"{self._where}act returned {action!r}; return an ovman.agents.interface.Action")
        self._actions.append(action)
        return action

"""Agents as the evaluator calls them: imported by name, with failures in one line and actions that are verified."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partialmethod
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from ovman.agents.interface import Action
from ovman.settings import Arm

METHODS = ("familiarise", "revisit", "ask", "act")


class AgentError(RuntimeError):
    """An arm's agent is missing or failed; one line that names the key, the place and the remedy."""

    says_all = True


@cache
def load_agent(name: str, agent: str) -> Callable[..., Any]:
    """Import the function or class that the arm `name` names as "module:function".

    Raises:
        AgentError: It is missing, or its module cannot be imported.
    """
    key = f"arms.{name}.agent is {agent!r}"
    module, _, attribute = agent.partition(":")
    with name_failures(f"{key}: importing {module}"):
        found = getattr(import_module(module), attribute, None)
    if not callable(found):
        raise AgentError(f"{key}, and {module} has no function {attribute}; name one that it has")
    return cast(Callable[..., Any], found)


@contextmanager
def name_failures(doing: str) -> Iterator[None]:
    """Turn what an agent raises, SystemExit included, into an AgentError of one line, and print the traceback before.

    doing: Arm, episode and call, for the message.
    """
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


class SupervisedAgent:
    """An agent whose failures name the arm and the episode, and whose actions are verified."""

    def __init__(self, agent: Any, arm: Arm, run: str) -> None:
        """Wrap an agent. run: Episode and seed, for messages."""
        self._where = f"arms.{arm.name}.agent is {arm.agent!r}: {run}: "
        if absent := [method for method in METHODS if not callable(getattr(agent, method, None))]:
            raise AgentError(f"{self._where}{type(agent).__name__} has no method {absent[0]}; an agent has it (docs/agents.md)")
        self._agent = agent

    @property
    def looks(self) -> bool:
        """Whether the agent takes images while it drives (`Agent`)."""
        return bool(getattr(self._agent, "looks", True))

    def _call(self, method: str, given: Any) -> Any:
        with name_failures(f"{self._where}{method}"):
            returned = getattr(self._agent, method)(given)
        if method == "act" and not isinstance(returned, Action):
            raise AgentError(f"{self._where}act returned {returned!r}; return an ovman.agents.interface.Action")
        return returned

    familiarise = partialmethod(_call, "familiarise")
    revisit = partialmethod(_call, "revisit")
    ask = partialmethod(_call, "ask")
    act = partialmethod(_call, "act")

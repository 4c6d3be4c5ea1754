"""The table of actions, and the errors of actions.

An action is a function `f(session, argument, ...)` whose keyword signature is the action's: names, types and defaults of the
arguments are read from it, and `**rest` accepts any further argument. Several functions of one name are overloads.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, get_type_hints

from ovman_engine.world.errors import Refused


@dataclass(frozen=True)
class Parameter:
    """An argument of an action. `kind` is its annotation without "| None"."""

    name: str
    kind: Any
    nullable: bool
    required: bool
    default: Any


@dataclass(frozen=True)
class Action:
    """One way to call an action."""

    name: str
    function: Callable[..., Any]
    parameters: tuple[Parameter, ...]
    takes_anything: bool
    mode: str | None = None
    """agentMode of the agents that have the action; None for all"""

    def bears(self, argument: str) -> bool:
        """Whether the action has an argument of this name."""
        return any(p.name == argument for p in self.parameters)


class Failed(Refused):
    """An action failed with one of AI2-THOR's error codes."""

    def __init__(self, message: str, code: str) -> None:
        """`code` is AI2-THOR's error code."""
        super().__init__(message)
        self.code = code


class Thrown(Refused):
    """An action failed with a .NET exception, which Unity reports as "<exception>: <message>. trace: <where>"."""

    def __init__(self, exception: str, message: str) -> None:
        """`exception` is the name of the .NET class. The trace names the function that called this."""
        super().__init__(f"{exception}: {message}. trace:   at {sys._getframe(1).f_code.co_name}")


def out_of_range(message: str) -> Thrown:
    """Return AI2-THOR's ArgumentOutOfRangeException.

    .NET takes the only argument for the name of a parameter, so the message reads like one.
    """
    return Thrown(
        "ArgumentOutOfRangeException", f"Specified argument was out of the range of valid values.\nParameter name: {message}"
    )


def null_reference() -> Thrown:
    """Return the NullReferenceException with which AI2-THOR answers null for a required text."""
    return Thrown("NullReferenceException", "Object reference not set to an instance of an object")


TABLE: dict[str, list[Action]] = {}


def action(name: str, mode: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register the decorated function as the action `name`, for all agents or for those of one agentMode."""

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        TABLE.setdefault(name, []).append(_described(name, function, mode))
        return function

    return register


def _described(name: str, function: Callable[..., Any], mode: str | None) -> Action:
    hints = get_type_hints(function)
    parameters, takes_anything = [], False
    for parameter in list(inspect.signature(function).parameters.values())[1:]:
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            takes_anything = True
            continue
        kind = hints[parameter.name]
        options = [k for k in getattr(kind, "__args__", ()) if k is not type(None)]
        nullable = type(None) in getattr(kind, "__args__", ())
        required = parameter.default is inspect.Parameter.empty
        parameters.append(
            Parameter(
                parameter.name, options[0] if nullable else kind, nullable, required, None if required else parameter.default
            )
        )
    return Action(name, function, tuple(parameters), takes_anything, mode)

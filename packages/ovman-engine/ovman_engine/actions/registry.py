"""The table of actions, and how an action says that it did not succeed.

An action is a function `f(session, argument, ...)` whose keyword signature is the action's: names, types and defaults of the
arguments are read from it, and a `**rest` accepts anything besides. Several functions of one name are overloads.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, get_type_hints

from ovman_engine.world.world import Refused


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
    """agentMode of the agents that have it; None for all"""

    def bears(self, argument: str) -> bool:
        return any(p.name == argument for p in self.parameters)


class Failed(Refused):
    """An action that did not succeed and has one of AI2-THOR's error codes."""

    def __init__(self, message: str, code: str) -> None:
        super().__init__(message)
        self.code = code


class Thrown(Refused):
    """What Unity reports when an action throws: "<exception>: <message>. trace: <where>"."""

    def __init__(self, exception: str, message: str) -> None:
        super().__init__(f"{exception}: {message}. trace:   at {sys._getframe(1).f_code.co_name}")


def out_of_range(message: str) -> Thrown:
    """.NET's ArgumentOutOfRangeException takes its only argument for the name of a parameter, and so do AI2-THOR's messages."""
    return Thrown(
        "ArgumentOutOfRangeException", f"Specified argument was out of the range of valid values.\nParameter name: {message}"
    )


def null_reference() -> Thrown:
    """.NET's NullReferenceException: what AI2-THOR answers when an action needs a text and is given null."""
    return Thrown("NullReferenceException", "Object reference not set to an instance of an object")


TABLE: dict[str, list[Action]] = {}


def action(name: str, mode: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Registers the function below under AI2-THOR's `name` of an action, for all agents or for those of one agentMode."""

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

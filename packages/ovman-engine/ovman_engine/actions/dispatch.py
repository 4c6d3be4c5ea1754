"""Calls the function of an action, by AI2-THOR's rules and with its error codes.

Functions are matched by argument names alone: among the overloads of an action, the one with most of the given names is called.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ovman_engine import MASKS_ONLY, STRICT
from ovman_engine.actions import TABLE
from ovman_engine.actions.registry import Action, Failed, Parameter
from ovman_engine.actions.values import CLR_NAMES, NAMES, Inconvertible, Malformed, Vector3, converted, shown
from ovman_engine.client.event import Outcome, thrown
from ovman_engine.world.errors import Refused

if TYPE_CHECKING:
    from ovman_engine.client.session import Session

ALWAYS_ACCEPTED = frozenset(
    {
        "action",
        "agentId",
        "renderClassImage",
        "renderImage",
        "renderInstanceSegmentation",
        MASKS_ONLY,
        "renderNormalsImage",
        "renderObjectImage",
        "renderSemanticSegmentation",
        "sequenceId",
    }
)
"""Keys that any action may carry: the engine reads them, or the client adds them."""


def perform(session: Session, request: Mapping[str, Any]) -> Outcome:
    """Perform the action that `request` names. Never raises: every error becomes a failed outcome."""
    name = request.get("action")
    arguments = {k: v for k, v in request.items() if k != "action"}
    try:
        action = _matched(session, name, arguments)
        return Outcome(action.function(session, **_bound(action, arguments)))
    except Refused as refusal:
        return Outcome(success=False, message=str(refusal), code=getattr(refusal, "code", None))
    except Exception as error:
        return thrown(error)


def _matched(session: Session, name: Any, arguments: Mapping[str, Any]) -> Action:
    overloads = TABLE.get(name, []) if isinstance(name, str) else []
    overloads = [a for a in overloads if a.mode is None or a.mode == session.agent_mode]
    if not overloads:
        raise Failed(f"Invalid action: {shown(name)}", "InvalidAction")
    ordered = sorted(overloads, key=lambda a: (sum(p.required for p in a.parameters), len(a.parameters)))
    return max(ordered, key=lambda a: sum(a.bears(k) for k in arguments))


def _bound(action: Action, arguments: Mapping[str, Any]) -> dict[str, Any]:
    unknown = [k for k in arguments if not action.bears(k) and k not in ALWAYS_ACCEPTED]
    if unknown and os.environ.get(STRICT) == "1":
        raise Failed(f"{action.name} does not know the argument {_quoted(unknown)} ({STRICT}=1)", "InvalidArgument")
    if unknown and not action.takes_anything:
        raise Failed(_superfluous(action, arguments, unknown), "InvalidArgument")
    bound = {p.name: _value(action, p, arguments[p.name]) for p in action.parameters if p.name in arguments}
    missing = [p.name for p in action.parameters if p.required and p.name not in arguments]
    if missing:
        raise Failed(f"action: {action.name} is missing the following arguments: {','.join(missing)}", "MissingArguments")
    return bound


def _value(action: Action, parameter: Parameter, value: Any) -> Any:
    if value is None and (parameter.nullable or parameter.kind in (str, Any)):
        return None
    try:
        return converted(value, parameter.kind)
    except Inconvertible as error:
        if action.takes_anything:
            raise Refused(f"Newtonsoft.Json.JsonReaderException: Could not convert {error}. Path '{parameter.name}'.") from None
        message = f"action: {action.name} has an invalid argument: {parameter.name} (=={shown(value)}). Cannot convert to: "
        raise Failed(message + NAMES.get(parameter.kind, _clr(parameter)), "InvalidArgument") from None
    except Malformed as error:
        raise Refused(f"Newtonsoft.Json.JsonSerializationException: {error} Path '{parameter.name}'.") from None


def _superfluous(action: Action, arguments: Mapping[str, Any], unknown: list[str]) -> str:
    plural = "s" if len(unknown) > 1 else ""
    ways = "\n\t\t".join(
        f"Void {way.name}({', '.join(map(_signature, way.parameters))})" for way in TABLE[action.name] if way.mode == action.mode
    )
    return (
        f'\n\tAction: "{action.name}" called with invalid argument{plural}: {_quoted(unknown)}'
        f"\n\tExpected arguments: {', '.join(map(_signature, action.parameters))}"
        f"\n\tYour arguments: {_quoted(k for k in arguments if k not in ALWAYS_ACCEPTED)}"
        f'\n\tValid ways to call "{action.name}" action:\n\t\t{ways}'
    )


def _quoted(names: Any) -> str:
    return ", ".join(f"'{n}'" for n in names)


def _clr(parameter: Parameter) -> str:
    if parameter.nullable and parameter.kind in (float, int, bool, Vector3):
        return "Nullable`1"
    return CLR_NAMES.get(parameter.kind, "List`1")


def _signature(parameter: Parameter) -> str:
    return f"{_clr(parameter)} {parameter.name}" + ("" if parameter.required else f" = {shown(parameter.default)}")

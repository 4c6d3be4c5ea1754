"""Faults that pydantic finds in records and settings, in plain words."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_KINDS = {
    "bool_type": "true or false",
    "dict_type": "an object",
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_from_float": "an integer",
    "int_parsing": "an integer",
    "int_type": "an integer",
    "list_type": "a list",
    "model_attributes_type": "an object",
    "model_type": "an object",
    "string_too_short": "text",
    "string_type": "text",
    "tuple_type": "a list",
}
_BOUNDS = {"greater_than": ("gt", "above"), "greater_than_equal": ("ge", "at least"), "less_than": ("lt", "below")} | {
    "less_than_equal": ("le", "at most"),
    "multiple_of": ("multiple_of", "a multiple of"),
}


def show(value: Any, length: int = 60) -> str:
    """Return a value as messages show it, in JSON of at most `length` characters."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= length else text[: length - 3] + "..."


def printable(text: str) -> str:
    r"""Return the text with everything that a terminal would not show as a character escaped: a line feed as \n."""
    return "".join(one if one.isprintable() else one.encode("unicode_escape").decode() for one in text)


def options_of(error: ErrorDetails) -> list[str] | None:
    """Return the values that a field allows, if the error is that a value is not one of them."""
    if error["type"] not in ("enum", "literal_error"):
        return None
    return [option.strip().strip("'") for option in str(error["ctx"]["expected"]).replace(" or ", ", ").split(",")]


def requirement(error: ErrorDetails) -> str | None:
    """Return what a field expects, such as "a number above 0", or None for an error of another kind."""
    kind, context = error["type"], error.get("ctx", {})
    if kind in _BOUNDS:
        name, word = _BOUNDS[kind]
        return f"{word} {context[name]:g}"
    if kind in ("too_short", "too_long"):
        word, bound = ("at least", "min_length") if kind == "too_short" else ("at most", "max_length")
        return f"a list of {word} {context[bound]} element(s)"
    if kind == "string_pattern_mismatch":
        return f"text like {context['pattern']}"
    options = options_of(error)
    return _KINDS.get(kind) if options is None else f"one of {', '.join(options)}"

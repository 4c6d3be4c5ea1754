"""Reads the requests of a client from action frames."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_SEQUENCE_ID = 1000
"""Longest sequence id that is a text, characters."""


class Unintelligible(ValueError):
    """The bytes are not a JSON object."""


def decoded(body: bytes) -> dict[str, Any]:
    """Return the action in `body` (UTF-8 JSON, one object). Raises Unintelligible for anything else.

    NaN and Infinity are accepted, as by Unity's reader; arguments are checked where they are converted.
    """
    try:
        request = json.loads(body)
        if b"\\u" in body:  # unpaired surrogates cannot be sent back
            request = json.loads(json.dumps(request, ensure_ascii=False).encode("utf-8", "replace"))
    except RecursionError:
        raise Unintelligible("An action is a JSON object: this one is nested too deeply.") from None
    except ValueError as error:
        raise Unintelligible(f"An action is a JSON object: {error}.") from None
    if not isinstance(request, dict):
        raise Unintelligible(f"An action is a JSON object, not {request!r:.100}.")
    return request


def sequence_id(request: Mapping[str, Any]) -> int | float | str | None:
    """Return the sequence id of the reply: as given if it is a number or a text that a message can carry, else 0."""
    value = request.get("sequenceId", 0)
    if isinstance(value, int):
        return value if -(2**63) <= value < 2**64 else 0
    if isinstance(value, str):
        return value[:MAX_SEQUENCE_ID]
    return value if isinstance(value, float) or value is None else 0

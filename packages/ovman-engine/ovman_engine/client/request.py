"""What a client asks for, from the bytes of an action frame."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_SEQUENCE_ID = 1000
"""Characters of a sequence number that is a text."""


class Unintelligible(ValueError):
    """The bytes are no JSON object."""


def decoded(body: bytes) -> dict[str, Any]:
    """The action in `body` (UTF-8 JSON, one object). Unintelligible if there is none, however it is malformed.

    NaN and Infinity are let through, as Unity's reader does; arguments that must be finite are checked where they are converted.
    """
    try:
        request = json.loads(body)
        if b"\\u" in body:  # halves of surrogate pairs, which no message can carry back
            request = json.loads(json.dumps(request, ensure_ascii=False).encode("utf-8", "replace"))
    except RecursionError:
        raise Unintelligible("An action is a JSON object: this one is nested too deeply.") from None
    except ValueError as error:
        raise Unintelligible(f"An action is a JSON object: {error}.") from None
    if not isinstance(request, dict):
        raise Unintelligible(f"An action is a JSON object, not {request!r:.100}.")
    return request


def sequence_id(request: Mapping[str, Any]) -> int | float | str | None:
    """The number that the reply must bear, as it was given; 0 for what is no number or text, or none that a message can bear."""
    value = request.get("sequenceId", 0)
    if isinstance(value, int):
        return value if -(2**63) <= value < 2**64 else 0
    if isinstance(value, str):
        return value[:MAX_SEQUENCE_ID]
    return value if isinstance(value, float) or value is None else 0
